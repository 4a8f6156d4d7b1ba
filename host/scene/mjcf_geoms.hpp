// Geoms of MJCF as shapes with their masses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/scene/left_out.hpp"
#include "host/scene/mjcf_contacts.hpp"
#include "host/scene/mjcf_meshes.hpp"

namespace lockstep {

/// In the frame of its body, or of the <frame> around it.
struct MjcfGeom {
  std::optional<ShapeDescription> shape;  // none: it touches nothing
  std::optional<MassProperties> solid;    // none: it weighs nothing, or that is not wanted
};

class MjcfGeoms {
 public:
  MjcfGeoms(const MjcfCompiler& compiler, const MjcfAssets& assets, MjcfContacts& contacts, LeftOut& left_out)
      : compiler_(compiler), assets_(assets), contacts_(contacts), left_out_(left_out) {}

  /// `is_still`: of the world, or of a body that is fixed to it. `weighs`: its mass is wanted.
  MjcfGeom read(const MjcfElement& geom, bool is_still, bool weighs);

 private:
  void set_size(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const;
  void fit(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const;
  MassProperties set_ellipsoid(const MjcfElement& geom, ShapeDescription& shape);

  const MjcfCompiler& compiler_;
  const MjcfAssets& assets_;
  MjcfContacts& contacts_;
  LeftOut& left_out_;
};

}  // namespace lockstep
