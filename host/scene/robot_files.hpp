// What the readers of robot files share: masses and meshes as such files have them.
#pragma once

#include <string>
#include <vector>

#include "host/scene/mass_properties.hpp"
#include "host/scene/xml_node.hpp"

namespace lockstep {

/// Refuses moments that no body has: they must be > 0 and keep the triangle inequality to 1 in 1000, for files have few
/// digits. `node` is where they stand.
void expect_real(const XmlNode& node, const MassProperties& solid);

/// set_hull() of points whose hull may have more corners than a shape can: of such, that of few_corners().
std::string set_hull_of_many(const std::vector<Vector3>& points, ShapeDescription& shape);

}  // namespace lockstep
