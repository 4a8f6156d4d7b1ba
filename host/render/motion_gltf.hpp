// A motion as one binary file of glTF 2.0 (ISO/IEC 12113): bodies, and where they are over time, for programs that show
// and edit scenes. y is up in it, by one node above all bodies.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/render/scene_model.hpp"

namespace lockstep {

/// What of a body the scene model does not know.
struct MotionBody {
  std::string name;
  bool moves = true;  // false: it has no keyframes
  RenderPose start;
};

/// The file but for its keyframes: their place is known, so that they can be written in any order. For each body that
/// moves there are as many translations (x y z) as there are keyframes, one behind the other, and as many rotations
/// (x y z w), all of them floats.
class MotionGltf {
 public:
  /// Planes become squares about `region`, which is what moves. `seconds`: of the keyframes, ascending; of fewer than
  /// two there is no animation.
  MotionGltf(const SceneModel& model, std::span<const MotionBody> bodies, const Region& region,
             std::span<const float> seconds, const std::string& name);

  /// All bytes before the keyframes.
  std::span<const unsigned char> head() const { return head_; }
  /// Of the whole file, bytes. The format ends at largest_file.
  std::uint64_t size() const { return size_; }
  static constexpr std::uint64_t largest_file = 0xffffffffu;

  /// The bodies that have keyframes, and where those of one of them begin, bytes.
  std::span<const u32> moving() const { return moving_; }
  std::uint64_t translations_at(std::size_t of_moving) const { return head_.size() + of_moving * 12 * keyframes_; }
  std::uint64_t rotations_at(std::size_t of_moving) const {
    return translations_at(moving_.size()) + of_moving * 16 * keyframes_;
  }

 private:
  std::vector<unsigned char> head_;
  std::vector<u32> moving_;
  std::uint64_t keyframes_ = 0, size_ = 0;
};

}  // namespace lockstep
