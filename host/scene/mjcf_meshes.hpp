// The <mesh> and <hfield> assets of MJCF.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/scene/left_out.hpp"
#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

/// As it is placed by its scale and its reference pose.
struct MjcfMesh {
  enum class Inertia { convex, exact, legacy, shell };
  XmlNode node;
  std::string path;  // empty: points are given
  std::vector<double> points;
  std::vector<double> faces;
  Vector3 scale, position;
  Quaternion orientation;
  Inertia inertia = Inertia::legacy;

  TriangleMesh triangles() const;
  /// Of a density of 1 kg/m^3, of a shell 1 kg/m^2, as MuJoCo integrates over triangles.
  MassProperties solid() const;
  /// Gives the shape the corners of the hull.
  void set_hull(ShapeDescription& shape) const;
};

class MjcfAssets {
 public:
  /// Files are looked for from the folders of the document's files.
  MjcfAssets(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults);

  const MjcfMesh& mesh(const MjcfElement& geom) const;
  /// The triangles of the height field that a geom names, in the shape's frame.
  void set_field(const MjcfElement& geom, ShapeDescription& shape) const;

 private:
  void read_mesh(const MjcfElement& asset);
  std::string file_of(const XmlNode& node) const;

  const MjcfCompiler& compiler_;
  const std::filesystem::path main_;  // the file at the top
  std::map<std::string, MjcfMesh> meshes_;
  std::map<std::string, XmlNode> fields_;
};

}  // namespace lockstep
