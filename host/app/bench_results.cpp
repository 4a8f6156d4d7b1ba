#include "host/app/bench_results.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace lockstep::app {

namespace {

using json = nlohmann::ordered_json;

// Quoted where a comma or a quote would make two fields of it.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : std::string(); }

}  // namespace

std::span<const CaseError> BenchCase::quantities() const {
  for (const BenchTrial& t : trials)
    if (!t.errors.empty()) return t.errors;
  return {};
}

std::string csv_header() {
  return "case,device,precision,method,dt_s,substeps,sweeps,steps,ms_per_step,ms_per_second,quantity,unit,exact,"
         "error,"
         "residual,failure\n";
}

std::string to_csv(const BenchCase& benched, const BenchTrial& t) {
  const std::string of_trial = fmt::format(
      "{},{},{},{},{:.9g},{},{},{},{:.4g},{:.4g}", benched.name, field(t.device), t.precision, field(t.method), t.dt,
      t.substeps, t.sweeps ? std::to_string(*t.sweeps) : "", t.steps, t.ms_per_step, t.ms_per_second());
  if (!t.failure.empty()) return fmt::format("{},,,,,,{}\n", of_trial, field(t.failure));
  std::string lines;
  for (const CaseError& e : t.errors)
    lines += fmt::format("{},{},{},{:.10g},{:.4g},{},\n", of_trial, field(e.quantity), e.unit, e.exact, e.error,
                         number(t.residual));
  return lines;
}

json to_json(const BenchTrial& t) {
  json errors = json::array();
  for (const CaseError& e : t.errors)
    errors.push_back({{"quantity", e.quantity}, {"unit", e.unit}, {"exact", e.exact}, {"error", e.error}});
  return {{"device", t.device},
          {"precision", t.precision},
          {"method", t.method},
          {"dt", t.dt},
          {"substeps", t.substeps},
          {"sweeps", t.sweeps ? json(*t.sweeps) : json()},
          {"steps", t.steps},
          {"ms_per_step_median", t.ms_per_step},
          {"ms_per_second", t.ms_per_second()},
          {"residual_median", t.residual ? json(*t.residual) : json()},
          {"errors", errors},
          {"failure", t.failure.empty() ? json() : json(t.failure)}};
}

BenchTrial trial_of(const nlohmann::json& object) {
  BenchTrial t = {.device = object["device"],
                  .precision = object["precision"],
                  .method = object["method"],
                  .dt = object["dt"],
                  .substeps = object["substeps"],
                  .ms_per_step = object["ms_per_step_median"],
                  .steps = object["steps"]};
  if (const auto& sweeps = object["sweeps"]; !sweeps.is_null()) t.sweeps = sweeps.get<u32>();
  if (const auto& residual = object["residual_median"]; !residual.is_null()) t.residual = residual.get<double>();
  for (const auto& e : object["errors"]) t.errors.push_back({e["quantity"], e["unit"], e["exact"], e["error"]});
  if (const auto& failure = object["failure"]; !failure.is_null()) t.failure = failure;
  return t;
}

std::string to_json(const std::vector<BenchCase>& cases) {
  json all = json::array();
  for (const BenchCase& benched : cases) {
    json trials = json::array();
    for (const BenchTrial& t : benched.trials) trials.push_back(to_json(t));
    all.push_back({{"case", benched.name}, {"says", benched.says}, {"trials", trials}});
  }
  return all.dump(2) + "\n";
}

}  // namespace lockstep::app
