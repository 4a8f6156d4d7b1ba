#include "host/render/targets.hpp"

#include <algorithm>
#include <string>

#include "host/error.hpp"

namespace lockstep {

namespace {

constexpr GLint most_samples = 4;

GLint limit(const Gl& gl, GLenum name) {
  GLint value = 0;
  gl.GetIntegerv(name, &value);
  return value;
}

void expect_complete(const Gl& gl, const char* what) {
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error(Failure::device, "render", std::string("the driver cannot draw into ") + what);
}

void attach_renderbuffer(const Gl& gl, GLenum attachment, GLenum format, GLint samples, GLsizei width, GLsizei height) {
  GLuint buffer = 0;
  gl.GenRenderbuffers(1, &buffer);
  gl.BindRenderbuffer(GL_RENDERBUFFER, buffer);
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
}

}  // namespace

PictureTarget::PictureTarget(const Gl& gl, u32 width, u32 height) : gl_(gl), width_(width), height_(height) {
  const u32 most = static_cast<u32>(limit(gl, GL_MAX_RENDERBUFFER_SIZE));
  if (width > most || height > most)
    throw Error(Failure::input, "--size", "this driver draws pictures of up to " + std::to_string(most) + " pixels");
  const GLint samples = std::min(limit(gl, GL_MAX_SAMPLES), most_samples);
  const GLsizei w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
  gl.GenFramebuffers(1, &samples_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, samples_);
  attach_renderbuffer(gl, GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, w, h);
  attach_renderbuffer(gl, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, samples, w, h);
  expect_complete(gl, "a picture of several samples");
  gl.GenFramebuffers(1, &resolved_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_);
  attach_renderbuffer(gl, GL_COLOR_ATTACHMENT0, GL_RGBA8, 0, w, h);
  expect_complete(gl, "a picture");
}

void PictureTarget::begin() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, samples_);
  gl_.Viewport(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
  gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

Picture PictureTarget::read() const {
  const GLint w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, samples_);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_);
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, resolved_);
  std::vector<unsigned char> rgba(std::size_t{4} * width_ * height_);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  if (gl_.GetError() != GL_NO_ERROR) throw Error(Failure::device, "render", "the driver failed to draw a picture");
  Picture picture(width_, height_);
  for (u32 y = 0; y < height_; ++y) {  // OpenGL's rows go up
    const unsigned char* from = &rgba[std::size_t{4} * (height_ - 1 - y) * width_];
    unsigned char* to = picture.at(0, y);
    for (u32 x = 0; x < width_; ++x, from += 4, to += 3) std::copy_n(from, 3, to);
  }
  return picture;
}

ShadowMap::ShadowMap(const Gl& gl) : gl_(gl) {
  gl.GenTextures(1, &texture_);
  gl.BindTexture(GL_TEXTURE_2D, texture_);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  gl.GenFramebuffers(1, &framebuffer_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
  expect_complete(gl, "a shadow map");
}

void ShadowMap::begin() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.Viewport(0, 0, size, size);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::bind() const {
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
}

}  // namespace lockstep
