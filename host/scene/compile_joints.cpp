#include "host/scene/compile_joints.hpp"

#include <algorithm>
#include <cmath>

#include "host/error.hpp"
#include "host/scene/body_joints.hpp"
#include "host/scene/compile_articulations.hpp"
#include "host/scene/compile_couplings.hpp"
#include "host/scene/expect_fits.hpp"
#include "host/scene/joint_angles.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/joint_springs.hpp"
#include "host/scene/rounding.hpp"
#include "host/scene/spring.hpp"

namespace lockstep {

namespace {

// Whether armature, or a spring beside limits, acts on its free coordinate.
bool has_impedance(const JointDescription& joint) { return joint.armature > 0 || (joint.limited && joint.spring); }

Quaternion back(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

// Where the bodies of a joint stand for its anchors and its axis: where they are at load unless it says otherwise.
ReferencePoses reference_poses_of(const Scene& scene, const JointDescription& joint) {
  ReferencePoses reference_poses;
  if (joint.reference_poses) reference_poses = *joint.reference_poses;
  const auto set_pose = [&](u32 body, Vector3& position, Quaternion& orientation) {
    if (body == NONE) position = {0, 0, 0}, orientation = {0, 0, 0, 1};
    if (body == NONE || joint.reference_poses) return;
    position = scene.bodies[body].position;
    orientation = scene.bodies[body].orientation;
  };
  set_pose(joint.body_a, reference_poses.position_a, reference_poses.orientation_a);
  set_pose(joint.body_b, reference_poses.position_b, reference_poses.orientation_b);
  return reference_poses;
}

Vector3 inside(const Vector3& position, const Quaternion& orientation, const Vector3& point) {
  return exact::rotate(back(orientation), exact::subtract(point, position));
}

template <class real>
void store(real* to, const Vec4<real>& from, unsigned count) {
  const real all[] = {from.x, from.y, from.z, from.w};
  std::copy_n(all, count, to);
}

// How a sub-step takes the error of a joint back.
template <class real>
void set_softness(const Settings& settings, const JointDescription& in, const Origin& origin, Joint<real>& out) {
  const bool spring = in.frequency > 0;
  const double h = settings.dt / substeps_of(settings);
  Correction correction = {settings.stabilization == Stabilization::velocities ? settings.correction : 0, 0};
  if (spring) correction = spring_correction(h, in.frequency, in.damping);
  if (!spring && settings.solver == Solver::small_steps)
    correction = spring_correction(h, settings.joint_frequency, settings.joint_damping);
  if (is_non_holonomic(in.kind)) correction.softness = 0;  // what slipped would not come back
  out.correction = rounded<real>(correction.share, "the correction of a joint", origin);
  out.softness = rounded<real>(correction.softness, "the softness of a joint", origin);
  out.spring = spring;
}

// Armature, and the spring; one that is alone has the place of the limits.
template <class real>
void set_impedance(const Settings& settings, const JointDescription& in, const Origin& origin, Joint<real>& out) {
  if (in.armature > 0) {
    out.armature = rounded_positive<real>(in.armature, "the armature", origin);
    rounded_positive<real>(1 / in.armature, "1 / armature", origin);
  }
  if (!in.spring) return;
  const auto [rate, compliance, rest] = make_spring<real>(settings, *in.spring, origin);
  if (has_impedance(in)) {
    if (in.spring->forces != any_force)
      throw Error(Failure::input, "a spring", "of bounded force has a joint without limits and armature to itself");
    out.side_rate = rate;
    out.side_compliance = compliance;
    out.side_rest = rest;
    return;
  }
  out.limited = 1;
  out.low = out.high = rest;
  out.rate = rate;
  out.spring_compliance = compliance;
}

template <class real>
Joint<real> make_joint(const Settings& settings, const Scene& scene, const JointDescription& in, const Origin& origin) {
  const ReferencePoses reference_poses = reference_poses_of(scene, in);
  const Quaternion frame = has_key(in.kind, JOINT_HAS_AXES) ? exact::rotation_to_frame(in.axis, in.second_axis)
                                                            : exact::rotation_from_z_to(in.axis);
  Joint<real> out = {};
  store(out.anchor_a,
        rounded<real>(inside(reference_poses.position_a, reference_poses.orientation_a, in.anchor_a), "anchor", origin),
        3);
  store(out.anchor_b,
        rounded<real>(inside(reference_poses.position_b, reference_poses.orientation_b, in.anchor_b), "anchor", origin),
        3);
  store(out.frame_a, rounded<real>(exact::unit(exact::multiply(back(reference_poses.orientation_a), frame))), 4);
  store(out.frame_b, rounded<real>(exact::unit(exact::multiply(back(reference_poses.orientation_b), frame))), 4);
  set_softness(settings, in, origin, out);
  out.limited = in.limited;
  out.low = rounded<real>(in.low, "limits", origin);
  out.high = rounded<real>(in.high, "limits", origin);
  set_impedance(settings, in, origin, out);
  if (free_of(in.kind) == FREE_LENGTH && !in.limited && !in.spring) {  // a rod
    out.limited = 1;
    out.low = out.high = rounded<real>(exact::length(exact::subtract(in.anchor_b, in.anchor_a)), "anchors", origin);
  }
  const JointDrive drive = drive_of(in);
  out.motor_speed = rounded<real>(drive.speed, "the speed of a motor", origin);
  out.motor_force = rounded<real>(drive.force, "the force of a motor, or of friction", origin);
  return out;
}

// Travel of a screw for a radian; 0 of other joints.
template <class real>
real screw_lead(const JointDescription& in, const Origin& origin) {
  if (!has_key(in.kind, JOINT_HAS_PITCH)) return 0;
  const double lead = in.pitch / (2 * exact::pi);
  rounded_positive<real>(std::abs(lead), "pitch / 2 pi of a screw", origin);
  return static_cast<real>(lead);
}

template <class real>
real make_radius(const JointDescription& in, const Origin& origin) {
  return has_key(in.kind, JOINT_HAS_RADIUS) ? rounded_positive<real>(in.radius, "the radius of what rolls", origin)
                                            : real(0);
}

// Of the joints that are solved so, NONE of the others. Greedy in the order of ids, so that a world has the colours it
// has alone. A body that cannot move takes none.
template <class real>
std::vector<u32> joint_colors(u32 direct, const Buffers<real>& b) {
  std::vector<std::uint64_t> taken(b.body_infos.size() + 1, 0);
  std::vector<u32> colors;
  for (const JointInfo& joint : b.joint_infos) {
    if (joint.direct != direct) {
      colors.push_back(NONE);
      continue;
    }
    std::uint64_t used = 0;
    const u32 bodies[] = {joint.body_a, joint.body_b};
    for (const u32 body : bodies) used |= taken[body];
    u32 color = 0;
    while (color < MAX_COLORS && (used >> color & 1) != 0) ++color;
    colors.push_back(color);
    if (color == MAX_COLORS) continue;
    for (const u32 body : bodies) {
      const bool moves = body < b.body_infos.size() && b.body_infos[body].kind == BODY_DYNAMIC;
      if (moves) taken[body] |= std::uint64_t{1} << color;
    }
  }
  return colors;
}

JointLanes empty_lanes(u32 null_body) {
  JointLanes lanes = {};
  std::ranges::fill(lanes.body_a, null_body);
  std::ranges::fill(lanes.body_b, null_body);
  std::ranges::fill(lanes.joint, NONE);
  return lanes;
}

// Each colour starts a block, which is a phase of the sweep; so does each joint that found no colour.
template <class real>
void lay_out_joints(u32 direct, Buffers<real>& b) {
  const std::vector<u32> colors = joint_colors(direct, b);
  const u32 null_body = static_cast<u32>(b.body_infos.size());
  for (u32 color = 0; color <= MAX_COLORS; ++color) {
    u32 count = 0;  // of the phase
    for (u32 i = 0; i < colors.size(); ++i) {
      if (colors[i] != color) continue;
      if (color == MAX_COLORS) count = 0;
      if (count == 0) b.joint_phases.push_back(static_cast<u32>(b.joint_lanes.size()));
      const u32 lane = count++ % PACK;
      if (lane == 0) b.joint_lanes.push_back(empty_lanes(null_body));
      JointLanes& lanes = b.joint_lanes.back();
      const JointInfo& joint = b.joint_infos[i];
      lanes.body_a[lane] = joint.body_a;
      lanes.body_b[lane] = joint.body_b;
      lanes.joint[lane] = i;
      lanes.free[lane] = joint.free;
    }
  }
}

// Those that sweeps solve come first.
template <class real>
void lay_out_joints(Buffers<real>& b) {
  for (const u32 direct : {0u, 1u}) lay_out_joints(direct, b);
  b.joint_phases.push_back(static_cast<u32>(b.joint_lanes.size()));
}

template <class real>
void set_articulations(const Scene& scene, InitialState<real>& state) {
  const JointSolver wanted = scene.settings.joint_solver;
  if (wanted == JointSolver::sweeps) return;
  const bool takes = takes_trees(scene.settings.solver);
  if (!takes && wanted == JointSolver::automatic) return;
  if (!takes)
    throw Error(Failure::input, scene.source + ": /settings/joint_solver",
                "direct goes with the solvers gauss_seidel and cell_gauss_seidel; take one of them, or sweeps");
  find_articulations(wanted == JointSolver::direct ? Trees::all : Trees::that_carry, state.buffers);
  if (state.buffers.links.empty()) return;
  state.features = with(state.features, Feature::articulations);
  state.sizes.articulations = static_cast<u32>(state.buffers.articulations.size());
  state.sizes.links = static_cast<u32>(state.buffers.links.size());
  state.sizes.link_levels = static_cast<u32>(state.buffers.link_levels.size()) - 1;
  if (state.buffers.closures.empty()) return;
  state.features = with(state.features, Feature::closures);
  state.sizes.closures = static_cast<u32>(state.buffers.closures.size());
  state.sizes.closure_columns = count_closure_columns(state.buffers.closure_sets, state.sizes.links);
}

using BodyPair = std::pair<u32, u32>;

// Both ways round; a body's partners stand in a row.
template <class real>
void list_joined(std::vector<BodyPair> pairs, Buffers<real>& b) {
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  b.joined_starts.assign(b.body_infos.size() + 1, 0);
  for (const auto& [body, partner] : pairs) {
    ++b.joined_starts[body + 1];
    b.joined_bodies.push_back(partner);
  }
  for (std::size_t i = 1; i < b.joined_starts.size(); ++i) b.joined_starts[i] += b.joined_starts[i - 1];
}

}  // namespace

template <class real>
void compile_joints(std::span<const Scene> worlds, InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  const Settings& settings = worlds[0].settings;
  const u32 null_body = static_cast<u32>(b.body_infos.size());
  std::vector<BodyPair> joined;
  std::vector<double> starts;
  for (u32 world = 0; world < worlds.size(); ++world) {
    const Scene& scene = worlds[world];
    const u32 first_body = b.world_ranges[world].first_body;
    for (u32 id = 0; id < scene.joints.size(); ++id) {
      const JointDescription& joint = scene.joints[id];
      const u32 body_a = joint.body_a == NONE ? null_body : first_body + joint.body_a;
      const u32 body_b = joint.body_b == NONE ? null_body : first_body + joint.body_b;
      b.joint_infos.push_back({body_a, body_b, world, id, static_cast<u32>(joint.kind), locked_rows(joint.kind),
                               static_cast<u32>(free_of(joint.kind)), 0});
      b.joints.push_back(make_joint<real>(settings, scene, joint, {scene, nullptr, &joint}));
      b.screw_leads.push_back(screw_lead<real>(joint, {scene, nullptr, &joint}));
      b.rolling_radii.push_back(make_radius<real>(joint, {scene, nullptr, &joint}));
      starts.push_back(joint.start);
      if (joint.collide || body_a == null_body || body_b == null_body) continue;
      joined.push_back({body_a, body_b});
      joined.push_back({body_b, body_a});
    }
    for (const auto& [a, partner] : scene.passing) {
      joined.push_back({first_body + a, first_body + partner});
      joined.push_back({first_body + partner, first_body + a});
    }
    if (std::ranges::any_of(scene.joints, [](const JointDescription& joint) { return joint.spring.has_value(); }))
      state.features = with(state.features, Feature::joint_springs);
    if (std::ranges::any_of(scene.joints, has_impedance))
      state.features = with(state.features, Feature::joint_impedances);
  }
  if (std::ranges::any_of(b.screw_leads, [](real lead) { return lead != 0; }))
    state.features = with(state.features, Feature::screws);
  else
    b.screw_leads.clear();
  if (std::ranges::any_of(b.joint_infos, [](const JointInfo& joint) { return COUNTS_REVOLUTIONS(joint); })) {
    state.features = with(state.features, Feature::joint_angles);
    set_joint_angles(starts, settings.dt / substeps_of(settings), b);
  }
  const auto rolls = [](const JointInfo& joint) { return is_non_holonomic(static_cast<JointKind>(joint.kind)); };
  if (std::ranges::any_of(b.joint_infos, rolls))
    state.features = with(state.features, Feature::non_holonomic);
  else
    b.rolling_radii.clear();
  if (b.joints.empty()) return;
  set_articulations(worlds[0], state);
  lay_out_joints(b);
  set_link_joints(b);
  list_joined(std::move(joined), b);
  list_body_joints(b);
  // impulses of oracles are not bounded where joints are redundant, and say nothing of a load then
  if (settings.geometric_stiffness && !is_oracle(settings.solver)) {
    state.features = with(state.features, Feature::geometric_stiffness);
    state.sizes.body_joints = static_cast<u32>(b.body_joints.size());
  } else {
    b.body_joints.clear();
  }

  list_planar_joints(b);
  state.sizes.planar_joints = static_cast<u32>(b.planar_joints.size());
  if (!b.planar_joints.empty()) state.features = with(state.features, Feature::planar_joints);

  state.features = with(state.features, Feature::joints);
  if (settings.integrator != Integrator::semi_implicit_euler)
    state.features = with(state.features, Feature::joints_ahead);
  state.features = with(state.features, Feature::general_contacts);  // the solve reads whole lines of bodies
  if (settings.solver == Solver::small_steps) state.features = with(state.features, Feature::soft_joints);
  const bool hard = std::ranges::any_of(b.joints, [](const Joint<real>& joint) { return joint.spring == 0; });
  if (hard && settings.solver != Solver::small_steps && settings.stabilization == Stabilization::positions)
    state.features = with(state.features, Feature::closed_joints);
  if (settings.integrator == Integrator::runge_kutta)
    throw Error(Failure::input, worlds[0].source + ": /settings/integrator",
                "runge_kutta is for bodies that nothing holds, and this scene has joints; use trapezoidal");
  state.sizes.joints = static_cast<u32>(b.joints.size());
  state.sizes.joint_blocks = static_cast<u32>(b.joint_lanes.size());
  state.sizes.joint_phases = static_cast<u32>(b.joint_phases.size()) - 1;
  state.sizes.joined = static_cast<u32>(b.joined_bodies.size());
  compile_couplings(worlds, state);
}

template void compile_joints(std::span<const Scene>, InitialState<float>&);
template <class real>
void expect_fits(const JointDescription& joint, const Scene& scene, const std::string& where) {
  Scene named;
  named.source = where;
  const Origin origin = {named};
  make_joint<real>(scene.settings, scene, joint, origin);
  screw_lead<real>(joint, origin);
  make_radius<real>(joint, origin);
}

template void expect_fits<float>(const JointDescription&, const Scene&, const std::string&);
template void expect_fits<double>(const JointDescription&, const Scene&, const std::string&);
template void compile_joints(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
