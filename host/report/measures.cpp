#include "host/report/measures.hpp"

#include <algorithm>
#include <limits>

#include "host/contact_geometry.hpp"
#include "host/in_double.hpp"
#include "host/report/particle_overlap.hpp"

namespace lockstep {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// One dynamic body in double.
struct Body {
  double mass;
  Vector3d x, v, w, angular_momentum;  // the last about its centre of mass, or its pivot
  bool pivoted;
};

template <class real>
Body body_at(const Buffers<real>& buffers, Features features, u32 i) {
  Body body;
  const Mass<real>& m = buffers.masses[i];
  const Quaterniond q = rotation(buffers.orientations[i]);
  body.mass = double(m.mass);
  body.x = vector3(buffers.positions[i]);
  body.v = vector3(buffers.motions[i].v);
  body.w = vector3(buffers.motions[i].w);
  body.angular_momentum = q * vector3(m.inertia).cwiseProduct(q.conjugate() * body.w);
  body.pivoted = has(features, Feature::pivots) && buffers.pivots[i].pivoted != real(0);
  return body;
}

template <class real>
WorldMeasures measure_world(const Buffers<real>& buffers, Features features, u32 world) {
  WorldMeasures result;
  const WorldRange& range = buffers.world_ranges[world];
  const Vector3d gravity = vector3(buffers.gravities[world]);

  std::vector<Body> bodies;
  Vector3d moment = Vector3d::Zero();
  for (u32 i = range.first_body; i < range.first_body + range.body_count; ++i) {
    if (buffers.body_infos[i].kind != BODY_DYNAMIC) continue;
    const Body body = body_at(buffers, features, i);
    // the moments of a pivoted body are about the pivot: they hold the motion of the centre of mass
    const double linear = body.pivoted ? 0 : body.mass * body.v.squaredNorm();
    result.kinetic += 0.5 * (linear + body.w.dot(body.angular_momentum));
    result.potential -= body.mass * gravity.dot(body.x);
    if (body.pivoted) continue;
    result.mass += body.mass;
    result.momentum += body.mass * body.v;
    result.momentum_size += body.mass * body.v.norm();
    moment += body.mass * body.x;
    bodies.push_back(body);
  }
  result.weight = result.mass * gravity;

  const Vector3d centre = result.mass > 0 ? Vector3d(moment / result.mass) : Vector3d::Zero();
  for (const Body& body : bodies) {
    const Vector3d orbital = body.mass * (body.x - centre).cross(body.v);
    result.angular_momentum += orbital + body.angular_momentum;
    result.angular_momentum_size += orbital.norm() + body.angular_momentum.norm();
  }
  return result;
}

// Of the shape of a contact that is less deep; infinite where neither has an inside.
template <class real>
double inner_radius(const Buffers<real>& buffers, const Contact& contact) {
  double least = std::numeric_limits<double>::infinity();
  for (const u32 shape : {contact.shape_a, contact.shape_b})
    if (const double radius = double(buffers.shapes[shape].size[3]); radius > 0) least = std::min(least, radius);
  return least;
}

template <class real>
Penetration penetration(const Buffers<real>& buffers, u32 contacts) {
  Penetration result;
  double sum = 0;
  for (u32 i = 0; i < contacts; ++i) {
    const double depth = -contact_geometry(buffers, i).gap();
    if (depth <= 0) continue;
    ++result.touching;
    sum += depth;
    result.max = std::max(result.max, depth);
    result.ratio = std::max(result.ratio, depth / inner_radius(buffers, buffers.contacts[i]));
  }
  if (result.touching > 0) result.mean = sum / result.touching;
  return result;
}

template <class real>
double pivot_drift(const Buffers<real>& buffers, u32 bodies) {
  double drift = 0;
  for (u32 i = 0; i < bodies; ++i) {
    const Pivot<real>& pivot = buffers.pivots[i];
    if (pivot.pivoted == real(0)) continue;
    const Vector3d point =
        vector3(buffers.positions[i]) - rotation(buffers.orientations[i]) * vector3(pivot.com_offset_body);
    drift = std::max(drift, (point - vector3(pivot.point_world)).norm());
  }
  return drift;
}

template <class real>
WorstContact name_contact(const Buffers<real>& buffers, const Contact& contact) {
  return {contact.world, buffers.body_infos[contact.body_a].id, buffers.body_infos[contact.body_b].id,
          buffers.shape_infos[contact.shape_a].id, buffers.shape_infos[contact.shape_b].id};
}

template <class real>
WorstContact name_joint(const Buffers<real>& buffers, const JointInfo& joint) {
  const auto id = [&](u32 body) { return body < buffers.body_infos.size() ? buffers.body_infos[body].id : NONE; };
  return {joint.world, id(joint.body_a), id(joint.body_b), NONE, NONE};
}

}  // namespace

double Measures::energy() const {
  double sum = 0;
  for (const WorldMeasures& world : worlds) sum += world.kinetic + world.potential;
  return sum;
}

