// A fly-ball governor in coordinates that need no joints.
#pragma once

namespace lockstep {

/// Two balls on arms hinged to a spindle that a torque drives; links from the arms lift a collar on the spindle against
/// a spring and a damper. Arms and links weigh nothing. At first all turns with the spindle and moves
/// in no other way, and the spring is unloaded.
struct FlyBallParameters {
  double ball_mass, ball_inertia;  // kg; kg m^2 about any axis through its centre
  double collar_mass;              // kg
  double spindle_inertia;          // kg m^2 about the axis, the collar's counted in
  double arm, link;                // m: hinge to ball; hinge to link, and link
  double offset;                   // m: of the hinges from the axis
  double angle;                    // rad: of the arms from straight down, at the start
  double angular_velocity;         // rad/s, at the start
  double torque;                   // N m, on the spindle
  double stiffness, damping;       // N/m, N s/m
  double gravity;                  // m/s^2, down
};

/// Its motion by Runge-Kutta's method of fourth order. With q the angle of the arms, s = offset + arm sin q and
/// x = 2 link (cos q_0 - cos q) the travel of the collar:
///   w = p / J,  p' = torque,  J = spindle_inertia + 2 (ball_mass s^2 + ball_inertia)
///   A q'' + A_q q'^2 / 2 = J_q w^2 / 2 - (2 ball_mass arm + 2 collar_mass link) g sin q - x_q (k x + c x'),
///   A = 2 (ball_mass arm^2 + ball_inertia) + collar_mass x_q^2
class FlyBall {
 public:
  explicit FlyBall(const FlyBallParameters& parameters);

  /// To a time that is no earlier than that of the last call, s, in steps of at most `step`.
  void run_to(double time, double step);

  double travel() const;            // of the collar, m, up
  double angular_velocity() const;  // of the spindle, rad/s

 private:
  double acceleration(double time, double angle, double rate) const;
  double inertia(double angle) const;

  FlyBallParameters p_;
  double time_ = 0, angle_, rate_ = 0;
};

}  // namespace lockstep
