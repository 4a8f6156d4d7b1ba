// How a scene is simulated: the settings of host/settings.def, and the solvers of host/solvers.def with what they
// bring.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "kernels/types.h"

namespace lockstep {

/// How a body moves. `explicit_euler`, `semi_implicit_euler` and `trapezoidal` are the time-stepping schemes (positions
/// move with the old, the new, the mean velocity); `runge_kutta` is of fourth order, for free flight and pivots only.
enum class Integrator { explicit_euler, semi_implicit_euler, trapezoidal, runge_kutta };
inline constexpr std::pair<const char*, Integrator> integrator_names[] = {
    {"explicit_euler", Integrator::explicit_euler},
    {"semi_implicit_euler", Integrator::semi_implicit_euler},
    {"trapezoidal", Integrator::trapezoidal},
    {"runge_kutta", Integrator::runge_kutta}};

/// At which angular velocity the gyroscopic moment w x I w is taken: left out, at the old, the new or the mean one.
enum class Gyroscopic { none, explicit_, implicit, midpoint };
inline constexpr std::pair<const char*, Gyroscopic> gyroscopic_names[] = {{"none", Gyroscopic::none},
                                                                          {"explicit", Gyroscopic::explicit_},
                                                                          {"implicit", Gyroscopic::implicit},
                                                                          {"midpoint", Gyroscopic::midpoint}};

/// How contacts and joints are solved; host/solvers.def and host/oracles.def say what each does.
enum class Solver {
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) name,
#include "host/solvers.def"
#define ORACLE(name, text, what) name,
#include "host/oracles.def"
};

/// A row of host/solvers.def, or of host/oracles.def.
struct SolverInfo {
  const char* name;
  u32 substeps, iterations;  // what the solver brings, unless a scene sets it
  double tolerance;          // m/s
  const char* precision;
  const char *what, *use;  // what it does, what for
  bool is_oracle = false;  // it solves to a residual, `tolerance`, in double on the reference (docs/solvers_oracle.md)
};
inline constexpr SolverInfo solver_infos[] = {
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) \
  {#name, substeps, iterations, tolerance, precision, what, use},
#include "host/solvers.def"
#define ORACLE(name, text, what) {text, 1, 100'000, 1e-10, "double", what, "truth to hold fast steps against", true},
#include "host/oracles.def"
};
inline constexpr std::pair<const char*, Solver> solver_names[] = {
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) {#name, Solver::name},
#include "host/solvers.def"
#define ORACLE(name, text, what) {text, Solver::name},
#include "host/oracles.def"
};
constexpr const SolverInfo& info(Solver solver) { return solver_infos[static_cast<u32>(solver)]; }
constexpr bool is_oracle(Solver solver) { return info(solver).is_oracle; }
/// By its name; nothing where there is none.
constexpr std::optional<Solver> find_solver(std::string_view name) {
  for (const auto& [text, solver] : solver_names)
    if (name == text) return solver;
  return std::nullopt;
}

/// Whether it is an oracle in the coordinates of joints.
inline bool is_reduced(Solver solver) { return std::string_view(info(solver).name).starts_with("reduced_"); }

/// Whether it goes down a gradient: hard contacts and joints as one convex problem, another model
/// (cpu_reference/gradient/descent.hpp).
inline bool is_gradient(Solver solver) { return solver == Solver::gradient || solver == Solver::accelerated_gradient; }

/// Friction model. `cones`: each contact point has a cone of its own, exact Coulomb friction; `patches`: the contacts
/// of two shapes share one friction and one twist, cheaper, another model (cpu_reference/solve_patch.hpp).
enum class FrictionModel { cones, patches };
inline constexpr std::pair<const char*, FrictionModel> friction_model_names[] = {{"cones", FrictionModel::cones},
                                                                                 {"patches", FrictionModel::patches}};

/// How joints that have come apart are closed, but for those of small_steps and those that are soft on purpose: by
/// velocities, which take back the share `correction` of the error in a sub-step and stay (Baumgarte), or by moving the
/// bodies once a sub-step has moved them, their velocities left alone (cpu_reference/close_joints.hpp).
enum class Stabilization { velocities, positions };
inline constexpr std::pair<const char*, Stabilization> stabilization_names[] = {
    {"velocities", Stabilization::velocities}, {"positions", Stabilization::positions}};

