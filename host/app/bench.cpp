#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/app/bench_results.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/backends/canary.hpp"
#include "host/cases/subprocess.hpp"
#include "host/error.hpp"
#include "host/record/whole_file.hpp"
#include "host/scene/read.hpp"
#include "host/stop_request.hpp"

namespace lockstep::app {

namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  std::vector<std::string> cases, devices = {"auto"}, precisions = {"float", "double"}, methods;
  std::string out = "out/bench";
  std::size_t settings = 100;
  u32 repetitions = 1;
  bool list = false;
};

std::vector<std::string> names_of(const std::vector<HardCase>& cases) {
  std::vector<std::string> names;
  for (const HardCase& one : cases) names.push_back(one.name);
  return names;
}

std::vector<const HardCase*> chosen(const BenchOptions& options) {
  std::vector<const HardCase*> cases;
  if (options.cases.empty())
    for (const HardCase& one : hard_cases()) cases.push_back(&one);
  for (const std::string& name : options.cases) {
    const auto found = std::ranges::find(hard_cases(), name, &HardCase::name);
    if (found == hard_cases().end())
      throw Error(Failure::input, name,
                  fmt::format("there is no such case; there are {}", fmt::join(names_of(hard_cases()), ", ")));
    cases.push_back(&*found);
  }
  return cases;
}

// A name that is no method of any of the cases is a mistake.
void expect_methods(const std::vector<const HardCase*>& cases, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto has = [&](const HardCase* one) {
      return std::ranges::find(one->methods, name, &Method::name) != one->methods.end();
    };
    if (std::ranges::none_of(cases, has))
      throw Error(Failure::input, "--method", "none of the cases has a method '" + name + "'");
  }
}

// What there is to say of a device.
struct BenchDevice {
  std::string choice, name;  // as the command line has it, and in words
  bool fp64 = true;
  std::string verdicts = {};  // of the canary, in every precision; none of the reference