std::vector<Buffer> measured_buffers(Features features) {
  std::vector<Buffer> buffers = {Buffer::world_ranges, Buffer::gravities,    Buffer::body_infos, Buffer::masses,
                                 Buffer::positions,    Buffer::orientations, Buffer::motions};
  if (has(features, Feature::pivots)) buffers.push_back(Buffer::pivots);
  if (has(features, Feature::gyroscopic)) buffers.push_back(Buffer::free_rotations);
  if (has(features, Feature::joints)) {
    for (const Buffer buffer :
         {Buffer::joint_infos, Buffer::joints, Buffer::screw_leads, Buffer::rolling_radii, Buffer::joint_lanes,
          Buffer::joint_blocks, Buffer::joint_impulses, Buffer::joint_angles})
      buffers.push_back(buffer);
  }
  if (has(features, Feature::couplings)) {
    for (const Buffer buffer :
         {Buffer::couplings, Buffer::coupling_infos, Buffer::coupled_joints, Buffer::coupling_ratios})
      buffers.push_back(buffer);
  }
  if (has(features, Feature::sleeping)) buffers.push_back(Buffer::sleepers);
  if (has(features, Feature::particles)) {
    for (const Buffer buffer :
         {Buffer::particle_laws, Buffer::particle_bodies, Buffer::particle_offsets, Buffer::particle_planes,
          Buffer::plane_bodies, Buffer::neighbour_starts, Buffer::neighbours})
      buffers.push_back(buffer);
  }
  if (has(features, Feature::contacts)) {
    for (const Buffer buffer : {Buffer::shape_infos, Buffer::shapes, Buffer::contacts, Buffer::contact_points,
                                Buffer::contact_slots, Buffer::contact_blocks, Buffer::cached_impulses})
      buffers.push_back(buffer);
    if (has(features, Feature::soft_contacts)) buffers.push_back(Buffer::softness_blocks);
    if (has(features, Feature::impact_laws)) buffers.push_back(Buffer::slide_blocks);
    if (has(features, Feature::angular_friction)) {
      for (const Buffer buffer : {Buffer::angular_friction_blocks, Buffer::ellipse_blocks, Buffer::cached_moments})
        buffers.push_back(buffer);
    }
    if (has(features, Feature::patches)) {
      for (const Buffer buffer : {Buffer::block_bodies, Buffer::patch_blocks, Buffer::patch_impulses})
        buffers.push_back(buffer);
    }
  }
  return buffers;
}

template <class real>
Measures measure(const Buffers<real>& buffers, const Sizes& sizes, Features features, const StepParams<real>& params,
                 std::span<const u32> counters) {
  Measures result;
  for (u32 world = 0; world < sizes.worlds; ++world) result.worlds.push_back(measure_world(buffers, features, world));
  for (u32 i = 0; i < sizes.bodies; ++i)
    if (buffers.body_infos[i].kind == BODY_DYNAMIC)
      result.max_speed = std::max(result.max_speed, vector3(buffers.motions[i].v).norm());
  if (has(features, Feature::joint_springs)) {
    for (u32 i = 0; i < sizes.joints; ++i)
      result.worlds[buffers.joint_infos[i].world].potential += spring_energy(buffers, params, i);
  }
  if (has(features, Feature::couplings)) {
    for (u32 k = 0; k < sizes.couplings; ++k)
      result.worlds[buffers.coupling_infos[k].world].potential += coupling_energy(buffers, params, k);
  }
  if (has(features, Feature::joint_impedances)) {
    for (u32 i = 0; i < sizes.joints; ++i)
      result.worlds[buffers.joint_infos[i].world].kinetic += armature_energy(buffers, params, i);
  }
  if (has(features, Feature::pivots)) result.pivot_drift = pivot_drift(buffers, sizes.bodies);

  if (has(features, Feature::joints)) result.joint_drift = joint_drift(buffers);
  if (has(features, Feature::contacts)) result.contacts = counters[COUNTER_CONTACTS];
  if (result.contacts > 0) result.penetration = penetration(buffers, result.contacts);
  if (has(features, Feature::particles)) result.penetration = particle_overlap(buffers);
  if (result.contacts > 0 || has(features, Feature::joints)) {
    const double roundoff = sizeof(real) == 4 ? 0x1p-24 : 0x1p-53;
    const ContactSystem system = contact_system(buffers, counters, features);
    if (system.contacts.empty() && system.joints.empty()) return result;  // all joints sleep
    result.residual = residual(system, roundoff);
    result.worst = result.residual->worst_is_joint
                       ? name_joint(buffers, buffers.joint_infos[system.joints[result.residual->worst].joint])
                       : name_contact(buffers, buffers.contacts[system.contacts[result.residual->worst].contact]);
  }
  return result;
}

template <class real>
bool momentum_is_conserved(const Buffers<real>& buffers, Features features) {
  if (has(features, Feature::pivots) || !joints_conserve_momentum(buffers)) return false;
  const auto moves = [&](u32 body) { return buffers.body_infos[body].kind == BODY_DYNAMIC; };
  return buffers.plane_bodies.empty() &&
         std::all_of(buffers.particle_bodies.begin(), buffers.particle_bodies.end(), moves) &&
         std::all_of(buffers.shape_infos.begin(), buffers.shape_infos.end(),
                     [&](const ShapeInfo& shape) { return moves(shape.body); });
}

#define INSTANTIATE(real)                                                                          \
  template Measures measure(const Buffers<real>&, const Sizes&, Features, const StepParams<real>&, \
                            std::span<const u32>);                                                 \
  template bool momentum_is_conserved(const Buffers<real>&, Features);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
