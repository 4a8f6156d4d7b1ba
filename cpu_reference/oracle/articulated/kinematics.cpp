#include "cpu_reference/oracle/articulated/kinematics.hpp"

namespace lockstep::oracle::articulated {

Kinematics::Kinematics(const Tree& tree, const Configuration& at, const std::vector<Vector6>& twists,
                       const VectorXd& rates)
    : tree_(tree), at_(at), twists_(twists), links_(tree.size()) {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    const Pose& pose = at.poses[link.body];
    LinkKinematics& k = links_[i];
    const Matrix3d rotation = pose.q.toRotationMatrix();
    k.inertia = rotation * tree.system().bodies[link.body].inertia.asDiagonal() * rotation.transpose();
    const auto own = rates.segment(link.first, link.freedoms);
    if (link.joint == no_link) {
      k.motion = Columns::Identity(6, 6);
      k.twist = own;
      continue;
    }
    const Joint& joint = tree.joint_of(link);
    const Pose a = pose_of(at, joint.body_a), b = pose_of(at, joint.body_b), parent = pose_of(at, link.parent_body);
    const JointGeometry s = joint_geometry(joint, a, b);
    const Columns axes = motion_axes(joint, s);
    k.from_parent = pose.x - parent.x;
    k.motion = (link.child_is_b ? 1.0 : -1.0) * (shift(pose.x - s.point) * axes);
    k.twist = twist_at(twist_of(link.parent_body), k.from_parent) + k.motion * own;
    const Vector6 twist_a = twist_of(joint.body_a), twist_b = twist_of(joint.body_b);
    k.product = velocity_product(joint, s, a, twist_a, b, twist_b, own, link.child_is_b);
  }
}

Vector6 Kinematics::twist_of(std::size_t body) const {
  if (body == world) return Vector6::Zero();
  const std::size_t link = tree_.link_of(body);
  return link == no_link ? twists_[body] : links_[link].twist;
}

Vector6 Kinematics::carried(std::size_t link) const {
  const Link& l = tree_.link(link);
  if (l.parent != no_link || l.joint == no_link) return Vector6::Zero();
  return twist_at(twist_of(l.parent_body), links_[link].from_parent);
}

Vector6 Kinematics::momentum(std::size_t link, const Vector6& twist) const {
  return spatial(tree_.system().bodies[tree_.link(link).body].mass * twist.head<3>(),
                 links_[link].inertia * twist.tail<3>());
}

Vector6 Kinematics::gyroscopic(std::size_t link) const {
  const Vector3d w = links_[link].twist.tail<3>();
  return spatial(Vector3d::Zero(), w.cross(links_[link].inertia * w));
}

}  // namespace lockstep::oracle::articulated
