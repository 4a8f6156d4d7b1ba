// What is drawn into: a picture of several samples a pixel, and the shadow map.
#pragma once

#include "host/render/gl.hpp"
#include "host/render/picture.hpp"

namespace lockstep {

/// Lives as long as its context.
class PictureTarget {
 public:
  /// Throws Error (input) for a size that the driver does not take.
  PictureTarget(const Gl& gl, u32 width, u32 height);

  void begin() const;
  /// What was drawn since, the samples of each pixel averaged.
  Picture read() const;

 private:
  const Gl& gl_;
  u32 width_, height_;
  GLuint samples_ = 0, resolved_ = 0;  // framebuffers
};

/// How far what the light meets first is from it. Lives as long as its context.
class ShadowMap {
 public:
  static constexpr GLsizei size = 2048;

  explicit ShadowMap(const Gl& gl);
  void begin() const;
  void bind() const;  // to the first texture unit

 private:
  const Gl& gl_;
  GLuint framebuffer_ = 0, texture_ = 0;
};

}  // namespace lockstep
