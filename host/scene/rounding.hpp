// From the doubles of a scene to the precision of a run, once, with an error where they do not fit.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Where a number comes from, for errors: the scene, and the body or the joint where there is one.
struct Origin {
  const Scene& scene;
  const BodyDescription* body = nullptr;
  const JointDescription* joint = nullptr;

  [[noreturn]] void fail(const std::string& what) const {
    std::string where = scene.source;
    if (body != nullptr) where += location("body", body - scene.bodies.data(), body->name);
    if (joint != nullptr) where += location("joint", joint - scene.joints.data(), joint->name);
    throw Error(Failure::input, where, what);
  }

 private:
  static std::string location(const char* what, std::ptrdiff_t index, const std::string& name) {
    return fmt::format(": {} {}", what, index) + (name.empty() ? "" : fmt::format(" ({})", quote(name)));
  }
};

template <class real>
constexpr const char* precision_name = sizeof(real) == sizeof(float) ? "float" : "double";

/// The one rounding from what a scene says to the precision of the run.
template <class real>
real rounded(double x, const char* name, const Origin& origin) {
  if (!(std::abs(x) <= static_cast<double>(std::numeric_limits<real>::max()))) {
    const std::string value = x == x ? fmt::format("{}", x) : "not a number";
    origin.fail(fmt::format("{} must fit {}, is {}", name, precision_name<real>, value));
  }
  return static_cast<real>(x);
}

/// The same for masses, radii and time steps, which must not vanish, and whose inverses must not overflow.
template <class real>
real rounded_positive(double x, const char* name, const Origin& origin) {
  const real r = rounded<real>(x, name, origin);
  if (!(r >= std::numeric_limits<real>::min()) || !(r <= 1 / std::numeric_limits<real>::min())) {
    origin.fail(fmt::format("{} and its inverse must fit {}, is {}", name, precision_name<real>, x));
  }
  return r;
}

template <class real>
Vec4<real> rounded(const Vector3& v, const char* name, const Origin& origin) {
  return {rounded<real>(v[0], name, origin), rounded<real>(v[1], name, origin), rounded<real>(v[2], name, origin), 0};
}

template <class real>
Vec4<real> rounded(const Quaternion& q) {
  return {static_cast<real>(q[0]), static_cast<real>(q[1]), static_cast<real>(q[2]), static_cast<real>(q[3])};
}

}  // namespace lockstep
