// How the geoms of MJCF touch each other: frictions, and the bits of contype and conaffinity.
#pragma once

#include <array>
#include <vector>

#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

/// Of all geoms of a robot, those of models that are attached to it among them.
class MjcfContacts {
 public:
  /// Gives a shape its material and its category; false where it touches nothing.
  bool set(const MjcfElement& geom, ShapeDescription& shape);
  /// How all that were set touch each other. Gives the shapes of the links the masks that follow.
  RobotContacts contacts(std::vector<RobotLink>& links) const;

 private:
  // Friction: of two geoms those of the higher priority say it, else the larger friction does.
  struct Surface {
    std::array<double, 3> friction = {1, 0.005, 0.0001};  // sliding; torsional and rolling, m
    double condim = 3;                                    // 1: none of them, 3: the first, 4: two, 6: all
    double priority = 0;

    double sliding() const { return condim >= 3 ? friction[0] : 0; }
    FurtherFriction further() const;
    bool operator==(const Surface&) const = default;
  };
  struct Filter {
    u32 contype, conaffinity;
    bool operator==(const Filter&) const = default;
  };

  u32 surface_of(const MjcfElement& geom);

  std::vector<Surface> surfaces_;
  std::vector<Filter> filters_ = {{1, 1}};  // the first is what is touched by default
};

}  // namespace lockstep
