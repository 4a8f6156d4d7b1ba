// Solids as the graphics device draws them: each mesh once, with a list of where its copies are.
#pragma once

#include <span>
#include <vector>

#include "host/render/drawing.hpp"
#include "host/render/gl.hpp"
#include "host/render/mesh.hpp"

namespace lockstep {

/// Lives as long as its context.
class Instances {
 public:
  explicit Instances(const Gl& gl);

  /// Keeps a mesh; the number that Solid::hull names it by.
  u32 add_hull(const Mesh& mesh);

  /// The solids to draw: round ones in as many triangles as their size in a picture of this height asks for.
  void set(std::span<const Solid> solids, const Camera& camera, u32 height);
  void draw() const;

 private:
  struct Copy {
    float position[4], orientation[4], scale[4], color[4];
  };
  struct Batch {
    GLuint array = 0, copies_buffer = 0;
    GLsizei indices = 0;
    std::vector<Copy> copies;
  };
  static constexpr u32 levels = 4;  // of detail

  Batch make_batch(const Mesh& mesh) const;
  std::size_t batch_of(const Solid& solid, u32 level) const;

  const Gl& gl_;
  std::vector<Batch> batches_;
};

}  // namespace lockstep
