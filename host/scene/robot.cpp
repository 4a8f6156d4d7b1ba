#include "host/scene/robot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/solid_body.hpp"

namespace lockstep {

namespace {

using Pose = RobotPose;

class Assembly {
 public:
  Assembly(const Robot& robot, const RobotUse& use)
      : robot_(robot),
        use_(use),
        head_(robot.links.size()),
        in_head_(robot.links.size()),
        poses_(robot.links.size()),
        at_zero_(robot.links.size()),
        body_(robot.links.size(), NONE),
        engine_joints_(robot.joints.size()) {
    for (u32 i = 0; i < robot.joints.size(); ++i) starts_.push_back(start_of(i));
    set_link_poses();
    gather();
    make_bodies();
    make_joints();
    make_couplings();
  }

  RobotComponents take() { return std::move(components_); }

 private:
  u32 joint_called(const std::string& name) const {
    return static_cast<u32>(std::ranges::find(robot_.joints, name, &RobotJoint::name) - robot_.joints.begin());
  }

  // Where a joint stands at load: one that follows another is where that one says.
  double start_of(u32 joint) const {
    if (!kind_of(robot_.joints[joint].kind)) return 0;
    double factor = 1, start = 0;
    for (; robot_.joints[joint].mimic; joint = joint_called(robot_.joints[joint].mimic->leader)) {
      start += factor * robot_.joints[joint].mimic->offset;
      factor *= robot_.joints[joint].mimic->multiplier;
    }
    return start + factor * use_.drives[joint].start.value_or(robot_.joints[joint].start);
  }

  // A link that is fixed to its parent is part of the parent's body, whose frame is that of its first link, the head.
  void set_link_poses() {
    head_[robot_.root] = robot_.root;
    poses_[robot_.root] = at_zero_[robot_.root] = {use_.position, use_.orientation};
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const RobotJoint& joint = robot_.joints[i];
      const bool fixed = joint.kind == RobotJointKind::fixed;
      const Pose own = {joint.position, joint.orientation};
      head_[joint.child] = fixed ? head_[joint.parent] : joint.child;
      if (fixed) in_head_[joint.child] = in_head_[joint.parent] * own;
      at_zero_[joint.child] = at_zero_[joint.parent] * own;
      poses_[joint.child] = poses_[joint.parent] * own * started(joint, i);
    }
  }

  // As the scene says, else as the robot does.
  Pose started(const RobotJoint& joint, std::size_t number) const {
    if (joint.start_pose && !use_.drives[number].start) return *joint.start_pose;
    return moved(joint, starts_[number]);
  }

  // Masses and shapes of all links of a body, in the frame of its head.
  void gather() {
    solids_.resize(robot_.links.size());
    shapes_.resize(robot_.links.size());
    for (u32 i = 0; i < robot_.links.size(); ++i) {
      const RobotLink& link = robot_.links[i];
      const Pose& at = in_head_[i];
      if (link.inertial) solids_[head_[i]].push_back(transformed(*link.inertial, at.position, at.orientation));
      for (ShapeDescription shape : link.shapes) {
        const Pose pose = at * Pose{shape.offset, shape.rotation};
        shape.offset = pose.position;
        if (shape.kind != SHAPE_SPHERE) shape.rotation = pose.orientation;
        set_contacts(shape);
        shapes_[head_[i]].push_back(std::move(shape));
      }
    }
  }

  // As the scene says; else as the file does, whose classes have other bits here, the first that of "default".
  void set_contacts(ShapeDescription& shape) const {
    if (!robot_.contacts) {
      shape.material = use_.material.value_or(0);
      shape.category = use_.category.value_or(1);
      shape.mask = use_.mask.value_or(0xffffffffu);
      return;
    }
    u32 category = 0, passed = 0;
    for (u32 k = 0; k < use_.classes.size(); ++k) {
      if (shape.category >> k & 1) category |= use_.classes[k];
      if (!(shape.mask >> k & 1)) passed |= use_.classes[k];
    }
    shape.material = use_.material.value_or(use_.first_material + shape.material);
    shape.category = use_.category.value_or(category);
    shape.mask = use_.mask.value_or(~passed);
  }

