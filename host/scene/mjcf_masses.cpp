#include "host/scene/mjcf_masses.hpp"

#include <algorithm>

#include "host/scene/robot_files.hpp"

namespace lockstep {

namespace {

// Moments that break the triangle inequality become their mean, all three.
void balance(MassProperties& solid) {
  const Vector3 moments = principal_axes(solid.inertia).moments;
  const double sum = moments[0] + moments[1] + moments[2];
  const double most = std::max({moments[0], moments[1], moments[2]});
  if (sum - most < most) solid.inertia = {sum / 3, sum / 3, sum / 3, 0, 0, 0};
}

}  // namespace

std::optional<MassProperties> bounded(MassProperties solid, const MjcfCompiler& compiler) {
  solid.mass = std::max(solid.mass, compiler.least_mass);
  if (solid.mass == 0) return std::nullopt;
  if (compiler.least_inertia == 0) return solid;
  const PrincipalAxes own = principal_axes(solid.inertia);
  MassProperties about_axes;
  bool is_raised = false;
  for (unsigned i = 0; i < 3; ++i) {
    const double moment = own.moments[i];
    const bool is_small = moment >= 0 && moment < compiler.least_inertia;  // below 0 it is none of a body
    about_axes.inertia[i] = is_small ? compiler.least_inertia : moment;
    is_raised = is_raised || is_small;
  }
  if (is_raised) solid.inertia = transformed(about_axes, {0, 0, 0}, own.rotation).inertia;
  return solid;
}

std::optional<MassProperties> read_mjcf_inertial(const XmlNode& node, const MjcfCompiler& compiler) {
  const MjcfElement element(node, {});
  MassProperties own;
  own.mass = node.not_negative("mass");
  if (node.has("fullinertia")) {
    if (node.has("diaginertia")) node.fail("fullinertia", "stands beside diaginertia; give one");
    const std::vector<double> all = node.numbers("fullinertia", 6, 6);  // xx yy zz xy xz yz
    std::copy(all.begin(), all.end(), own.inertia.begin());
  } else {
    const Vector3 moments = node.vector("diaginertia");
    std::copy(moments.begin(), moments.end(), own.inertia.begin());
  }
  std::optional<MassProperties> solid = bounded(own, compiler);
  if (!solid) return std::nullopt;
  if (compiler.balance) balance(*solid);
  expect_real(node, *solid);
  return transformed(*solid, element.vector("pos", {0, 0, 0}), element.orientation(compiler));
}

}  // namespace lockstep
