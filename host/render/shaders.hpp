// The programs that run on the graphics device.
#pragma once

#include <Eigen/Core>
#include <span>

#include "host/render/gl.hpp"

namespace lockstep {

/// What is drawn, each by a program of its own.
enum class Shader { sky, plane, solid, shadow, mark };

/// A linked program; it lives as long as its context.
class Program {
 public:
  /// Throws Error (device) with the driver's log.
  Program(const Gl& gl, Shader shader);

  void use() const { gl_.UseProgram(id_); }
  // of the program in use; names that a program lacks are passed over
  void set(const char* name, float value) const;
  void set(const char* name, int value) const;
  void set(const char* name, const Eigen::Vector3f& value) const;
  void set(const char* name, std::span<const Eigen::Vector4f> values) const;
  void set(const char* name, const Eigen::Matrix4f& value) const;

 private:
  const Gl& gl_;
  GLuint id_;
};

/// Planes that others can be cut off behind.
inline constexpr std::size_t most_cutting_planes = 8;

}  // namespace lockstep