/// How joints are solved in each sweep: one after another, or all those of a tree of bodies at once, exactly, with up
/// to MAX_CLOSURES that close its loops (cpu_reference/articulations/link.hpp, closures.hpp). `automatic`: at once
/// those of trees in which some body carries ten times its mass (host/scene/compile_articulations.hpp), with solvers
/// that can.
enum class JointSolver { automatic, sweeps, direct };
inline constexpr std::pair<const char*, JointSolver> joint_solver_names[] = {
    {"auto", JointSolver::automatic}, {"sweeps", JointSolver::sweeps}, {"direct", JointSolver::direct}};

/// How candidate pairs are found. `automatic` takes the tree where shapes differ much in size.
enum class BroadPhase { automatic, grid, bvh };
inline constexpr std::pair<const char*, BroadPhase> broad_phase_names[] = {
    {"auto", BroadPhase::automatic}, {"grid", BroadPhase::grid}, {"bvh", BroadPhase::bvh}};

/// What events are of: pairs of shapes, of bodies, or of the triangles of surfaces (host/scene/event_groups.hpp).
enum class EventPairs { shapes, bodies, triangles };
inline constexpr std::pair<const char*, EventPairs> event_pairs_names[] = {
    {"shapes", EventPairs::shapes}, {"bodies", EventPairs::bodies}, {"triangles", EventPairs::triangles}};

/// Of which time impulses and forces are told (docs/forces.md): `automatic` is `step` where somebody is there to ask,
/// wants_step_forces().
enum class Forces { automatic, step, substep };
inline constexpr std::pair<const char*, Forces> forces_names[] = {
    {"auto", Forces::automatic}, {"step", Forces::step}, {"substep", Forces::substep}};

/// A setting that is unset until somebody sets it: the solver brings it then. substeps_of() and its like give what
/// holds.
template <class T>
using BySolver = std::optional<T>;

/// When islands fall asleep (docs/sleeping.md).
struct SleepSettings {
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) type name = initial;
#include "host/settings.def"
};

/// The rows of host/settings.def and kernels/step_settings.def, which say what each is, its unit and its bounds.
struct Settings {
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) type name = initial;
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) type name = initial;
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) type name = initial;
#include "host/settings.def"
  // of worlds, no settings of files
  bool loads = false;         // forces and torques from outside
  bool keeps_shapes = false;  // for questions, though none can touch
};

inline u32 substeps_of(const Settings& s) { return s.substeps.value_or(info(s.solver).substeps); }
inline u32 iterations_of(const Settings& s) { return s.iterations.value_or(info(s.solver).iterations); }
inline double tolerance_of(const Settings& s) { return s.tolerance.value_or(info(s.solver).tolerance); }
inline std::string precision_of(const Settings& s) { return s.precision.value_or(info(s.solver).precision); }

/// The same settings with nothing unset.
inline Settings resolved(Settings settings) {
  settings.substeps = substeps_of(settings);
  settings.iterations = iterations_of(settings);
  settings.tolerance = tolerance_of(settings);
  settings.precision = precision_of(settings);
  return settings;
}

/// Takes another solver with the sub-steps and sweeps that it brings, and joints as it takes them: what was set for the
/// old one is forgotten. An oracle brings a residual and double as well and wants cones; it keeps the sub-steps of
/// sweeps of Gauss-Seidel, whose steps it makes exact. To choose a solver in the first place, assign `settings.solver`.
inline void replace_solver(Settings& settings, Solver solver) {
  const bool same_steps = settings.solver == Solver::gauss_seidel && settings.joint_solver != JointSolver::direct;
  if (!(is_oracle(solver) && same_steps)) settings.substeps.reset();
  if (is_oracle(solver) || is_oracle(settings.solver)) {
    settings.tolerance.reset();
    settings.precision.reset();
  }
  if (is_oracle(solver)) settings.friction_model = FrictionModel::cones;
  settings.solver = solver;
  settings.iterations.reset();
  settings.joint_solver = JointSolver::automatic;
}

[[deprecated("assign settings.solver; replace_solver() also forgets what was set for another solver")]]  //
inline void
use_solver(Settings& settings, Solver solver) {
  replace_solver(settings, solver);
}

inline const char* name_of(Solver solver) { return info(solver).name; }
inline const char* name_of(JointSolver solver) { return joint_solver_names[static_cast<u32>(solver)].first; }
inline const char* name_of(FrictionModel model) { return friction_model_names[static_cast<u32>(model)].first; }

}  // namespace lockstep
