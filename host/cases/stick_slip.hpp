// A block on rough ground under a force that goes to and fro, in closed form.
#pragma once

#include <vector>

namespace lockstep {

/// The motion of x'' = P cos t - R sign(x') from rest at 0, where Coulomb's law holds the block at rest while the push
/// is no larger than R. P and R in N/kg, times in s with the push at 1 rad/s, 0 < R < P.
///
/// A slide that starts at t0 with the sign s has x' = P (sin t - sin t0) - s R (t - t0), up to the first zero of that;
/// then the block sticks until the push has grown to R again.
class StickSlip {
 public:
  StickSlip(double push, double friction, double duration);

  // at a time up to `duration`
  double position(double time) const;  // m
  double speed(double time) const;     // m/s

 private:
  struct Slide {
    double from, to;  // s
    double sign;      // of the speed
    double start;     // m, where it begins
  };
  const Slide& last_begun(double time) const;
  double speed_in(const Slide& slide, double time) const;
  double position_in(const Slide& slide, double time) const;

  double push_, friction_;
  std::vector<Slide> slides_;  // the first starts at 0
};

}  // namespace lockstep
