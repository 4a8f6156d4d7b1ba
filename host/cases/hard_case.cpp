#include "host/cases/hard_case.hpp"

namespace lockstep {

namespace {

std::function<void(Settings&)> choice_of(Solver solver) {
  return [solver](Settings& settings) {
    if (settings.solver != solver || settings.joint_solver == JointSolver::direct) replace_solver(settings, solver);
    settings.joint_solver = JointSolver::sweeps;
    if (solver == Solver::small_steps) settings.integrator = Integrator::semi_implicit_euler;  // no other goes with it
  };
}

Method swept(Solver solver, double dt, std::initializer_list<u32> counts, u32 Setting::*count) {
  Method method = {name_of(solver), choice_of(solver), {}, {}};
  for (const u32 n : counts) {
    method.ladder.push_back({.dt = dt});
    method.ladder.back().*count = n;
  }
  return method;
}

// By the time step, with an integrator; sweeps and sub-steps as they are meant to be.
Method by_step(Solver solver, Integrator integrator, std::initializer_list<double> dts) {
  const auto choose = [=](Settings& settings) {
    choice_of(solver)(settings);
    settings.integrator = integrator;
  };
  const char* moved = integrator == Integrator::trapezoidal ? "trapezoidal" : "semi-implicit";
  return {std::string(name_of(solver)) + ", " + moved, choose, {}, steps_of(dts)};
}

}  // namespace

u32 first_dynamic(const Scene& scene) {
  u32 i = 0;
  while (scene.bodies[i].kind != BODY_DYNAMIC) ++i;
  return i;
}

std::vector<Setting> steps_of(std::initializer_list<double> dts) {
  std::vector<Setting> ladder;
  for (const double dt : dts) ladder.push_back({.dt = dt});
  return ladder;
}

Method trapezoidal(std::initializer_list<double> dts) {
  return by_step(Solver::gauss_seidel, Integrator::trapezoidal, dts);
}
Method semi_implicit(std::initializer_list<double> dts) {
  return by_step(Solver::gauss_seidel, Integrator::semi_implicit_euler, dts);
}
Method soft(std::initializer_list<double> dts) {
  return by_step(Solver::small_steps, Integrator::semi_implicit_euler, dts);
}

Method gauss_seidel(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::gauss_seidel, dt, iterations, &Setting::iterations);
}
Method cell_gauss_seidel(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::cell_gauss_seidel, dt, iterations, &Setting::iterations);
}

Method small_steps(double dt, std::initializer_list<u32> substeps) {
  return swept(Solver::small_steps, dt, substeps, &Setting::substeps);
}
Method jacobi(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::jacobi, dt, iterations, &Setting::iterations);
}

Method gradient(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::gradient, dt, iterations, &Setting::iterations);
}
Method accelerated_gradient(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::accelerated_gradient, dt, iterations, &Setting::iterations);
}
Method dense_gauss_seidel(double dt, std::initializer_list<u32> iterations) {
  return swept(Solver::dense_gauss_seidel, dt, iterations, &Setting::iterations);
}

Method with_patches(Method method) {
  method.name += ", patches";
  method.choose = [choose = method.choose](Settings& settings) {
    choose(settings);
    settings.friction_model = FrictionModel::patches;
  };
  return method;
}

Method with_direct_joints(Method method, u32 iterations) {
  method.name += ", direct";
  method.choose = [choose = method.choose, iterations](Settings& settings) {
    choose(settings);
    settings.joint_solver = JointSolver::direct;
    settings.iterations = iterations;
  };
  return method;
}

Method by_oracle(const std::string& solver, std::initializer_list<double> dts) {
  return {"oracle " + solver, nullptr, find_solver(solver).value(), steps_of(dts)};
}

Method reduced(std::initializer_list<double> dts) {
  const auto choose = [](Settings& settings) {
    choice_of(Solver::gauss_seidel)(settings);
    settings.integrator = Integrator::trapezoidal;
  };
  return {"oracle reduced_auto", choose, Solver::reduced_auto, steps_of(dts)};
}

const std::vector<HardCase>& hard_cases() {
  static const std::vector<HardCase> cases = [] {
    std::vector<HardCase> all;
    for (const auto& kind : {motion_cases, contact_cases, impact_cases, stack_cases, crowd_cases, pushed_cases,
                             linkage_cases, driven_cases, unslipping_cases, angular_friction_cases})
      for (HardCase& one : kind()) all.push_back(std::move(one));
    return all;
  }();
  return cases;
}

}  // namespace lockstep
