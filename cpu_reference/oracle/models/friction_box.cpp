#include "cpu_reference/oracle/models/friction_box.hpp"

#include <limits>

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle::models {

FrictionBox::FrictionBox(const Multibody& system) : system_(system), rows_(system) {
  const Index contacts = rows_.normal.rows();
  all_.resize(3 * contacts + rows_.dry.rows() + rows_.joint.rows(), rows_.normal.cols());
  for (Index i = 0; i < contacts; ++i) {
    all_.row(3 * i) = rows_.normal.row(i);
    all_.middleRows(3 * i + 1, 2) = rows_.tangent.middleRows(2 * i, 2);
  }
  all_.middleRows(3 * contacts, rows_.dry.rows()) = rows_.dry;
  all_.bottomRows(rows_.joint.rows()) = rows_.joint;
}

lcp::BoxedLcp FrictionBox::boxed() const {
  const double infinity = std::numeric_limits<double>::infinity();
  const Index contacts = rows_.normal.rows(), dry = 3 * contacts, joint = dry + rows_.dry.rows(), n = all_.rows();
  lcp::BoxedLcp p;
  p.m = product(all_, rows_.inertia_times(all_));
  p.m = (0.5 * (p.m + p.m.transpose())).eval();
  p.q = all_ * rows_.free_velocity;
  p.low = VectorXd::Zero(n);
  p.high = VectorXd::Constant(n, infinity);
  p.normal.assign(std::size_t(n), -1);
  p.friction = VectorXd::Zero(n);
  for (Index i = 0; i < contacts; ++i) {
    const Contact& c = system_.contacts[std::size_t(i)];
    p.q[3 * i] += c.bias;
    p.q.segment<2>(3 * i + 1) += tangents(c.normal).transpose() * c.slide;
    for (const Index t : {3 * i + 1, 3 * i + 2}) {
      p.normal[std::size_t(t)] = 3 * i;
      p.friction[t] = system_.contacts[std::size_t(i)].friction;
    }
  }
  for (Index k = dry; k < joint; ++k) {
    p.high[k] = system_.dry_rows[std::size_t(k - dry)].limit;
    p.low[k] = -p.high[k];
  }
  for (Index k = joint; k < n; ++k) {
    p.q[k] += system_.joint_rows[std::size_t(k - joint)].bias;
    p.low[k] = -infinity;
  }
  return p;
}

Vector3d FrictionBox::impulse(std::size_t contact, const VectorXd& z) const {
  const Vector3d& normal = system_.contacts[contact].normal;
  const Index i = 3 * Index(contact);
  return z[i] * normal + tangents(normal) * z.segment<2>(i + 1);
}

VectorXd FrictionBox::velocities(const VectorXd& z) const {
  return rows_.free_velocity + rows_.inertia_times(all_) * z;
}

}  // namespace lockstep::oracle::models
