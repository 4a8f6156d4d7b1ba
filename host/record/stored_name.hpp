// The names of buffers in files: those that recordings and checkpoints had when each buffer first came into them.
#pragma once

#include <string_view>

#include "host/buffers.hpp"

namespace lockstep {

/// Name of the dataset of a buffer. It outlives a change of the buffer's name, so that old files stay readable and
/// the hashes that compare files with scenes stay as they are. Ends with a zero.
constexpr std::string_view stored_name(Buffer buffer) {
  switch (buffer) {
    case Buffer::top_level_shapes: return "loose_shapes";
    case Buffer::angular_friction_pairs: return "turn_pairs";
    case Buffer::static_friction_pairs: return "hold_pairs";
    case Buffer::anisotropy_pairs: return "grain_pairs";
    case Buffer::screw_leads: return "screw_rises";
    case Buffer::joint_side_starts: return "joint_part_starts";
    case Buffer::joint_side_slots: return "joint_parts";
    default: return info(buffer).name;
  }
}

}  // namespace lockstep
