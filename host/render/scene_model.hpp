// The bodies of a scene as solids and planes: what does not change while they move.
#pragma once

#include <span>
#include <vector>

#include "host/buffers.hpp"
#include "host/render/drawing.hpp"
#include "host/render/renderer.hpp"

namespace lockstep {

/// Where a body is.
struct RenderPose {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
};

template <class real>
std::vector<RenderPose> poses_of(const std::vector<Vec4<real>>& positions, const std::vector<Vec4<real>>& orientations);

/// How a body looks.
struct Look {
  Color color = still_color;
  float alpha = 1;
  bool shown = true;
};

/// What there is of a body, in its frame.
struct OwnSolids {
  std::vector<Solid> solids;
  std::vector<PlaneSurface> planes;
};

class SceneModel {
 public:
  /// From the constant buffers of a scene. A body without shapes is drawn as the box that has its mass and moments, one
  /// that hangs from a pivot with a rod to it.
  template <class real>
  explicit SceneModel(const Buffers<real>& scene);

  /// Gives the meshes of hulls to a renderer, in whose drawings the model can be from then on.
  void add_meshes_to(Renderer& renderer);

  u32 bodies() const { return static_cast<u32>(movable_.size()); }
  bool movable(u32 body) const { return movable_[body]; }
  /// World-local.
  u32 id(u32 body) const { return ids_[body]; }
  bool has_planes() const;
  /// Unit; z where there is no gravity.
  const Eigen::Vector3f& up() const { return up_; }

  /// What each body looks like where no renderer has the meshes: Solid::hull is the number of one of them.
  std::vector<OwnSolids> own_solids(std::span<const Look> looks) const;
  std::span<const Mesh> hulls() const { return hulls_; }

  /// The boxes around the shapes of bodies that stand so.
  std::vector<Extent> extents(std::span<const RenderPose> poses) const;
  /// Of these bodies alone.
  std::vector<Extent> extents(std::span<const RenderPose> poses, std::span<const u32> bodies) const;

  /// Adds the bodies to a drawing. `patterned`: with marks that show how they are turned.
  void draw(std::span<const RenderPose> poses, std::span<const Look> looks, bool patterned, Drawing& drawing) const;

 private:
  struct DrawnShape {
    u32 body;
    ShapeKind kind;
    u32 hull;
    Eigen::Vector3f offset;
    Eigen::Quaternionf rotation;
    Eigen::Vector3f size;  // as Shape::size
    bool trigger;
  };

  template <class real>
  void add_shapes(const Buffers<real>& scene);
  template <class real>
  void add_surfaces(const Buffers<real>& scene);
  template <class real>
  void add_hulls(const Buffers<real>& scene);
  template <class real>
  void add_bare_body(const Buffers<real>& scene, u32 body);
  void draw_shape(const DrawnShape& drawn, const RenderPose& pose, const Look& look, bool patterned,
                  Drawing& drawing) const;
  void draw_capsule(const DrawnShape& drawn, const Solid& solid, Drawing& drawing) const;

  std::vector<DrawnShape> drawn_shapes_;
  std::vector<Mesh> hulls_;
  std::vector<u32> hull_numbers_;  // the renderer's
  std::vector<bool> movable_;
  std::vector<u32> ids_;
  Eigen::Vector3f up_ = Eigen::Vector3f::UnitZ();
};

}  // namespace lockstep