  void make_bodies() {
    for (u32 i = 0; i < robot_.links.size(); ++i) {
      if (head_[i] != i) continue;
      const RobotLink& link = robot_.links[i];
      const bool is_still = i == robot_.root && (use_.fixed || robot_.root_is_fixed || link.name == "world");
      if (is_still && shapes_[i].empty()) continue;  // its joints are to the fixed frame
      BodyDescription body;
      body.name = use_.name + "/" + link.name;
      body.position = poses_[i].position;
      body.orientation = poses_[i].orientation;
      body.shapes = std::move(shapes_[i]);
      if (is_still) {
        body.kind = BODY_STATIC;
      } else if (link.is_kinematic) {
        body.kind = BODY_KINEMATIC;
      } else if (solids_[i].empty()) {
        throw Error(Failure::input, link.location,
                    i == robot_.root
                        ? "has no mass; give it an <inertial>, or fix a link with one to it; a root that does not move "
                          "is called \"world\", or is \"fixed\" in the scene"
                        : "has no mass; give it an <inertial>, or fix a link with one to it");
      } else {
        const MassProperties solid = together(solids_[i]);
        make_solid_of(body, solid.mass, solid.center, solid.inertia);
        body.gravity_share = share_of_weight(i);
      }
      body_[i] = static_cast<u32>(components_.bodies.size());
      components_.bodies.push_back(std::move(body));
    }
  }

  // Of all links of a body the same, for else the weight would turn it.
  double share_of_weight(u32 head) const {
    std::optional<double> share;
    for (u32 i = 0; i < robot_.links.size(); ++i) {
      const RobotLink& link = robot_.links[i];
      if (head_[i] != head || !link.inertial) continue;
      if (share && *share != link.gravity_share)
        throw Error(Failure::input, link.location,
                    "has another gravcomp than what it is fixed to, which is not simulated; give both the same");
      share = link.gravity_share;
    }
    return share.value_or(1);
  }

  void make_joints() {
    for (u32 i = 0; i < robot_.joints.size(); ++i) {
      const std::optional<JointKind> kind = kind_of(robot_.joints[i].kind);
      if (kind) add_joint(i, *kind, use_.drives[i]);
    }
    for (const RobotActuator& actuator : robot_.actuators) add_actuator(actuator);
    for (const ActuatorDescription& motor : components_.actuators)
      if (motor.force != 0 || motor.force_at_zero != 0)
        drive(components_.actuators, motor.joint, components_.joints[motor.joint]);
    for (const RobotLoop& loop : robot_.loops) add_loop(loop);
    for (const auto& [a, b] : robot_.passing) {
      const u32 body_a = body_[head_[a]], body_b = body_[head_[b]];
      if (body_a != NONE && body_b != NONE && body_a != body_b) components_.passing.push_back({body_a, body_b});
    }
  }

  void make_couplings() {
    for (const RobotCoupling& coupling : robot_.couplings) add_coupling(coupling.name, coupling.law);
    for (u32 i = 0; i < robot_.joints.size(); ++i) {
      if (engine_joints_[i].joint == NONE || !robot_.joints[i].mimic) continue;
      const auto& [leader, multiplier, offset] = *robot_.joints[i].mimic;
      CouplingDescription coupling;
      coupling.joints = {{i, 1}};
      if (multiplier != 0) coupling.joints.push_back({joint_called(leader), -multiplier});
      coupling.limited = true;
      coupling.low = coupling.high = offset;
      add_coupling(robot_.joints[i].name, coupling);
    }
  }

  // Of joints that do not move, as those of links without mass, the coordinate is 0.
  void add_coupling(const std::string& name, CouplingDescription coupling) {
    coupling.name = use_.name + "/" + name;
    std::erase_if(coupling.joints,
                  [&](const CoupledCoordinate& coupled) { return engine_joints_[coupled.joint].joint == NONE; });
    for (CoupledCoordinate& coupled : coupling.joints) coupled.joint = engine_joints_[coupled.joint].joint;
    if (!coupling.joints.empty()) components_.couplings.push_back(std::move(coupling));
  }

  // Its two sides are where they are one with all joints at 0, unless it says where: it is open where joints have
  // started so that it is.
  void add_loop(const RobotLoop& loop) {
    JointDescription joint;
    joint.name = use_.name + "/" + loop.name;
    joint.kind = loop.is_ball ? JOINT_BALL : JOINT_FIXED;
    joint.body_a = body_[head_[loop.a]];
    joint.body_b = body_[head_[loop.b]];
    joint.collide = true;
    if (joint.body_a == joint.body_b)
      throw Error(Failure::input, loop.location, "holds two links that are one body already; remove it");
    const Pose side = {loop.anchor, {0, 0, 0, 1}};
    add_sides(std::move(joint), loop,
              loop.sides.value_or(std::array{side, inverse(at_zero_[loop.b]) * at_zero_[loop.a] * side}));
  }

