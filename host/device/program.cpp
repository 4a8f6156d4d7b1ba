#include "host/device/program.hpp"

#include <cstdlib>
#include <optional>

#include "host/device/pocl_cache.hpp"

namespace lockstep {

namespace {

struct FeatureName {
  Feature feature;
  const char* name;
};
constexpr FeatureName feature_names[] = {
    {Feature::contacts, "CONTACTS"},
    {Feature::general_contacts, "GENERAL_CONTACTS"},
    {Feature::pivots, "PIVOTS"},
    {Feature::time_stepping, "TIME_STEPPING"},
    {Feature::runge_kutta, "RUNGE_KUTTA"},
    {Feature::gyroscopic, "GYROSCOPIC"},
    {Feature::manifolds, "MANIFOLDS"},
    {Feature::capsules, "CAPSULES"},
    {Feature::boxes, "BOXES"},
    {Feature::cylinders, "CYLINDERS"},
    {Feature::hulls, "HULLS"},
    {Feature::grid, "GRID"},
    {Feature::bvh, "BVH"},
    {Feature::events, "EVENTS"},
    {Feature::impacts, "IMPACTS"},
    {Feature::triggers, "TRIGGERS"},
    {Feature::continuous, "CONTINUOUS"},
    {Feature::queries, "QUERIES"},
    {Feature::soft_contacts, "SOFT_CONTACTS"},
    {Feature::joints, "JOINTS"},
    {Feature::soft_joints, "SOFT_JOINTS"},
    {Feature::patches, "PATCHES"},
    {Feature::coupled_normals, "COUPLED_NORMALS"},
    {Feature::jacobi, "JACOBI"},
    {Feature::tolerance, "TOLERANCE"},
    {Feature::gradient, "GRADIENT"},
    {Feature::dense, "DENSE"},
    {Feature::all_pairs, "ALL_PAIRS"},
    {Feature::loads, "LOADS"},
    {Feature::particles, "PARTICLES"},
    {Feature::shear_springs, "SHEAR_SPRINGS"},
    {Feature::joint_springs, "JOINT_SPRINGS"},
    {Feature::joints_ahead, "JOINTS_AHEAD"},
    {Feature::closed_joints, "CLOSED_JOINTS"},
    {Feature::separated_contacts, "SEPARATED_CONTACTS"},
    {Feature::screws, "SCREWS"},
    {Feature::joint_angles, "JOINT_ANGLES"},
    {Feature::joint_impedances, "JOINT_IMPEDANCES"},
    {Feature::couplings, "COUPLINGS"},
    {Feature::non_holonomic, "NON_HOLONOMIC"},
    {Feature::sleeping, "SLEEPING"},
    {Feature::facets, "FACETS"},
    {Feature::impact_laws, "IMPACT_LAWS"},
    {Feature::angular_friction, "ANGULAR_FRICTION"},
    {Feature::static_friction, "STATIC_FRICTION"},
    {Feature::elliptic_friction, "ELLIPTIC_FRICTION"},
    {Feature::partitions, "PARTITIONS"},
    {Feature::shape_trees, "SHAPE_TREES"},
    {Feature::articulations, "ARTICULATIONS"},
    {Feature::closures, "CLOSURES"},
    {Feature::seams, "SEAMS"},
    {Feature::moving_seams, "MOVING_SEAMS"},
};

cl::Program compile(const Device& device, const std::string& text, const std::string& options) {
  cl::Program program(device.context, text);
  try {
    program.build(std::vector<cl::Device>{device.handle}, options.c_str());
  } catch (const cl::BuildError& error) {
    std::string log;
    for (const auto& [built_for, lines] : error.getBuildLog()) log += "\n" + lines;
    throw Error(Failure::device, "building the kernels on " + device.info.name,
                opencl_error_name(error.err()) + ", options: " + options + log);
  }
  return program;
}

// A binary that the driver does not take is as good as none.
std::optional<cl::Program> from_binary(const Device& device, const std::vector<unsigned char>& binary,
                                       const std::string& options) {
  try {
    cl::Program program(device.context, {device.handle}, cl::Program::Binaries{binary});
    program.build(std::vector<cl::Device>{device.handle}, options.c_str());
    return program;
  } catch (const cl::Error&) {
    return std::nullopt;
  }
}

// pocl has a cache of its own, and compiles every kernel once more where its binary is asked for.
bool driver_keeps_programs(const DeviceInfo& device) {
  const char* cache = std::getenv("POCL_KERNEL_CACHE");
  return is_pocl(device) && !(cache && std::string_view(cache) == "0");
}

}  // namespace

std::string build_options(const DeviceInfo& device, const ProgramOptions& options, std::string_view text) {
  std::string all = "-cl-std=CL1.2";
  const auto define = [&](const std::string& name, const std::string& value) {
    if (text.find(name) != std::string_view::npos) all += " -D" + name + "=" + value;
  };
  define("REAL_IS_DOUBLE", options.double_precision ? "1" : "0");
  define("REAL", options.double_precision ? "double" : "float");
  define("LANES", std::to_string(options.lanes));
  define("TEAM_IS_GRID", options.team_is_grid ? "1" : "0");
  define("EACH_TAKES_NEIGHBOURS", options.lanes > 1 ? "1" : "0");
  for (const FeatureName& feature : feature_names)
    define(std::string("FEATURE_") + feature.name, has(options.features, feature.feature) ? "1" : "0");
  if (!options.optimize) all += " -cl-opt-disable";
  if (device.correct_divide_sqrt) all += " -cl-fp32-correctly-rounded-divide-sqrt";
  if (const char* more = std::getenv("LOCKSTEP_CL_OPTIONS")) all += std::string(" ") + more;
  return all;
}

Differ differ(std::string_view text) {
  const auto names = [&](std::string_view name) { return text.find(name) != std::string_view::npos; };
  if (names("FEATURE_BOXES")) return Differ::by_shapes;
  if (names("FEATURE_GENERAL_CONTACTS")) return Differ::by_contacts;
  return names("FEATURE_") ? Differ::by_bodies : Differ::in_nothing;
}

std::string program_preamble(const ProgramOptions& options) {
  std::string text = "#pragma OPENCL FP_CONTRACT OFF\n";
  if (options.double_precision) text += "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n";
  // vectors may be wider than a CPU's registers: functions pass them in memory then, all compiled for the same CPU
  text += "#if __clang_major__ >= 12\n#pragma clang diagnostic ignored \"-Wpsabi\"\n#endif\n";
  return text;
}

BuiltProgram& build_program(Device& device, const std::string& text, const ProgramOptions& options) {
  const std::lock_guard lock(device_mutex());
  if (options.double_precision && !device.info.fp64)
    throw Error(Failure::device, device.info.name, "has no double precision, run with --precision float");
  const std::string with = build_options(device.info, options, text);
  const std::string whole = program_preamble(options) + text;
  BuiltProgram& built = device.programs[with + "\n" + whole];
  if (built.program() != nullptr) return built;
  const DeviceInfo& info = device.info;
  built.key =
      make_cache_key({whole, with, info.name, info.vendor, info.platform, info.opencl_version, info.driver_version});
  if (const auto binary = ProgramCache::of_user().load(built.key)) {
    if (auto program = from_binary(device, *binary, with)) {
      built.program = std::move(*program);
      built.on_disk = true;
      return built;
    }
  }
  built.program = opencl_guard("building the kernels on " + info.name, [&] { return compile(device, whole, with); });
  return built;
}

void save_program(const Device& device, BuiltProgram& built) {
  const std::lock_guard lock(device_mutex());
  const ProgramCache cache = ProgramCache::of_user();
  if (!cache.exists() || built.on_disk || built.program() == nullptr || driver_keeps_programs(device.info)) return;
  built.on_disk = true;
  const auto binaries = opencl_guard("reading back the program of " + device.info.name,
                                     [&] { return built.program.getInfo<CL_PROGRAM_BINARIES>(); });
  if (binaries.size() == 1 && !binaries[0].empty()) cache.store(built.key, binaries[0]);
}

}  // namespace lockstep
