// The hard cases: scenes with an exact answer, and what is compared with it. `lockstep bench` runs them all, each by
// several methods at several settings: the speed of a method against its error.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/cases/trial.hpp"

namespace lockstep {

struct CaseError {
  std::string quantity, unit;  // the unit is empty for a plain number
  double exact, error;         // the exact value, and |computed - exact|
};

struct HardCase {
  std::string name;  // on the command line
  std::string says;  // one line: what happens, and what is exact
  std::vector<Method> methods;
  /// Runs the case; the same quantities in the same order each time, the first is the one to plot.
  std::function<std::vector<CaseError>(Trial&)> run;
};

/// Every case, in the order of docs/lab/bench.md.
const std::vector<HardCase>& hard_cases();

// by kind, a file each
std::vector<HardCase> motion_cases();            // one body without contact
std::vector<HardCase> contact_cases();           // friction and bounces of a few bodies
std::vector<HardCase> impact_cases();            // laws of impact
std::vector<HardCase> stack_cases();             // what is built at rest
std::vector<HardCase> crowd_cases();             // many bodies with an answer for all of them
std::vector<HardCase> pushed_cases();            // a force from outside over rough ground
std::vector<HardCase> linkage_cases();           // joints
std::vector<HardCase> driven_cases();            // motors and springs
std::vector<HardCase> unslipping_cases();        // skates, and what rolls
std::vector<HardCase> angular_friction_cases();  // contacts with angular friction

// what the files share

inline CaseError compare(const std::string& quantity, const std::string& unit, double exact, double computed) {
  return {quantity, unit, exact, computed > exact ? computed - exact : exact - computed};
}

/// The index of the first body that can move; there has to be one.
u32 first_dynamic(const Scene& scene);

/// A ladder of time steps.
std::vector<Setting> steps_of(std::initializer_list<double> dts);

/// The solvers of the device by what makes them finer, at one time step, s.
Method gauss_seidel(double dt, std::initializer_list<u32> iterations);
Method cell_gauss_seidel(double dt, std::initializer_list<u32> iterations);
Method small_steps(double dt, std::initializer_list<u32> substeps);
Method jacobi(double dt, std::initializer_list<u32> iterations);
Method gradient(double dt, std::initializer_list<u32> iterations);
Method accelerated_gradient(double dt, std::initializer_list<u32> iterations);
Method dense_gauss_seidel(double dt, std::initializer_list<u32> iterations);
/// By the time step, s; sweeps and sub-steps as they are meant to be.
Method trapezoidal(std::initializer_list<double> dts);    // gauss_seidel
Method semi_implicit(std::initializer_list<double> dts);  // gauss_seidel, Euler
Method soft(std::initializer_list<double> dts);           // small_steps
/// The method with friction by patches instead of a cone at each point.
Method with_patches(Method method);
/// The method with the joints of trees solved directly, and so many sweeps where the ladder says nothing else.
Method with_direct_joints(Method method, u32 iterations);
/// The contact problem of each step solved to 1e-10 (host/steppers/system_solvers.hpp), so that what is left is the
/// time step's and the friction model's: `auto` has Coulomb's cones. In double, on the reference.
Method by_oracle(const std::string& solver, std::initializer_list<double> dts);
/// The same with joints in reduced coordinates, by the trapezoidal rule: no joint of a tree opens, so that what is left
/// is the time step's.
Method reduced(std::initializer_list<double> dts);

}  // namespace lockstep
