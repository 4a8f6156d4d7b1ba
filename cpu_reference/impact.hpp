// What an impact makes of one contact: the impulse that it ends with, from the velocity u before it, the contact's own
// Delassus block W, friction mu and restitution e. kernels/impact.h is the twin.
//
// Poisson's and Stronge's laws follow the impact by its growing normal impulse p (Routh 1860; Keller 1986), as if it
// took no time:
//   du/dp = W (1, t),  t = -mu u_t / |u_t| while it slides;  stuck, t = -W_tt^-1 W_tn as long as |t| <= mu;  from rest,
//   where that is too much, it starts to slide in the one direction that stays: (mu W_tt + l) d = W_tn, |d| = 1, l > 0.
// It is compressed while u_n < 0, and restored until
//   Poisson:  the normal impulse of restoring is e times that of compression;
//   Stronge:  the work of the normal impulse gives back e^2 of what compression took (Stronge 1990).
// A slide of constant direction is a straight piece, and all of a planar impact are (Routh's cases), with ends in
// closed form: where u_n = 0, where the slide stops, where restitution is done. In space the direction turns: a piece
// is at most as long as `slide_deflection` lets it turn, and goes along the direction of its middle. On every piece
// friction works against both ends' slip, and the work of the normal impulse is exact: Stronge's law never creates
// energy.
//
// Chatterjee and Ruina's law (1998) is algebraic: with P_1 = (-u_n / W_nn, 0) and P_2 = -W^-1 u, which stop the
// approach and the whole contact, r = (1 + e) P_1 + (1 + e_t) (P_2 - P_1); where that is outside of the cone, k (P_2 -
// P_1) on the cone. P_1 and P_2 - P_1 are orthogonal in W, so that it gains no energy for -1 <= e_t <= 1, 0 <= e <= 1.
#pragma once

#include "cpu_reference/cone.hpp"

