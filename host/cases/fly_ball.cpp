#include "host/cases/fly_ball.hpp"

#include <cmath>

namespace lockstep {

FlyBall::FlyBall(const FlyBallParameters& parameters) : p_(parameters), angle_(parameters.angle) {}

double FlyBall::inertia(double angle) const {
  const double s = p_.offset + p_.arm * std::sin(angle);
  return p_.spindle_inertia + 2 * (p_.ball_mass * s * s + p_.ball_inertia);
}

double FlyBall::acceleration(double time, double angle, double rate) const {
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const double w = (inertia(p_.angle) * p_.angular_velocity + p_.torque * time) / inertia(angle);
  const double inertia_q = 4 * p_.ball_mass * (p_.offset + p_.arm * sine) * p_.arm * cosine;
  const double x = 2 * p_.link * (std::cos(p_.angle) - cosine), x_q = 2 * p_.link * sine, x_qq = 2 * p_.link * cosine;
  const double a = 2 * (p_.ball_mass * p_.arm * p_.arm + p_.ball_inertia) + p_.collar_mass * x_q * x_q;
  const double a_q = 2 * p_.collar_mass * x_q * x_qq;
  const double weight = 2 * (p_.ball_mass * p_.arm + p_.collar_mass * p_.link) * p_.gravity * sine;
  const double spring = p_.stiffness * x + p_.damping * x_q * rate;
  return (inertia_q * w * w / 2 - a_q * rate * rate / 2 - weight - x_q * spring) / a;
}

void FlyBall::run_to(double time, double step) {
  if (!(time > time_)) return;
  const auto steps = static_cast<int>(std::ceil((time - time_) / step));
  const double start = time_, h = (time - time_) / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = start + i * h, q = angle_, r = rate_;
    const double r1 = r, a1 = acceleration(t, q, r1);
    const double r2 = r + h / 2 * a1, a2 = acceleration(t + h / 2, q + h / 2 * r1, r2);
    const double r3 = r + h / 2 * a2, a3 = acceleration(t + h / 2, q + h / 2 * r2, r3);
    const double r4 = r + h * a3, a4 = acceleration(t + h, q + h * r3, r4);
    angle_ = q + h / 6 * (r1 + 2 * r2 + 2 * r3 + r4);
    rate_ = r + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  time_ = time;
}

double FlyBall::travel() const { return 2 * p_.link * (std::cos(p_.angle) - std::cos(angle_)); }

double FlyBall::angular_velocity() const {
  return (inertia(p_.angle) * p_.angular_velocity + p_.torque * time_) / inertia(angle_);
}

}  // namespace lockstep
