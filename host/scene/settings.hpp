// Names of settings and of their values, and the solvers of host/solvers.def with what they bring. Settings themselves
// are in include/lockstep/settings.hpp.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "include/lockstep/settings.hpp"
#include "kernels/types.h"

namespace lockstep {

inline constexpr std::pair<const char*, Integrator> integrator_names[] = {
    {"explicit_euler", Integrator::explicit_euler},
    {"semi_implicit_euler", Integrator::semi_implicit_euler},
    {"trapezoidal", Integrator::trapezoidal},
    {"runge_kutta", Integrator::runge_kutta}};

inline constexpr std::pair<const char*, Gyroscopic> gyroscopic_names[] = {{"none", Gyroscopic::none},
                                                                          {"explicit", Gyroscopic::explicit_},
                                                                          {"implicit", Gyroscopic::implicit},
                                                                          {"midpoint", Gyroscopic::midpoint}};

/// A row of host/solvers.def, or of host/oracles.def.
struct SolverInfo {
  const char* name;
  u32 substeps, iterations;  // what the solver brings, unless a scene sets it
  double tolerance;          // m/s
  const char* precision;
  const char *what, *use;  // what it does, what for
  bool is_oracle = false;  // it solves to a residual, `tolerance`, in double on the reference (docs/theory/oracles.md)
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

inline constexpr std::pair<const char*, FrictionModel> friction_model_names[] = {{"cones", FrictionModel::cones},
                                                                                 {"patches", FrictionModel::patches}};

inline constexpr std::pair<const char*, Stabilization> stabilization_names[] = {
    {"velocities", Stabilization::velocities}, {"positions", Stabilization::positions}};

inline constexpr std::pair<const char*, JointSolver> joint_solver_names[] = {
    {"auto", JointSolver::automatic}, {"sweeps", JointSolver::sweeps}, {"direct", JointSolver::direct}};

inline constexpr std::pair<const char*, BroadPhase> broad_phase_names[] = {
    {"auto", BroadPhase::automatic}, {"grid", BroadPhase::grid}, {"bvh", BroadPhase::bvh}};

inline constexpr std::pair<const char*, EventPairs> event_pairs_names[] = {
    {"shapes", EventPairs::shapes}, {"bodies", EventPairs::bodies}, {"triangles", EventPairs::triangles}};

inline constexpr std::pair<const char*, Forces> forces_names[] = {
    {"auto", Forces::automatic}, {"step", Forces::step}, {"substep", Forces::substep}};

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

inline const char* name_of(Solver solver) { return info(solver).name; }
inline const char* name_of(JointSolver solver) { return joint_solver_names[static_cast<u32>(solver)].first; }
inline const char* name_of(FrictionModel model) { return friction_model_names[static_cast<u32>(model)].first; }

}  // namespace lockstep
