// Geoms of MJCF as shapes with their masses, and the meshes and height fields that they are made of.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

/// In the frame of its body.
struct MjcfGeom {
  std::vector<ShapeDescription> shapes;  // none: it touches nothing; several: the triangles of a height field
  std::optional<MassProperties> solid;   // none: it weighs nothing, or that is not wanted
};

class MjcfGeoms {
 public:
  /// Of the <asset> elements of a document. Files are looked for from its folder.
  MjcfGeoms(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults);

  /// `is_still`: of the world, or of a body that is fixed to it. `weighs`: its mass is wanted.
  MjcfGeom read(const MjcfElement& geom, bool is_still, bool weighs);
  /// How all that were read touch each other. Gives the shapes of the links the masks that follow.
  RobotContacts contacts(std::vector<RobotLink>& links) const;

 private:
  struct Mesh {
    XmlNode node;
    std::string path;  // empty: points are given
    std::vector<double> points;
    Vector3 scale, position;
    Quaternion orientation;
  };
  // Friction: of two geoms those of the higher priority say it, else the larger friction does.
  struct Surface {
    std::array<double, 3> friction = {1, 0.005, 0.0001};  // sliding; torsional and rolling, m
    double condim = 3;                                    // 1: none of them, 3: the first, 4: two, 6: all
    double priority = 0;

    double sliding() const { return condim >= 3 ? friction[0] : 0; }
    FurtherFriction further() const {
      FurtherFriction more;
      if (condim >= 4 && friction[0] > 0) more.torsional_friction = friction[1];
      if (condim >= 6) more.rolling_friction = friction[2];
      return more;
    }
    bool operator==(const Surface&) const = default;
  };
  struct Filter {
    u32 contype, conaffinity;
    bool operator==(const Filter&) const = default;
  };

  void read_mesh_asset(const MjcfElement& asset);
  TriangleMesh mesh_of(const Mesh& mesh) const;
  MassProperties set_mesh(const MjcfElement& geom, ShapeDescription& shape, bool weighs) const;
  void set_size(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const;
  ShapeDescription field_of(const MjcfElement& geom, const ShapeDescription& whole) const;
  u32 surface_of(const MjcfElement& geom);
  u32 filter_of(const MjcfElement& geom, bool& touches);

  const MjcfCompiler& compiler_;
  std::map<std::string, Mesh> meshes_;
  std::map<std::string, XmlNode> fields_;
  std::vector<Surface> surfaces_;
  std::vector<Filter> filters_ = {{1, 1}};  // the first is what is touched by default
};

}  // namespace lockstep
