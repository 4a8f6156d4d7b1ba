#include "host/scene/settings.hpp"

#include <type_traits>

namespace lockstep {

namespace {

// Settings of the library's header (include/lockstep/settings.hpp) are the rows of the tables, and no others.
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) type name = initial;
struct SleepRows {
#include "host/settings.def"
};
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) type name = initial;
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) type name = initial;
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) type name = initial;
struct SettingRows {
#include "host/settings.def"
  bool loads = false, keeps_shapes = false;
};
static_assert(sizeof(SleepSettings) == sizeof(SleepRows) && sizeof(Settings) == sizeof(SettingRows),
              "include/lockstep/settings.hpp has members that are no rows of host/settings.def");
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) \
  static_assert(std::is_same_v<decltype(SleepSettings::name), type>);
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) \
  static_assert(std::is_same_v<decltype(Settings::name), type>);
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) \
  static_assert(std::is_same_v<decltype(Settings::name), type>);
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) \
  static_assert(std::is_same_v<decltype(Settings::name), type>);
#include "host/settings.def"

// So are the solvers, in the order of their tables.
enum class SolverRow {
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) name,
#include "host/solvers.def"
#define ORACLE(name, text, what) name,
#include "host/oracles.def"
};
#define SOLVER(name, substeps, iterations, tolerance, precision, what, use) \
  static_assert(static_cast<u32>(SolverRow::name) == static_cast<u32>(Solver::name));
#include "host/solvers.def"
#define ORACLE(name, text, what) static_assert(static_cast<u32>(SolverRow::name) == static_cast<u32>(Solver::name));
#include "host/oracles.def"

// And the kinds of shapes and joints, which the kernels number by their tables.
enum class ShapeRow {
#define SHAPE_KIND(name, NAME, needs, may, features, meaning) NAME,
#include "kernels/shape_kinds.def"
  kinds,
  last = kinds - 1,
#define SCENE_SHAPE_KIND(name, NAME, needs, may, features, meaning) NAME,
#include "kernels/shape_kinds.def"
};
#define SHAPE_KIND(name, NAME, needs, may, features, meaning) \
  static_assert(static_cast<u32>(ShapeRow::NAME) == SHAPE_##NAME);
#define SCENE_SHAPE_KIND(name, NAME, needs, may, features, meaning) \
  static_assert(static_cast<u32>(ShapeRow::NAME) == SHAPE_##NAME);
#include "kernels/shape_kinds.def"
static_assert(static_cast<u32>(ShapeRow::kinds) == SHAPE_KINDS);
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) NAME,
enum class JointRow {
#include "kernels/joint_kinds.def"
  kinds
};
#undef JOINT_KIND
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) \
  static_assert(static_cast<u32>(JointRow::NAME) == JOINT_##NAME);
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
static_assert(static_cast<u32>(JointRow::kinds) == JOINT_KINDS);

}  // namespace

void replace_solver(Settings& settings, Solver solver) {
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

}  // namespace lockstep
