// What is built at rest, and is to stay where it was built; and heaps, which are to come to rest.
#include "host/cases/hard_case.hpp"
#include "host/cases/rest.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

std::vector<CaseError> rest_errors(const std::string& name, double duration, Trial& trial) {
  const RestMeasures rest = measure_rest(read_scene(name), duration, trial);
  return {{"moved, the farthest", "m", 0, rest.moved},
          {"overlap in the last second, mean", "m", 0, rest.mean_depth},
          {"overlap in the last second, deepest", "m", 0, rest.deepest},
          {"kinetic energy of a body in the last second, most", "J", 0, rest.kinetic}};
}

// What has fallen and should lie: overlap first, for it does not end where it started.
std::vector<CaseError> lies(const std::string& name, double duration, Trial& trial) {
  std::vector<CaseError> errors = rest_errors(name, duration, trial);
  errors.erase(errors.begin());
  return errors;
}

/// A building that is given ten minutes: how long it stood, until a plank had fallen by half of its height.
std::vector<CaseError> kapla(Trial& trial) {
  const Scene scene = read_scene("kapla");
  const u32 first = first_dynamic(scene);
  const auto planks = static_cast<u32>(scene.bodies.size()) - first;
  const double duration = 600, height = 0.1;
  double upright = 0, moved = 0;
  u32 step = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    if (step++ % 10 != 0) return true;
    double fallen = 0;
    for (u32 i = first; i < first + planks; ++i) {
      const Vector3 displacement = exact::subtract(seen.body(i).x, scene.bodies[i].position);
      moved = std::max(moved, exact::length(displacement));
      fallen = std::max(fallen, -displacement[2]);
    }
    if (fallen > height / 2) return false;
    upright = seen.time;
    return true;
  });
  return {{"moved, the farthest", "m", 0, moved}, compare("stood", "s", duration, upright)};
}

HardCase stack_case(const std::string& name, const std::string& says, double duration, std::vector<Method> methods) {
  return {name, says, std::move(methods), [=](Trial& trial) { return rest_errors(name, duration, trial); }};
}

HardCase lying(const std::string& name, const std::string& says, double duration, std::vector<Method> methods) {
  return {name, says, std::move(methods), [=](Trial& trial) { return lies(name, duration, trial); }};
}

constexpr double frame = 1.0 / 60;

}  // namespace

std::vector<HardCase> stack_cases() {
  return {
      stack_case(
          "pyramid20", "A pyramid of 210 cubes stands for ten seconds", 10,
          {gauss_seidel(frame, {10, 40, 160}), cell_gauss_seidel(frame, {10, 40, 160}),
           small_steps(frame, {3, 4, 5, 8, 12}), with_patches(small_steps(frame, {3, 4, 5, 8, 12})),
           jacobi(frame, {30, 120}), gradient(frame, {100, 400}), accelerated_gradient(frame, {25, 50, 100, 200, 400}),
           dense_gauss_seidel(frame, {10, 40, 160}), by_oracle("auto", {frame})}),
      stack_case("wall", "A wall of 400 bricks stands for ten seconds", 10,
                 {gauss_seidel(frame, {10, 40, 160}), cell_gauss_seidel(frame, {10, 40, 160}),
                  small_steps(frame, {3, 5, 8, 12}), with_patches(small_steps(frame, {3, 5, 8, 12}))}),
      stack_case("box_stack20", "A column of 20 cubes stands for ten seconds", 10,
                 {gauss_seidel(frame, {10, 40, 160}), small_steps(frame, {5, 10, 14, 20, 28}),
                  accelerated_gradient(frame, {50, 200, 800}), dense_gauss_seidel(frame, {10, 40, 160}),
                  by_oracle("auto", {frame})}),
      stack_case(
          "mass_ratio", "512 kg stand on 1 kg, with eight masses between them, for ten seconds", 10,
          {gauss_seidel(frame, {100, 1000}), small_steps(frame, {16, 24, 32, 48, 64}), by_oracle("auto", {frame})}),
      stack_case(
          "growing_stack", "Cubes of 1 to 32 m stand on each other, the largest at the top, for ten seconds", 10,
          {gauss_seidel(frame, {100, 1000}), small_steps(frame, {64, 128, 256, 512}), by_oracle("auto", {frame})}),
      stack_case("heavy_top_pyramid", "A pyramid of ten rows carries a cube 300 times as heavy for ten seconds", 10,
                 {gauss_seidel(frame, {40, 160}), small_steps(frame, {8, 16, 32}), by_oracle("auto", {frame})}),
      stack_case("pyramid100", "A pyramid of 5,050 cubes stands for five seconds", 5,
                 {gauss_seidel(frame, {10, 40}), small_steps(frame, {5, 10, 15})}),
      stack_case("two_cubes", "A tonne stands on a gram, for a second", 1, {small_steps(frame, {1024, 2048, 4096})}),
      stack_case("card_house", "A house of 40 cards stands for ten seconds", 10,
                 {gauss_seidel(frame, {40, 160}), small_steps(frame, {5, 8, 16, 32}),
                  dense_gauss_seidel(frame, {40, 160}), by_oracle("auto", {frame})}),
      stack_case("arch", "27 stones without mortar stand in an arch for ten seconds", 10,
                 {gauss_seidel(frame, {100, 400}), small_steps(frame, {20, 24, 40, 64}), by_oracle("auto", {frame})}),
      {"kapla",
       "A building of 102 planks on edge, six floors of beams and walls, stands for ten minutes",
       {gauss_seidel(0.01, {40, 160}), small_steps(0.01, {4, 8, 16})},
       kapla},
      lying("box_heap", "4,096 cubes fall into a box and are a heap at rest after ten seconds", 10,
            {gauss_seidel(frame, {10, 40}), cell_gauss_seidel(frame, {10, 40}), small_steps(frame, {5, 8}),
             with_patches(small_steps(frame, {5, 8})), jacobi(frame, {30}), accelerated_gradient(frame, {50})}),
      lying("spheres8000", "8,000 spheres fall into a box and lie still after ten seconds", 10,
            {gauss_seidel(frame, {10, 40}), cell_gauss_seidel(frame, {10, 40}), small_steps(frame, {5, 8}),
             jacobi(frame, {30})}),
  };
}

}  // namespace lockstep
