// Draws pictures of solids and planes, lit by a sun that casts shadows and by the sky.
#pragma once

#include <memory>
#include <string>

#include "host/render/drawing.hpp"
#include "host/render/mesh.hpp"
#include "host/render/picture.hpp"

namespace lockstep {

class Renderer {
 public:
  /// For pictures of one size. Throws Error (device) where there is no EGL with OpenGL ES 3.0. One at a time in a
  /// thread.
  Renderer(u32 width, u32 height);
  ~Renderer();

  /// What draws, as the driver calls itself.
  const std::string& driver() const;

  /// Keeps a mesh for Solid::hull.
  u32 add_hull(const Mesh& mesh);

  /// The same drawing gives the same bytes, on one driver.
  Picture draw(const Drawing& drawing);

 private:
  struct Impl;  // keeps OpenGL out of this header
  std::unique_ptr<Impl> impl_;
};

/// What draws pictures here and which OpenGL ES it speaks, as the driver has it. Throws as Renderer does.
std::string picture_driver();

}  // namespace lockstep
