#include "host/render/difference.hpp"

#include <algorithm>

#include "host/render/legend.hpp"
#include "host/render/marks.hpp"

namespace lockstep {

using Eigen::Quaternionf;
using Eigen::Vector3f;

namespace {

constexpr Color other_color = {0.80f, 0.81f, 0.82f};
constexpr float half_seen = 0.6f;  // of a body that stands at two places

void add_body(DifferenceLocation& location, std::size_t body, std::size_t bodies) {
  const u32 index = static_cast<u32>(body);
  if (body < bodies && std::find(location.bodies.begin(), location.bodies.end(), index) == location.bodies.end())
    location.bodies.push_back(index);
}

template <class real>
void add_contact(DifferenceLocation& location, std::size_t contact, const Buffers<real>& state) {
  if (contact >= state.contacts.size()) return;
  location.contact = static_cast<u32>(contact);
  add_body(location, state.contacts[contact].body_a, state.positions.size());
  add_body(location, state.contacts[contact].body_b, state.positions.size());
}

template <class real>
void add_shape(DifferenceLocation& location, std::size_t shape, const Buffers<real>& state) {
  if (shape < state.shape_infos.size()) add_body(location, state.shape_infos[shape].body, state.positions.size());
}

// The pair whose lane of a block, or one of its rows, it is.
template <class real>
void add_lane(DifferenceLocation& location, std::size_t block, u32 lane, const Buffers<real>& state) {
  if (block < state.block_bodies.size()) add_contact(location, state.block_bodies[block].contact[lane], state);
}

// Whether two poses can be told apart in a picture of something so large.
bool visibly_different(const RenderPose& a, const RenderPose& b, double size) {
  return double((a.position - b.position).norm()) > 0.002 * size || a.rotation.angularDistance(b.rotation) > 0.01f;
}

template <class real>
Vector3f velocity_of(const Buffers<real>& state, u32 body) {
  const real* v = state.motions[body].v;
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// Four times as wide as the bodies that it is about.
Region around(const SceneModel& model, const DifferenceLocation& location, const std::vector<RenderPose>& a,
              const std::vector<RenderPose>& b) {
  const auto add = [&](Region& region, const std::vector<RenderPose>& poses) {
    for (const Extent& extent : model.extents(poses, location.bodies)) {
      region.extend(extent.center - extent.half);
      region.extend(extent.center + extent.half);
    }
  };
  Region region;
  add(region, a);
  add(region, b);
  if (region.isEmpty()) return region_of(model.extents(b));
  const Eigen::Vector3d middle = region.center(), half = 0.5 * region.diagonal();
  const Eigen::Vector3d wide = (4 * half).cwiseMax(Eigen::Vector3d::Constant(2 * half.norm()));
  return Region(middle - wide, middle + wide);
}

}  // namespace

template <class real>
DifferenceLocation location_of(Buffer buffer, std::size_t element, u32 word, const Buffers<real>& state) {
  DifferenceLocation location;
  const u32 lane = word % PACK;  // blocks are arrays of so many lanes
  const std::size_t bodies = state.positions.size();
  switch (info(buffer).domain) {
    case Domain::bodies:
    case Domain::body_lines: add_body(location, element, bodies); break;
    case Domain::shapes: add_shape(location, element, state); break;
    case Domain::top_level:
      add_shape(location, element < state.top_level_shapes.size() ? state.top_level_shapes[element] : element, state);
      break;
    case Domain::pairs:
      if (element < state.pairs.size()) {
        add_shape(location, state.pairs[element].shape_a, state);
        add_shape(location, state.pairs[element].shape_b, state);
      }
      break;
    case Domain::contacts:
    case Domain::cached: add_contact(location, element, state); break;
    case Domain::blocks: add_lane(location, element, lane, state); break;
    case Domain::rows: {
      std::size_t block = 0;
      while (block < state.block_rows.size() &&
             !(element >= state.block_rows[block].first &&
               element < std::size_t{state.block_rows[block].first} + state.block_rows[block].count))
        ++block;
      add_lane(location, block, lane, state);
      break;
    }
    case Domain::joint_blocks: {
      const u32 joint = element < state.joint_lanes.size() ? state.joint_lanes[element].joint[lane] : NONE;
      if (joint >= state.joint_infos.size()) break;
      add_body(location, state.joint_infos[joint].body_a, bodies);
      add_body(location, state.joint_infos[joint].body_b, bodies);
      break;
    }
    default: break;  // of the whole scene, or of a part without a place
  }
  return location;
}

std::vector<Buffer> difference_buffers(Features features) {
  std::vector<Buffer> buffers = {Buffer::positions, Buffer::orientations, Buffer::motions, Buffer::counters};
  if (has(features, Feature::contacts))
    for (const Buffer buffer : contact_mark_buffers(features))
      if (std::ranges::find(buffers, buffer) == buffers.end()) buffers.push_back(buffer);
  return buffers;
}

template <class real>
Picture draw_difference(const Buffers<real>& device, const Buffers<real>& reference, SceneModel model,
                        const DifferenceLocation& location, const std::vector<std::string>& caption, u32 width,
                        u32 height) {
  Renderer renderer(width, height);
  model.add_meshes_to(renderer);
  const std::vector<RenderPose> device_poses = poses_of(device.positions, device.orientations);
  const std::vector<RenderPose> poses = poses_of(reference.positions, reference.orientations);
  Drawing drawing;
  drawing.region = around(model, location, device_poses, poses);
  drawing.camera = frame_region(drawing.region, static_cast<double>(width) / height);
  std::vector<Look> device_looks(model.bodies(), Look{device_color, half_seen, false});
  std::vector<Look> looks(model.bodies(), Look{other_color, 1, true});
  for (const u32 body : location.bodies) looks[body].color = shared_color;
  const double size = drawing.region.isEmpty() ? 1 : drawing.region.diagonal().norm();
  for (u32 body = 0; body < model.bodies(); ++body) {
    if (!visibly_different(device_poses[body], poses[body], size)) continue;
    looks[body] = {reference_color, half_seen, true};
    device_looks[body].shown = true;
  }
  model.draw(poses, looks, false, drawing);
  model.draw(device_poses, device_looks, false, drawing);

  const float unit = static_cast<float>(height) / 720;
  const auto mark = [&](const Buffers<real>& state, const std::vector<RenderPose>& at, const Color& color, float wide) {
    for (const u32 body : location.bodies) {
      const float seconds = 0.25f * static_cast<float>(drawing.region.diagonal().norm()) /
                            std::max(velocity_of(reference, body).norm(), 1e-6f);
      add_line(drawing, height, at[body].position, at[body].position + seconds * velocity_of(state, body), wide * unit,
               color);
    }
    const u32 contacts = state.counters.empty() ? 0 : state.counters[COUNTER_CONTACTS];
    if (location.contact < contacts)
      add_ball(drawing, height, contact_marks(state, contacts, 1.0)[location.contact].point, 3 * wide * unit, color);
  };
  // the wider one first, so that both are seen where they are one
  mark(device, device_poses, device_color, 5);
  mark(reference, poses, reference_color, 2.5f);
  Picture picture = renderer.draw(drawing);
  Legend legend;
  legend.title = "two states that should be one";
  legend.entries = {{{device_color}, "device"}, {{reference_color}, "reference"}};
  legend.entries.push_back({{shared_color}, "what differs, by less than is seen"});
  legend.entries.push_back({{other_color}, "others"});
  draw_legend(picture, legend);
  draw_caption(picture, caption);
  return picture;
}

#define INSTANTIATE(real)                                                                                             \
  template DifferenceLocation location_of(Buffer, std::size_t, u32, const Buffers<real>&);                            \
  template Picture draw_difference(const Buffers<real>&, const Buffers<real>&, SceneModel, const DifferenceLocation&, \
                                   const std::vector<std::string>&, u32, u32);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