namespace lockstep::reference {

/// Pieces of an impact, at most; after that it ends as if it were smooth. Of 30,000 at random three take more.
constexpr int impact_pieces = 64;
/// By which angle the direction of a slide may turn in a piece, rad.
template <class real>
constexpr real slide_deflection = real(0.125);
/// A slide slower than this part of all velocities has stopped: what rounding leaves.
template <class real>
constexpr real slide_rounding = sizeof(real) == 8 ? real(1e-14) : real(4e-6);
/// Newton steps for the direction in which a slide starts.
template <class real>
constexpr int start_steps = sizeof(real) == 8 ? 8 : 6;

template <class real>
struct ImpactMaterial {
  u32 law;  // ImpactLaw
  real friction, restitution, tangential_restitution;
};

/// What a contact ends with: its impulse, its velocity, and whether it ends in a slide.
template <class real>
struct ImpactOutcome {
  ConeVector<real> impulse, velocity;
  bool slides;
};

/// A piece of an impact, per unit of normal impulse: the tangential impulse, and how the velocity changes.
template <class real>
struct ImpactPiece {
  real t1, t2;
  ConeVector<real> rate;
};

template <class real>
ConeVector<real> times(const Delassus<real>& w, ConeVector<real> r) {
  return {w.nn * r.normal + w.n1 * r.tangent_1 + w.n2 * r.tangent_2,
          w.n1 * r.normal + w.t11 * r.tangent_1 + w.t12 * r.tangent_2,
          w.n2 * r.normal + w.t12 * r.tangent_1 + w.t22 * r.tangent_2};
}

template <class real>
ImpactPiece<real> impact_piece(const Delassus<real>& w, real t1, real t2) {
  return {t1, t2, times(w, {1, t1, t2})};
}

/// The piece from rest: stuck, or the start of a slide. Newton on 1 / |d| from l = 0, which is almost linear in l (More
/// and Sorensen 1983).
template <class real>
ImpactPiece<real> piece_from_rest(const Delassus<real>& w, real friction) {
  const real inverse = real(1) / (w.t11 * w.t22 - w.t12 * w.t12);
  const real s1 = (w.t12 * w.n2 - w.t22 * w.n1) * inverse, s2 = (w.t12 * w.n1 - w.t11 * w.n2) * inverse;
  if (s1 * s1 + s2 * s2 <= friction * friction) return impact_piece(w, s1, s2);
  const real z = friction * w.t12;
  real d1 = 0, d2 = 0, length = 1, l = 0;
  for (int step = 0; step < start_steps<real>; ++step) {
    const real x = friction * w.t11 + l, y = friction * w.t22 + l, scale = real(1) / (x * y - z * z);
    d1 = (y * w.n1 - z * w.n2) * scale;
    d2 = (x * w.n2 - z * w.n1) * scale;
    const real squared = d1 * d1 + d2 * d2;
    length = std::sqrt(squared);
    const real bend = (d1 * (y * d1 - z * d2) + d2 * (x * d2 - z * d1)) * scale;
    l = l + (length - real(1)) * squared / bend;
  }
  return impact_piece(w, -friction * (d1 / length), -friction * (d2 / length));
}

/// After which normal impulse the phase ends that a contact with normal velocity u_n is in, and whether it is that of
/// compression. `owed` is what restitution has yet to give: impulse, or work.
template <class real>
struct PhaseEnd {
  real impulse;
  bool compresses, pays;  // pays: the end of the impact, otherwise u_n = 0
};

template <class real>
PhaseEnd<real> impact_phase(bool by_work, real u_n, real rate, real owed, real far) {
  const bool compresses = u_n < 0 || (!(u_n > 0) && rate < 0);
  const real to_zero = compresses == (rate > 0) ? std::fabs(u_n / rate) : far;
  const real squared = u_n * u_n + real(2) * rate * owed;
  const real by_work_impulse = squared >= 0 ? real(2) * owed / (u_n + std::sqrt(squared)) : far;
  const real wanted = owed > 0 ? (by_work ? by_work_impulse : owed) : real(0);
  const bool pays = !compresses && wanted <= to_zero;
  return {pays ? wanted : to_zero, compresses, pays};
}

/// A piece of a slide, how far it reaches, and whether the slide stops there.
template <class real>
struct SlidePiece {
  ImpactPiece<real> piece;
  real span;
  bool stops;
};

/// The straight way to a stop, along d: W_tt^-1 (u_t + W_tn p) = mu p d with |d| = 1. Where that is nearly the way that
/// the slide goes, it stops so. Otherwise the piece goes along the direction of its middle, found by a linearly
/// implicit half step: W_tt draws the direction of a slow slide stiffly, and an explicit one would swing.
template <class real>
SlidePiece<real> slide_piece(ConeVector<real> u, real speed, const Delassus<real>& w, real friction, bool by_work,
                             real owed, real far) {
  const real e1 = u.tangent_1 / speed, e2 = u.tangent_2 / speed;
  const real inverse = real(1) / (w.t11 * w.t22 - w.t12 * w.t12);
  const real a1 = (w.t22 * u.tangent_1 - w.t12 * u.tangent_2) * inverse;
  const real a2 = (w.t11 * u.tangent_2 - w.t12 * u.tangent_1) * inverse;
  const real s1 = (w.t22 * w.n1 - w.t12 * w.n2) * inverse, s2 = (w.t11 * w.n2 - w.t12 * w.n1) * inverse;
  const real length = a1 * a1 + a2 * a2, along = a1 * s1 + a2 * s2;
  const real squared = along * along - length * (s1 * s1 + s2 * s2 - friction * friction);
  const real over = squared >= 0 ? std::sqrt(squared) - along : real(0), stop = over > 0 ? length / over : far;
  const real d1 = (a1 / stop + s1) / friction, d2 = (a2 / stop + s2) / friction;
  const real deflection = std::fabs(d1 * e2 - d2 * e1);
  const ImpactPiece<real> straight = impact_piece(w, -friction * d1, -friction * d2);
  if (stop < far && stop <= impact_phase(by_work, u.normal, straight.rate.normal, owed, far).impulse &&
      deflection <= slide_deflection<real> && d1 * e1 + d2 * e2 > 0)
    return {straight, stop, true};

  const ImpactPiece<real> first = impact_piece(w, -friction * e1, -friction * e2);
  const real gains = first.rate.tangent_1 * e1 + first.rate.tangent_2 * e2;
  const real deflects = first.rate.tangent_2 * e1 - first.rate.tangent_1 * e2;
  const real stiff = friction * (w.t11 * e2 * e2 - real(2) * w.t12 * e1 * e2 + w.t22 * e1 * e1);
  const real ratio = slide_deflection<real> * stiff / std::fabs(deflects);
  const real until = speed / (stiff / ratio + (gains < 0 ? -gains : real(0)));
  const real phase = impact_phase(by_work, u.normal, first.rate.normal, owed, far).impulse;
  const real span = until < far ? until : far;
  const real half = real(0.5) * (phase < span ? phase : span);
  const real ahead = speed + half * gains, aside = half * deflects / (real(1) + half * stiff / speed);
  const real x = ahead * e1 - aside * e2, y = ahead * e2 + aside * e1;
  const real middle = std::sqrt(x * x + y * y), m1 = x / middle, m2 = y / middle;
  const ImpactPiece<real> piece = impact_piece(w, -friction * m1, -friction * m2);
  const real loses = -(piece.rate.tangent_1 * m1 + piece.rate.tangent_2 * m2);
  const real halt = loses > 0 ? (u.tangent_1 * m1 + u.tangent_2 * m2) / loses : far;
  return {piece, halt < span ? halt : span, false};
}

/// Poisson's and Stronge's laws. `u` approaches: u_n < 0.
template <class real>
ImpactOutcome<real> follow_impact(ConeVector<real> u, const Delassus<real>& w, const ImpactMaterial<real>& m) {
  const bool by_work = m.law == IMPACT_STRONGE;
  const real share = by_work ? m.restitution * m.restitution : m.restitution;
  const real start = std::sqrt(u.normal * u.normal + u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2);
  const real least = slide_rounding<real> * start, far = real(1e6) * start / w.nn;
  const ImpactPiece<real> from_rest = piece_from_rest(w, m.friction), smooth = impact_piece(w, real(0), real(0));
  ConeVector<real> r = {0, 0, 0};
  real owed = 0;
  for (int k = 0; k < impact_pieces + 2; ++k) {
    const real speed = std::sqrt(u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2);
    const bool slides = speed > least, is_smooth = !(m.friction > 0) || k >= impact_pieces;
    ImpactPiece<real> piece = is_smooth ? smooth : from_rest;
    real span = far;
    bool stops = false;
    if (!is_smooth && slides) {
      const SlidePiece<real> slide = slide_piece(u, speed, w, m.friction, by_work, owed, far);
      piece = slide.piece;
      span = slide.span;
      stops = slide.stops;
    }
    const PhaseEnd<real> end = impact_phase(by_work, u.normal, piece.rate.normal, owed, far);
    const bool ends = end.impulse <= span;
    const real p = ends ? end.impulse : span;
    const real measure = by_work ? p * (u.normal + real(0.5) * p * piece.rate.normal) : p;
    owed = end.compresses ? owed + share * std::fabs(measure) : owed - measure;
    r = {r.normal + p, r.tangent_1 + p * piece.t1, r.tangent_2 + p * piece.t2};
    u.normal = ends && !end.pays ? real(0) : u.normal + p * piece.rate.normal;
    stops = stops && !ends;
    u.tangent_1 = stops ? real(0) : u.tangent_1 + p * piece.rate.tangent_1;
    u.tangent_2 = stops ? real(0) : u.tangent_2 + p * piece.rate.tangent_2;
    if (ends && end.pays) break;
  }
  return {r, u, std::sqrt(u.tangent_1 * u.tangent_1 + u.tangent_2 * u.tangent_2) > least};
}

/// Chatterjee and Ruina's law. `u` approaches: u_n < 0.
template <class real>
ImpactOutcome<real> combine_impact(ConeVector<real> u, const Delassus<real>& w, const ImpactMaterial<real>& m) {
  const real inverse_nn = real(1) / w.nn, g1 = w.n1 * inverse_nn, g2 = w.n2 * inverse_nn;
  const real a11 = w.t11 - g1 * w.n1, a22 = w.t22 - g2 * w.n2, a12 = w.t12 - g1 * w.n2;
  const real b1 = u.tangent_1 - g1 * u.normal, b2 = u.tangent_2 - g2 * u.normal;
  const real inverse = real(1) / (a11 * a22 - a12 * a12);
  const real d1 = (a12 * b2 - a22 * b1) * inverse, d2 = (a12 * b1 - a11 * b2) * inverse;
  const real d_n = -(g1 * d1 + g2 * d2);
  const real bounce = (real(1) + m.restitution) * (-u.normal * inverse_nn);
  const real whole = real(1) + m.tangential_restitution;
  const real length = std::sqrt(d1 * d1 + d2 * d2), limit = m.friction * (bounce + whole * d_n);
  const bool slides = whole * length > limit;
  const real over = length - m.friction * d_n;
  const real cut = over > 0 ? m.friction * bounce / over : real(0);
  const real k = slides ? (cut < whole ? cut : whole) : whole;
  const ConeVector<real> r = {bounce + k * d_n, k * d1, k * d2}, change = times(w, r);
  return {r, {u.normal + change.normal, u.tangent_1 + change.tangent_1, u.tangent_2 + change.tangent_2}, slides};
}

/// What a contact that is hit asks of the sub-step, so that the impulse of the law is what solves it: u + bias, with
/// the friction of the cone. What ends in a slide keeps its direction of friction and so much of its slip as goes
/// against that, and gets as much of mu as it got on its way, where its slip turned round or stopped between.
/// Where friction is so strong that Coulomb's law may have several answers for a slide (mu |W_tn| >= W_nn), it is to
/// stick to the end's velocity instead.
template <class real>
struct ImpactTarget {
  ConeVector<real> bias;
  real friction;
};

template <class real>
ImpactTarget<real> target_of(const ImpactOutcome<real>& o, const Delassus<real>& w, real friction) {
  const ConeVector<real>&r = o.impulse, &u = o.velocity;
  const bool slides = o.slides && friction * friction * (w.n1 * w.n1 + w.n2 * w.n2) < w.nn * w.nn;
  const real tangential = std::sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2);
  const real d1 = tangential > 0 ? r.tangent_1 / tangential : real(0),
             d2 = tangential > 0 ? r.tangent_2 / tangential : real(0);
  const real against = -(u.tangent_1 * d1 + u.tangent_2 * d2), kept = slides && against > 0 ? against : real(0);
  return {{-u.normal, -(u.tangent_1 + kept * d1), -(u.tangent_2 + kept * d2)},
          slides && tangential < friction * r.normal ? tangential / r.normal : friction};
}

template <class real>
ImpactOutcome<real> impact(ConeVector<real> u, const Delassus<real>& w, const ImpactMaterial<real>& m) {
  return m.law == IMPACT_CHATTERJEE_RUINA ? combine_impact(u, w, m) : follow_impact(u, w, m);
}

}  // namespace lockstep::reference
