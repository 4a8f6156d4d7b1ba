// A motion that is written to a file while it is computed or read: keyframes come one after the other, and lie in the
// file body by body.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/record/whole_file.hpp"
#include "host/render/motion_gltf.hpp"

namespace lockstep::app {

class MotionFile {
 public:
  /// Throws Error (input) where the motion is larger than the format can be.
  MotionFile(const std::string& path, MotionGltf gltf, u32 keyframes);

  /// The next keyframe: the poses of all bodies.
  void add(std::span<const RenderPose> poses);
  /// After the last one.
  void close();

 private:
  void write_kept();

  NewFile file_;
  MotionGltf gltf_;
  std::size_t most_kept_ = 1, kept_ = 0, written_ = 0;  // keyframes
  std::vector<RenderPose> last_;                        // of the bodies that move
  std::vector<float> translations_, rotations_;         // of these, most_kept_ keyframes each
};

}  // namespace lockstep::app
