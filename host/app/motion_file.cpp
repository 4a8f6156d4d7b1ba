#include "host/app/motion_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

constexpr std::size_t most_memory = std::size_t{64} << 20;  // bytes, of keyframes that wait to be written

std::span<const unsigned char> bytes_of(const float* first, std::size_t count) {
  return {reinterpret_cast<const unsigned char*>(first), count * sizeof(float)};
}

}  // namespace

MotionFile::MotionFile(const std::string& path, MotionGltf gltf, u32 keyframes) : file_(path), gltf_(std::move(gltf)) {
  if (gltf_.size() > MotionGltf::largest_file)
    throw Error(Failure::input, path,
                fmt::format("would have {} bytes, a binary glTF file ends at {}; ask for a lower --fps", gltf_.size(),
                            MotionGltf::largest_file));
  const std::size_t bodies = gltf_.moving().size();
  if (bodies > 0) most_kept_ = std::clamp(most_memory / (bodies * 28), std::size_t{1}, std::size_t{keyframes});
  last_.resize(bodies);
  translations_.resize(3 * bodies * most_kept_);
  rotations_.resize(4 * bodies * most_kept_);
  file_.write(gltf_.head());
}

void MotionFile::add(std::span<const RenderPose> poses) {
  const std::span<const u32> moving = gltf_.moving();
  for (std::size_t i = 0; i < moving.size(); ++i) {
    RenderPose pose = poses[moving[i]];
    // a body that has flown to where there are no numbers stays where it was
    if (!pose.position.allFinite() || !pose.rotation.coeffs().allFinite()) pose = last_[i];
    pose.rotation.normalize();
    // of the two quaternions of a pose the one on the side of the last: some viewers go the long way round otherwise
    if (pose.rotation.dot(last_[i].rotation) < 0) pose.rotation.coeffs() *= -1;
    last_[i] = pose;
    std::copy_n(pose.position.data(), 3, &translations_[3 * (i * most_kept_ + kept_)]);
    std::copy_n(pose.rotation.coeffs().data(), 4, &rotations_[4 * (i * most_kept_ + kept_)]);
  }
  if (++kept_ == most_kept_) write_kept();
}

void MotionFile::write_kept() {
  for (std::size_t i = 0; i < gltf_.moving().size(); ++i) {
    file_.write_at(gltf_.translations_at(i) + 12 * written_, bytes_of(&translations_[3 * i * most_kept_], 3 * kept_));
    file_.write_at(gltf_.rotations_at(i) + 16 * written_, bytes_of(&rotations_[4 * i * most_kept_], 4 * kept_));
  }
  written_ += kept_;
  kept_ = 0;
}

void MotionFile::close() {
  write_kept();
  file_.publish();
}

}  // namespace lockstep::app
