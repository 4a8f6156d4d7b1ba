// A picture of two states that should be one: where device and reference differ.
#pragma once

#include <string>
#include <vector>

#include "host/buffers.hpp"
#include "host/render/picture.hpp"
#include "host/render/scene_model.hpp"

namespace lockstep {

/// What a word of a buffer belongs to.
struct DifferenceLocation {
  std::vector<u32> bodies;  // that can be shown; empty where it belongs to none
  u32 contact = NONE;       // into the list of contacts
};

/// Of a word of an element; `state` is the state of either side, all of it.
template <class real>
DifferenceLocation location_of(Buffer buffer, std::size_t element, u32 word, const Buffers<real>& state);

/// The buffers of the device that the picture looks at.
std::vector<Buffer> difference_buffers(Features features);

inline constexpr Color device_color = {0.95f, 0.50f, 0.08f}, reference_color = {0.10f, 0.42f, 0.90f},
                       shared_color = {0.70f, 0.22f, 0.60f};

/// Both states around a location: bodies that are seen to stand elsewhere in both colours, others in grey; how fast the
/// bodies there are, and where the contact is, by marks. `caption`: what differs.
template <class real>
Picture draw_difference(const Buffers<real>& device, const Buffers<real>& reference, SceneModel model,
                        const DifferenceLocation& location, const std::vector<std::string>& caption, u32 width,
                        u32 height);

}  // namespace lockstep
