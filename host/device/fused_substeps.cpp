#include "host/device/fused_substeps.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/step.hpp"

namespace lockstep {

namespace {

constexpr const char *kernel_name = "fused_substeps", *values_name = "fused_values";

// Writes calls where another launcher enqueues.
class Writer final : public Launcher {
 public:
  Writer(std::span<const KernelSignature> kernels, const LaunchPlan& plan) : kernels_(kernels), plan_(plan) {}

  const LaunchPlan& plan() const override { return plan_; }
  void run(std::string_view kernel, u32, std::initializer_list<Argument> arguments) override {
    run_group(kernel, arguments);
  }
  void run_groups(std::string_view kernel, u32, std::initializer_list<Argument> arguments) override {
    run_group(kernel, arguments);
  }
  void run_group(std::string_view kernel, std::initializer_list<Argument> arguments) override;
  void scratch(std::string_view name, std::size_t words) override;

  FusedSubsteps finish(std::vector<Stage> stages);

 private:
  const KernelSignature& find(std::string_view kernel);
  std::string argument(const KernelParameter& parameter, std::initializer_list<Argument> given);
  void declare(const std::string& array, std::string type);

  std::span<const KernelSignature> kernels_;
  const LaunchPlan& plan_;
  FusedSubsteps fused_;
  std::string declarations_, calls_;
};

const KernelSignature& Writer::find(std::string_view kernel) {
  const auto found = std::ranges::find(kernels_, kernel, &KernelSignature::name);
  if (found == kernels_.end()) throw Error(Failure::device, kernel_name, "there is no kernel " + std::string(kernel));
  if (std::ranges::count(fused_.files, found->file) == 0) fused_.files.push_back(found->file);
  return *found;
}

// A parameter of the whole; where kernels take an array as different types, as the first of them.
void Writer::declare(const std::string& array, std::string type) {
  std::vector<KernelParameter>& declared = fused_.signature.parameters;
  if (std::ranges::find(declared, array, &KernelParameter::name) != declared.end()) return;
  if (const auto at = type.find("const "); at != std::string::npos) type.erase(at, std::string_view("const ").size());
  declarations_ += type + " " + array + ", ";
  declared.push_back({array, std::move(type), KernelParameter::Kind::written});
}

std::string Writer::argument(const KernelParameter& parameter, std::initializer_list<Argument> arguments) {
  if (parameter.kind == KernelParameter::Kind::params) return "current";
  const auto* given = std::ranges::find(arguments, parameter.name, &Argument::parameter);
  if (parameter.kind == KernelParameter::Kind::value) {
    if (given == arguments.end()) throw Error(Failure::device, kernel_name, "no value for " + parameter.name);
    fused_.values.push_back(std::get<u32>(given->value));
    return std::string(values_name) + "[" + std::to_string(fused_.values.size() - 1) + "]";
  }
  const std::string array =
      given == arguments.end() ? parameter.name : std::string(std::get<std::string_view>(given->value));
  declare(array, parameter.type);
  return "(" + parameter.type + ")" + array;
}

void Writer::run_group(std::string_view kernel, std::initializer_list<Argument> arguments) {
  std::string list;
  for (const KernelParameter& parameter : find(kernel).parameters)
    list += (list.empty() ? "" : ", ") + argument(parameter, arguments);
  calls_ += "    " + std::string(kernel) + "(" + list + ");\n    TEAM_BARRIER(counters);\n";
}

void Writer::scratch(std::string_view name, std::size_t words) {
  const auto found = std::ranges::find(fused_.scratch, name, &FusedSubsteps::Scratch::name);
  if (found == fused_.scratch.end())
    fused_.scratch.push_back({std::string(name), words});
  else
    found->words = std::max(found->words, words);
}

FusedSubsteps Writer::finish(std::vector<Stage> stages) {
  if (!fused_.values.empty()) {
    scratch(values_name, fused_.values.size());
    declare(values_name, "global u32*");
  }
  fused_.stages = std::move(stages);
  fused_.signature.name = kernel_name;
  fused_.signature.parameters.push_back({"params", "const StepParams", KernelParameter::Kind::params});
  declare("counters", "global u32*");
  fused_.text =
      std::string("kernel void ") + kernel_name + "(" + declarations_ + "const StepParams params) {\n" +
      "  StepParams current = params;\n  do {\n" + calls_ +
      "  } while (++current.substep < params.substeps);\n#if TEAM_IS_GRID\n  note_stalled_team(counters);\n#endif\n}\n";
  return std::move(fused_);
}

// Takes the stages of the second of two sub-steps: those that every sub-step runs.
struct SecondSubstep {
  std::vector<Stage> stages;
  void run(Stage stage, const StepParams<float>& params) {
    if (params.substep == 1) stages.push_back(stage);
  }
};

}  // namespace

bool FusedSubsteps::replaces(Stage stage) const { return std::ranges::find(stages, stage) != stages.end(); }

FusedSubsteps fuse_substeps(std::span<const KernelSignature> kernels, const LaunchPlan& plan) {
  StepParams<float> two_substeps = {};
  two_substeps.substeps = 2;
  SecondSubstep second;
  step(second, two_substeps);
  std::erase_if(second.stages, [&](Stage stage) { return !runs(stage, plan.features); });
  Writer writer(kernels, plan);
  for (const Stage stage : second.stages) launch(stage, writer);
  return writer.finish(std::move(second.stages));
}

}  // namespace lockstep
