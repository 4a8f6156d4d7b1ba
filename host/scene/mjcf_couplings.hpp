// What in an MJCF file ties joints to each other: fixed tendons, and equality constraints of joints and of tendons.
#pragma once

#include <map>

#include "host/scene/mjcf_links.hpp"

namespace lockstep {

/// Adds to the couplings of a robot. A tendon is read before what names it.
class MjcfCouplings {
 public:
  MjcfCouplings(const MjcfNames& names, const std::string& prefix, LeftOut& left_out, Robot& robot)
      : names_(names), prefix_(prefix), left_out_(left_out), robot_(robot) {}

  /// <fixed>: the joints by their coef are a length, which has limits, a spring and a damper. <spatial> is refused
  /// where it pulls.
  void read_tendon(const MjcfElement& tendon);
  /// <equality><joint> with two joints.
  void read_joints(const XmlNode& node);
  /// <equality><tendon>.
  void read_tendons(const XmlNode& node);

 private:
  using Sum = std::vector<CoupledCoordinate>;
  struct Polynomial {
    double constant, slope;
  };

  u32 coordinate_of(const XmlNode& node, const char* attribute) const;
  Sum joints_of(const XmlNode& fixed, double& at_reference) const;
  const Sum& tendon_of(const XmlNode& node, const char* attribute) const;
  Polynomial polynomial_of(const XmlNode& node);
  std::optional<JointSpring> spring_of(const MjcfElement& tendon, double at_reference);
  double first_of(const MjcfElement& tendon, const char* attribute);
  static void add_to(Sum& sum, const CoupledCoordinate& more);
  void add_equality(const XmlNode& node, const Sum& follower, const Polynomial& law, const Sum& leader);

  const MjcfNames& names_;
  const std::string& prefix_;
  LeftOut& left_out_;
  Robot& robot_;
  std::map<std::string, Sum> tendons_;  // fixed ones with a name
};

}  // namespace lockstep
