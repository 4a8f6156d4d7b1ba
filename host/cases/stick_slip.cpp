#include "host/cases/stick_slip.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lockstep {

namespace {
using std::numbers::pi;
}

StickSlip::StickSlip(double push, double friction, double duration) : push_(push), friction_(friction) {
  const double quiet = std::acos(friction / push);  // s, from where the push is largest to where it no longer slides
  double time = 0, position = 0;
  while (time <= duration) {
    Slide slide = {time, time, std::cos(time) > 0 ? 1.0 : -1.0, position};
    // its speed grows up to `fastest` and falls from then on, for longer than half a period
    const double fastest = std::round(time / pi) * pi + quiet;
    double moves = fastest, stuck = fastest + pi;
    for (int i = 0; i < 100; ++i) {
      const double middle = (moves + stuck) / 2;
      (slide.sign * speed_in(slide, middle) > 0 ? moves : stuck) = middle;
    }
    slide.to = moves;
    position = position_in(slide, slide.to);
    slides_.push_back(slide);
    // where the push is larger than friction already it goes back at once
    time = std::abs(push * std::cos(slide.to)) > friction ? slide.to : std::ceil(slide.to / pi) * pi - quiet;
  }
}

double StickSlip::position(double time) const {
  const Slide& slide = last_begun(time);
  return position_in(slide, std::min(time, slide.to));
}

double StickSlip::speed(double time) const {
  const Slide& slide = last_begun(time);
  return time < slide.to ? speed_in(slide, time) : 0;
}

const StickSlip::Slide& StickSlip::last_begun(double time) const {
  return *std::prev(std::ranges::upper_bound(slides_, time, {}, &Slide::from));
}

double StickSlip::speed_in(const Slide& slide, double time) const {
  return push_ * (std::sin(time) - std::sin(slide.from)) - slide.sign * friction_ * (time - slide.from);
}

double StickSlip::position_in(const Slide& slide, double time) const {
  const double t = time - slide.from;
  return slide.start + push_ * (std::cos(slide.from) - std::cos(time) - t * std::sin(slide.from)) -
         slide.sign * friction_ * t * t / 2;
}

}  // namespace lockstep