  // As if one of the bodies stood where the two sides are one: the second, unless that is the fixed frame.
  void add_sides(JointDescription joint, const RobotLoop& loop, const std::array<Pose, 2>& sides) {
    const Pose side_a = poses_[loop.a] * sides[0], side_b = poses_[loop.b] * sides[1];
    Pose a = pose_of(joint.body_a), b = pose_of(joint.body_b);
    const bool moves_b = joint.body_b != NONE;
    if (moves_b)
      b = side_a * inverse(side_b) * b;
    else
      a = side_b * inverse(side_a) * a;
    joint.anchor_a = joint.anchor_b = moves_b ? side_a.position : side_b.position;
    joint.reference_poses = {a.position, b.position, a.orientation, b.orientation};
    components_.joints.push_back(std::move(joint));
  }

  Pose pose_of(u32 body) const {
    if (body == NONE) return {};
    return {components_.bodies[body].position, components_.bodies[body].orientation};
  }

  // The engine's joint has a motor or friction, and without armature limits or a spring; what is more gets a joint of
  // its own.
  void add_joint(u32 number, JointKind kind, const RobotDrive& drive) {
    const RobotJoint& in = robot_.joints[number];
    JointDescription joint;
    joint.name = use_.name + "/" + in.name;
    joint.kind = kind;
    joint.body_a = body_[head_[in.parent]];
    joint.body_b = body_[in.child];
    const Pose zero = poses_[in.parent] * Pose{in.position, in.orientation};
    joint.anchor_a = joint.anchor_b = exact::add(zero.position, exact::rotate(zero.orientation, in.anchor));
    joint.axis = exact::rotate(zero.orientation, in.axis);
    if (kind == JOINT_UNIVERSAL) joint.second_axis = exact::rotate(zero.orientation, in.second_axis);
    joint.collide = in.collide;
    const double start = starts_[number];
    if (start != 0 || in.start_pose) joint.reference_poses = reference_poses_at(zero, joint, in.child);
    if (free_of(kind) == FREE_ANGLE) joint.start = start;
    JointDescription more = joint, lock = joint;
    joint.limited = in.kind == RobotJointKind::revolute || in.kind == RobotJointKind::prismatic;
    joint.low = in.low;
    joint.high = in.high;
    const std::optional<JointSpring> spring = spring_of(in, drive);
    joint.armature = in.armature;
    const bool spring_is_more = joint.limited && !(in.armature > 0);
    (spring_is_more ? more : joint).spring = spring;
    joint.motor_speed = drive.motor_speed;
    joint.motor_force = drive.motor_force;
    (drive.motor_force > 0 || has_motor(number) ? more : joint).friction = in.friction;
    const bool needs_more = more.spring || more.friction > 0;
    EngineJoints& made = engine_joints_[number];
    made.joint = static_cast<u32>(components_.joints.size());
    made.spring = made.joint + (spring_is_more ? 1 : 0);
    components_.joints.push_back(std::move(joint));
    if (needs_more) components_.joints.push_back(more);
    more.friction = 0;
    for (const JointSpring& servo : in.servos) {
      const bool is_alone = !drive.spring && servo.forces != any_force;
      made.servos.push_back(is_alone ? static_cast<u32>(components_.joints.size()) : made.spring);
      if (!is_alone) continue;
      more.spring = servo;
      components_.joints.push_back(more);
    }
    if (!in.locked_at) return;
    lock.limited = true;
    lock.low = lock.high = *in.locked_at;
    components_.joints.push_back(std::move(lock));
  }

  bool has_motor(u32 joint) const {
    return std::ranges::any_of(robot_.actuators, [&](const RobotActuator& actuator) {
      return actuator.drive.joint == joint && (actuator.drive.force != 0 || actuator.drive.force_at_zero != 0);
    });
  }

  const JointSpring& servo_of(const RobotActuator& actuator) const {
    return robot_.joints[actuator.drive.joint].servos[*actuator.servo];
  }

  // Of the stiffness of the spring that it is part of.
  double share_of(const RobotActuator& actuator) const {
    const u32 joint = engine_joints_[actuator.drive.joint].servos[*actuator.servo];
    return servo_of(actuator).stiffness / components_.joints[joint].spring->stiffness;
  }

