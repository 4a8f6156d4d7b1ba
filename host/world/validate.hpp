// What a world refuses of what it is given: everything that a scene file would be refused for. Each throws Error
// (input) with one line.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "include/lockstep/world.hpp"

namespace lockstep {

template <std::size_t n>
void expect_finite(const std::array<double, n>& values, const char* what) {
  if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); }))
    throw Error(Failure::input, what, "must be finite");
}

/// What the precision of a run does not hold, the next step would refuse, and each after it.
void expect_fits(const Settings& settings, std::span<const double> values, const std::string& what);
inline void expect_fits(const Settings& settings, double value, const std::string& what) {
  expect_fits(settings, std::span(&value, 1), what);
}

void expect_finite(const Wrench& load);
void expect_unit(const Quaternion& q);

/// Of a body that was made in code; compile() asks for the rest.
void validate(const BodyDescription& body, const Scene& scene);
/// Of a joint between bodies of the scene.
void validate(const JointDescription& joint, const Scene& scene);
/// Of the materials and rules for pairs that a scene has.
void validate_materials(const Scene& scene);

}  // namespace lockstep
