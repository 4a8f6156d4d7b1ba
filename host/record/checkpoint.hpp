// Checkpoints: the state of a simulation in a file, to go on from on any device (docs/how_to/record_and_verify.md).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/record/identity.hpp"

namespace lockstep {

inline constexpr std::string_view checkpoint_signature = "lockstep checkpoint";

/// What a checkpoint says of itself beside the state.
struct CheckpointLabel {
  std::string scene, device;
  SceneIdentity identity;
  std::uint64_t state_hash = 0;  // of all worlds, as in reports
  std::string oracle = {};       // that made it; empty: the stages, or an older version that did not say
};

/// The buffers that a checkpoint holds: the persistent ones of these features.
std::vector<Buffer> persistent_buffers(Features features);

/// The bytes of a checkpoint file.
template <class real>
std::vector<unsigned char> encode_checkpoint(const CheckpointLabel& label, const Buffers<real>& persistent,
                                             Features features);

/// A checkpoint file of a file of HDF5: the first line of text with its length and hash, and the file.
std::vector<unsigned char> seal_checkpoint(std::span<const unsigned char> contents);

/// The file of HDF5 in a checkpoint file. Throws Error (input) where the bytes are no checkpoint, or not a whole one.
std::vector<unsigned char> checkpoint_contents(std::span<const unsigned char> bytes, const std::string& path);

/// Puts the state of a checkpoint into a compiled scene. Throws Error (input) where the bytes are no whole checkpoint
/// of this scene with these settings and in this precision; `path` stands for the file in errors, `scene` for the
/// scene.
template <class real>
CheckpointLabel resume_from(std::span<const unsigned char> bytes, const std::string& path, const std::string& scene,
                            InitialState<real>& state);

}  // namespace lockstep