  // A spring of several, servos and others, rests where the stiffness of each weighs.
  void add_actuator(const RobotActuator& in) {
    ActuatorDescription out = in.drive;
    out.name = use_.name + "/" + out.name;
    if (in.drive.joint != NONE) {
      const RobotDrive& scene = use_.drives[in.drive.joint];
      const EngineJoints& made = engine_joints_[in.drive.joint];
      out.joint = in.servo ? made.servos[*in.servo] : made.joint;
      if (in.servo ? scene.spring.has_value() : scene.motor_force > 0)
        out.refusal = std::string("has a joint to which the scene gives a ") + (in.servo ? "spring" : "motor");
      if (in.servo && out.refusal.empty()) {
        out.rest *= share_of(in);
        out.rest_at_zero = components_.joints[out.joint].spring->rest;
        for (const RobotActuator& other : robot_.actuators)
          if (other.servo && other.drive.joint == in.drive.joint && made.servos[*other.servo] == out.joint)
            out.rest_at_zero -= share_of(other) * (servo_of(other).rest - other.drive.rest_at_zero);
      }
    }
    components_.actuators.push_back(std::move(out));
  }

  // Springs side by side are one, and so are dampers; not those whose force is bounded.
  static std::optional<JointSpring> spring_of(const RobotJoint& in, const RobotDrive& drive) {
    std::optional<JointSpring> sum;
    const auto add = [&](const JointSpring& spring) {
      if (!sum) {
        sum = spring;
        return;
      }
      const double stiffness = sum->stiffness + spring.stiffness;
      if (spring.stiffness > 0) sum->rest = (sum->stiffness * sum->rest + spring.stiffness * spring.rest) / stiffness;
      sum->stiffness = stiffness;
      sum->damping += spring.damping;
    };
    if (drive.spring) add(*drive.spring);
    for (const JointSpring& servo : in.servos)
      if (!drive.spring && servo.forces == any_force) add(servo);
    if (in.spring) add(*in.spring);
    if (in.damping > 0) add({0, in.damping, 0});
    return sum;
  }

  // Where the two bodies of a joint would stand with the joint at 0, its parent where it is.
  ReferencePoses reference_poses_at(const Pose& zero, const JointDescription& joint, u32 child) const {
    ReferencePoses reference_poses;
    if (joint.body_a != NONE) {
      reference_poses.position_a = components_.bodies[joint.body_a].position;
      reference_poses.orientation_a = components_.bodies[joint.body_a].orientation;
    }
    const BodyDescription& body = components_.bodies[joint.body_b];
    const Pose b = zero * (inverse(poses_[child]) * Pose{body.position, body.orientation});
    reference_poses.position_b = b.position;
    reference_poses.orientation_b = b.orientation;
    return reference_poses;
  }

  // What became of a joint: the joint, the one that has its spring, and those that have its servos.
  struct EngineJoints {
    u32 joint = NONE, spring = NONE;
    std::vector<u32> servos;
  };

  const Robot& robot_;
  const RobotUse& use_;
  // of each link
  std::vector<u32> head_;
  std::vector<Pose> in_head_, poses_, at_zero_;  // in the frame of the head; in the world; there with all joints at 0
  std::vector<u32> body_;                        // of heads
  // of each joint
  std::vector<EngineJoints> engine_joints_;
  std::vector<double> starts_;
  std::vector<std::vector<MassProperties>> solids_;
  std::vector<std::vector<ShapeDescription>> shapes_;
  RobotComponents components_;
};

}  // namespace

RobotPose moved(const RobotJoint& joint, double by) {
  if (by == 0) return {};
  if (joint.kind == RobotJointKind::prismatic || joint.kind == RobotJointKind::sliding)
    return {exact::scale(by, exact::unit(joint.axis)), {0, 0, 0, 1}};
  const Quaternion rotation = exact::rotation(joint.axis, exact::sine(0.5 * by), exact::cosine(0.5 * by));
  return {exact::subtract(joint.anchor, exact::rotate(rotation, joint.anchor)), rotation};
}

RobotComponents make_robot(const Robot& robot, const RobotUse& use) { return Assembly(robot, use).take(); }

std::optional<JointKind> kind_of(RobotJointKind kind) {
  switch (kind) {
    case RobotJointKind::revolute:
    case RobotJointKind::continuous: return JOINT_HINGE;
    case RobotJointKind::prismatic:
    case RobotJointKind::sliding: return JOINT_SLIDER;
    case RobotJointKind::ball: return JOINT_BALL;
    case RobotJointKind::universal: return JOINT_UNIVERSAL;
    case RobotJointKind::planar: return JOINT_PLANAR;
    default: return std::nullopt;
  }
}

}  // namespace lockstep
