// Where a contact is in the world and how it lies, at the poses that a state has now; in double, for reports, pictures
// and the library.
#pragma once

#include <Eigen/Geometry>

#include "host/buffers.hpp"
#include "host/in_double.hpp"

namespace lockstep {

struct ContactGeometry {
  Eigen::Vector3d anchor_a, anchor_b;  // m; the surface of a round shape is a radius away from its anchor
  Eigen::Vector3d normal;              // from b to a, unit
  double radius_a = 0, radius_b = 0;   // m

  /// On the surface of a, m.
  Eigen::Vector3d point() const { return anchor_a - radius_a * normal; }
  /// Of the two surfaces, along the normal, m; negative where they overlap.
  double gap() const { return normal.dot(anchor_a - anchor_b) - (radius_a + radius_b); }
};

/// Of a contact of two bodies whose normal is in this frame. Reads the buffers positions and orientations.
template <class real>
ContactGeometry contact_geometry(const Buffers<real>& buffers, u32 body_a, u32 body_b, u32 frame,
                                 const ContactPoint<real>& point) {
  const Eigen::Quaterniond orientation_a = rotation(buffers.orientations[body_a]);
  const Eigen::Quaterniond orientation_b = rotation(buffers.orientations[body_b]);
  ContactGeometry geometry = {vector3(buffers.positions[body_a]) + orientation_a * vector3(point.anchor_a),
                              vector3(buffers.positions[body_b]) + orientation_b * vector3(point.anchor_b),
                              vector3(point.normal), double(point.radius_a), double(point.radius_b)};
  if (frame == NORMAL_OF_A) geometry.normal = orientation_a * geometry.normal;
  if (frame == NORMAL_OF_B) geometry.normal = orientation_b * geometry.normal;
  if (frame == NORMAL_BETWEEN && geometry.anchor_a != geometry.anchor_b)
    geometry.normal = (geometry.anchor_a - geometry.anchor_b).normalized();
  return geometry;
}

/// Of a contact in the list. Reads contacts and contact_points too.
template <class real>
ContactGeometry contact_geometry(const Buffers<real>& buffers, u32 index) {
  const Contact& contact = buffers.contacts[index];
  return contact_geometry(buffers, contact.body_a, contact.body_b, contact.normal, buffers.contact_points[index]);
}

/// The impulse on body a that a contact passes on to the next step, that of its last sub-step, world frame, N s.
template <class real>
Eigen::Vector3d contact_impulse(const ContactImpulse<real>& impulse, const ContactGeometry& geometry) {
  return double(impulse.normal) * geometry.normal + vector3(&impulse.tangent_x);
}

/// Of a contact in the list, at the end of a step: of the whole step where the scene sums impulses, else of its last
/// sub-step. Reads contact_impulse_buffers().
template <class real>
Eigen::Vector3d contact_impulse(const Buffers<real>& buffers, u32 index, const ContactGeometry& geometry) {
  if (buffers.impulse_sums.empty()) return contact_impulse(buffers.cached_impulses[index], geometry);
  const u32 slot = buffers.contact_slots[index];
  const ImpulseSumBlock<real>& sum = buffers.impulse_sums[slot / PACK];
  return {double(sum.x[slot % PACK]), double(sum.y[slot % PACK]), double(sum.z[slot % PACK])};
}

/// Adds the buffers of a scene with these features that contacts and their impulses are told from.
inline void add_contact_impulse_buffers(Features features, std::vector<Buffer>& buffers) {
  buffers.insert(buffers.end(), {Buffer::positions, Buffer::orientations, Buffer::contacts, Buffer::contact_points,
                                 Buffer::cached_impulses});
  if (has(features, Feature::summed_contacts))
    buffers.insert(buffers.end(), {Buffer::contact_slots, Buffer::impulse_sums});
}

/// In which told impulses act, s: a step where the scene sums them, else a sub-step.
template <class real>
double impulse_time(const StepParams<real>& params, Features features) {
  return double(params.dt) * (has(features, Feature::summed_impulses) ? params.substeps : 1);
}

}  // namespace lockstep