  std::string in_words() const {
    return verdicts.empty() ? "the plain C++ reference" : fmt::format("{} ({})", name, verdicts);
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(BenchDevice, choice, name, fp64, verdicts)

BenchDevice ask(const std::string& choice, const std::vector<std::string>& precisions) {
  const std::optional<DeviceInfo> device = select_device(choice);
  if (!device) return {choice, "reference"};
  std::vector<std::string> verdicts;
  for (const std::string& precision : precisions)
    if (precision == "float" || device->fp64)
      verdicts.push_back(fmt::format("{}: {}", precision, verdict_in_words(*device, precision == "double")));
  return {choice, device->name, device->fp64, fmt::format("{}", fmt::join(verdicts, ", "))};
}

// OpenCL is asked by a process apart, so that this one can start others.
std::vector<BenchDevice> ask_all(const BenchOptions& options) {
  const nlohmann::json devices = run_in_subprocess([&] {
    std::vector<BenchDevice> asked;
    for (const std::string& choice : options.devices) asked.push_back(ask(choice, options.precisions));
    return asked;
  });
  return devices.get<std::vector<BenchDevice>>();
}

// Where the figures go: a table that is whole after every trial, a page and an object that are after every case. A case
// that was interrupted has the trials that were done.
class BenchFiles {
 public:
  BenchFiles(const std::string& folder, std::string machine) : folder_(folder), machine_(std::move(machine)) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw Error(Failure::input, folder, "the folder cannot be made: " + error.message());
    for (const auto& [name, signature] : {std::pair{"bench.csv", "case,"}, {"bench.json", "["}, {"index.html", "<!"}})
      expect_writable((folder_ / name).string(), "this table of the bench", signature);
    table_.open(folder_ / "bench.csv");
    if (!(table_ << csv_header() << std::flush))
      throw Error(Failure::input, (folder_ / "bench.csv").string(), "cannot be written");
  }

  void add(const BenchCase& benched, const BenchTrial& trial) {
    if (!(table_ << to_csv(benched, trial) << std::flush)) fail("bench.csv");
  }

  void add(const BenchCase& benched) {
    const fs::path plot = folder_ / (benched.name + ".svg");
    std::stringstream svg;
    if (plots_ && write_plot(benched, plot.string())) svg << std::ifstream(plot).rdbuf();
    cases_.push_back(benched);
    drawn_.push_back(svg.str());
    write("bench.json", to_json(cases_));
    write("index.html", to_html(cases_, drawn_, machine_));
  }

  bool plots() const { return plots_; }

 private:
  void write(const char* name, const std::string& text) {
    replace_file((folder_ / name).string(), {reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  }
  [[noreturn]] void fail(const char* name) const {
    throw Error(Failure::device, (folder_ / name).string(), "cannot be written to its end");
  }

  const fs::path folder_;
  const std::string machine_;
  const bool plots_ = can_plot();
  std::ofstream table_;
  std::vector<BenchCase> cases_;
  std::vector<std::string> drawn_;
};

BenchTrial try_once(const HardCase& one, const Method& method, const Setting& setting, const std::string& precision,
                    const BenchDevice& device) {
  Trial trial(method, setting, precision, select_device(device.choice));
  BenchTrial found = {.device = device.name, .precision = precision, .method = method.name};
  try {
    found.errors = one.run(trial);
  } catch (const Error& error) {
    if (error.failure() == Failure::device) throw;
    found.failure = error.what();
  }
  found.dt = trial.settings().dt;
  found.substeps = substeps_of(trial.settings());
  if (trial.swept()) found.sweeps = iterations_of(trial.settings());
  found.ms_per_step = trial.ms_per_step();
  found.steps = trial.steps();
  found.residual = trial.residual();
  return found;
}

// The fastest of all repetitions, each in a process of its own: what slows a run down is other work on the machine.
// The errors are the same.
BenchTrial try_out(const HardCase& one, const Method& method, const Setting& setting, const std::string& precision,
                   const BenchDevice& device, u32 repetitions) {
  const auto work = [&] {
    Interrupt::install();  // a trial has nothing to keep
    return to_json(try_once(one, method, setting, precision, device));
  };
  BenchTrial best = trial_of(run_in_subprocess(work));
  for (u32 i = 1; i < repetitions && best.failure.empty(); ++i) {
    BenchTrial again = trial_of(run_in_subprocess(work));
    if (again.ms_per_step < best.ms_per_step) best = std::move(again);
  }
  return best;
}

void print(const BenchTrial& t) {
  fmt::print("  {:<28} {:<7} {:>9.3g} {:>6} {:>7} {:>10.3g} {:>10.3g}  ", t.method, t.precision, t.dt, t.substeps,
             t.sweeps ? std::to_string(*t.sweeps) : "", t.ms_per_step, t.ms_per_second());
  if (t.failure.empty())
    fmt::print("{:>10.3g}  {}\n", t.errors[0].error, t.residual ? fmt::format("{:.2g}", *t.residual) : "");
  else
    fmt::print("{}\n", t.failure);
  std::fflush(stdout);
}

void bench(const HardCase& one, const BenchOptions& options, const std::vector<BenchDevice>& devices,
           BenchFiles& files) {
  const BenchDevice reference = {"reference", "reference"};
  BenchCase benched = {one.name, one.says, {}};
  fmt::print("{}: {}\n  {:<28} {:<7} {:>9} {:>6} {:>7} {:>10} {:>10}  {:>10}  residual\n", one.name, one.says, "method",
             "", "dt", "sub-st", "sweeps", "ms/step", "ms/s", "error");
  const auto run = [&](const Method& method, const std::string& precision, const BenchDevice& device) {
    for (std::size_t i = 0; i < std::min(options.settings, method.ladder.size()); ++i) {
      benched.trials.push_back(try_out(one, method, method.ladder[i], precision, device, options.repetitions));
      print(benched.trials.back());
      files.add(benched, benched.trials.back());
    }
  };
  const auto run_all = [&](const Method& method) {
    if (!options.methods.empty() && std::ranges::find(options.methods, method.name) == options.methods.end()) return;
    for (const std::string& precision : options.precisions) {
      if (method.oracle) {  // double, on the reference
        if (precision == "double") run(method, precision, reference);
        continue;
      }
      for (const BenchDevice& device : devices)
        if (device.fp64 || precision == "float") run(method, precision, device);
    }
  };
  try {
    for (const Method& method : one.methods) run_all(method);
  } catch (const Stopped&) {
    files.add(benched);
    throw;
  }
  files.add(benched);
}

void run(const BenchOptions& options) {
  const std::vector<const HardCase*> cases = chosen(options);
  if (options.list) {
    for (const HardCase* one : cases) fmt::print("{:<20}{}\n", one->name, one->says);
    return;
  }
  expect_methods(cases, options.methods);
  const std::vector<BenchDevice> devices = ask_all(options);
  std::vector<std::string> words;
  for (const BenchDevice& device : devices) words.push_back(device.in_words());
  BenchFiles files(options.out, fmt::format("{}", fmt::join(words, " and ")));
  Interrupt::defer();
  try {
    for (const HardCase* one : cases) bench(*one, options, devices, files);
  } catch (const Stopped&) {
    fmt::print("interrupted; ");
  }
  fmt::print("figures in {0}/bench.csv and bench.json, {1} in {0}/index.html\n", options.out,
             files.plots() ? "plots" : "without plots (install gnuplot for them) a page");
}

}  // namespace

void add_bench(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("bench", "Measure speed against error on hard cases with exact answers, for every method");
  const auto options = std::make_shared<BenchOptions>();
  command->add_option("cases", options->cases, "Cases to run (see --list); default: all");
  command
      ->add_option("--device", options->devices,
                   "Devices: auto, gpu, cpu, reference, or an index; several may be given")
      ->capture_default_str();
  command->add_option("--precision", options->precisions, "Precisions: float, double, or both")
      ->check(CLI::IsMember({"float", "double"}))
      ->capture_default_str();
  command->add_option("--method", options->methods, "Run only these methods, named as in the tables");
  command->add_option("--settings", options->settings, "Run only this many settings of each method, cheapest first")
      ->check(CLI::PositiveNumber);
  command->add_option("--repetitions", options->repetitions, "Repeat each trial this many times and keep the fastest")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for tables, plots and the page")->capture_default_str();
  command->add_flag("--list", options->list, "List cases and methods, run nothing");
  command->footer(
      "Error is measured against exact answers (docs/lab/bench.md). ms/s is what a second of simulated time costs.\n"
      "Examples:\n  lockstep bench                         # all of it: about an hour on two cores\n"
      "  lockstep bench slide_to_roll pyramid20 --precision float");
  command->callback([options] { run(*options); });
}

}  // namespace lockstep::app
