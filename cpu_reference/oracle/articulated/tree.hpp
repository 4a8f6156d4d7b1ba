// The bodies that joints hold, as trees: of the graph of joints a spanning tree from the world out, breadth first; a
// group of bodies that hangs from nothing has a root that is free. A joint that is in no tree closes a loop.
#pragma once

#include <vector>

#include "cpu_reference/oracle/articulated/joint.hpp"

namespace lockstep::oracle::articulated {

struct Body {
  double mass = 0;                      // kg; 0: immovable, or moved by somebody else
  Vector3d inertia = Vector3d::Zero();  // principal moments about the centre of mass, body frame, kg m^2
  bool is_link = false;                 // moves, and a joint connects it
};

struct System {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
};

inline constexpr std::size_t no_link = ~std::size_t{0};

struct Link {
  std::size_t body = 0;
  std::size_t parent = no_link;  // link; none where the parent does not move, or there is none
  std::size_t joint = no_link;   // of System::joints, to the parent; none of a free root
  std::size_t parent_body = world;
  bool child_is_b = true;         // of the joint
  Index first = 0, freedoms = 0;  // of its rates in a vector of all
  std::size_t tree = 0;
};

class Tree {
 public:
  /// The system is kept by reference.
  explicit Tree(const System& system);

  const System& system() const { return system_; }
  /// Parents stand before their children, and the links of a tree in a row.
  const std::vector<Link>& links() const { return links_; }
  const Link& link(std::size_t i) const { return links_[i]; }
  std::size_t size() const { return links_.size(); }
  /// no_link of bodies that are none.
  std::size_t link_of(std::size_t body) const { return body == world ? no_link : link_of_[body]; }
  /// Links of tree t: starts()[t] .. starts()[t + 1] - 1.
  const std::vector<std::size_t>& starts() const { return starts_; }
  /// Joints, of whatever kind, that are in no tree.
  const std::vector<std::size_t>& closures() const { return closures_; }
  Index freedoms() const { return freedoms_; }

  const Joint& joint_of(const Link& link) const { return system_.joints[link.joint]; }

 private:
  const System& system_;
  std::vector<Link> links_;
  std::vector<std::size_t> link_of_, starts_, closures_;
  Index freedoms_ = 0;
};

/// Poses of all bodies, and the coordinates of each link's joint.
struct Configuration {
  std::vector<Pose> poses;
  std::vector<Coordinates> coordinates;
};

/// The configuration that is nearest to poses link by link: free roots and what does not move stay, all else follows
/// from them and the measured coordinates, so that every joint of a tree is closed.
Configuration measured(const Tree& tree, std::vector<Pose> poses);

/// Forward kinematics: the poses of links from those of what does not move, of free roots, and the coordinates.
void close_trees(const Tree& tree, Configuration& configuration);

/// The configuration after `dt` at these rates (free roots: v and w of the centre of mass); bodies that are no links go
/// on with their `twists`.
Configuration moved(const Tree& tree, const Configuration& from, const VectorXd& rates,
                    const std::vector<Vector6>& twists, double dt);

Pose pose_of(const Configuration& configuration, std::size_t body);
JointGeometry joint_geometry(const Joint& joint, const Configuration& at);

}  // namespace lockstep::oracle::articulated
