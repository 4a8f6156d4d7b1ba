// Laws of impact of one contact (cpu_reference/impact.hpp): closed forms in the plane, small steps in space, and
// energy.
#include <gtest/gtest.h>

#include <cmath>

#include "cpu_reference/cone.hpp"
#include "cpu_reference/impact.hpp"
#include "host/cases/planar_impact.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test::impact_laws_test {
namespace {

using reference::ConeVector;
using reference::Delassus;
using reference::ImpactMaterial;
using reference::ImpactOutcome;

template <class real>
class ImpactLaws : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ImpactLaws, Precisions);

template <class real>
constexpr double tolerance = sizeof(real) == 4 ? 1e-5 : 2e-14;

constexpr ImpactLaw laws[] = {IMPACT_POISSON, IMPACT_STRONGE, IMPACT_CHATTERJEE_RUINA};

struct Blow {
  ConeVector<double> u;
  Delassus<double> w;
  ImpactMaterial<double> material;
};

// J M^-1 J^T of two bodies of any mass, inertia and arm, and a velocity that closes.
Blow random_blow(Random& random, ImpactLaw law) {
  double w[3][3] = {};
  const double size = std::pow(10, random.between(-2, 2));
  for (int body = 0; body < 2; ++body) {
    const double inverse_mass = random.between(0, 1) * size, arm_length = std::pow(10, random.between(-1, 1));
    const Vector3 arm = random.vector(arm_length);
    double inverse_inertia[3][3] = {};  // a random inverse inertia: a sum of squares
    for (int k = 0; k < 3; ++k) {
      const Vector3 axis = random.vector(1);
      const double weight = random.between(0, 3) * size;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) inverse_inertia[i][j] += weight * axis[i] * axis[j];
    }
    const double cross[3][3] = {{0, -arm[2], arm[1]}, {arm[2], 0, -arm[0]}, {-arm[1], arm[0], 0}};
    for (int i = 0; i < 3; ++i) {
      w[i][i] += inverse_mass;
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l) w[i][j] += cross[i][k] * inverse_inertia[k][l] * cross[j][l];
    }
  }
  Blow blow;
  blow.w = {w[0][0], w[1][1], w[2][2], w[0][1], w[0][2], w[1][2]};
  blow.u = {-random.between(0.01, 1), random.between(-2, 2), random.between(-2, 2)};
  if (random.bits() % 10 == 0) blow.u.tangent_1 = blow.u.tangent_2 = 0;
  const u32 special = random.bits() % 8;
  blow.material = {law, random.bits() % 10 == 0 ? 0.0 : random.between(0, 1.5),
                   special == 0   ? 0.0
                   : special == 1 ? 1.0
                                  : random.between(0, 1),
                   random.between(-1, 1)};
  return blow;
}

template <class real>
ImpactOutcome<real> outcome(const Blow& b) {
  return reference::impact<real>(
      {real(b.u.normal), real(b.u.tangent_1), real(b.u.tangent_2)},
      {real(b.w.nn), real(b.w.t11), real(b.w.t22), real(b.w.n1), real(b.w.n2), real(b.w.t12)},
      {b.material.law, real(b.material.friction), real(b.material.restitution),
       real(b.material.tangential_restitution)});
}

double length(const ConeVector<double>& v) {
  return std::sqrt(v.normal * v.normal + v.tangent_1 * v.tangent_1 + v.tangent_2 * v.tangent_2);
}

// Velocity after an impulse, in double.
template <class real>
ConeVector<double> after(const Blow& b, const ConeVector<real>& r) {
  const ConeVector<double> change = reference::times(b.w, {double(r.normal), double(r.tangent_1), double(r.tangent_2)});
  return {b.u.normal + change.normal, b.u.tangent_1 + change.tangent_1, b.u.tangent_2 + change.tangent_2};
}

// Routh's cases in a plane through the normal that is turned in the tangent plane, where nothing else is symmetric.
TYPED_TEST(ImpactLaws, FollowRouthsLinesInThePlane) {
  using real = TypeParam;
  Random random(7);
  int stopped = 0, reversed = 0, jammed = 0;
  for (int i = 0; i < 3000; ++i) {
    PlanarImpact planar;
    const double inverse_mass = random.between(0.1, 2), x = random.between(-1, 1), z = random.between(-1.5, 1.5);
    const double inverse_inertia = random.between(0.5, 10);
    planar.w_nn = inverse_mass + x * x * inverse_inertia;
    planar.w_tt = inverse_mass + z * z * inverse_inertia;
    planar.w_nt = -x * z * inverse_inertia;
    planar.u_n = -random.between(0.1, 1);
    planar.u_t = random.bits() % 10 == 0 ? 0 : random.between(-1.5, 1.5);
    planar.friction = random.between(0.05, 1);
    planar.restitution = random.between(0, 1);
    planar.tangential_restitution = random.between(-1, 1);
    const double half_tangent = random.between(-1, 1),
                 d1 = (1 - half_tangent * half_tangent) / (1 + half_tangent * half_tangent),
                 d2 = 2 * half_tangent / (1 + half_tangent * half_tangent);
    const double across = random.between(0.1, 4);
    Blow blow;
    blow.u = {planar.u_n, planar.u_t * d1, planar.u_t * d2};
    blow.w = {planar.w_nn,
              planar.w_tt * d1 * d1 + across * d2 * d2,
              planar.w_tt * d2 * d2 + across * d1 * d1,
              planar.w_nt * d1,
              planar.w_nt * d2,
              (planar.w_tt - across) * d1 * d2};
    for (const ImpactLaw law : laws) {
      blow.material = {law, planar.friction, planar.restitution, planar.tangential_restitution};
      const PlanarImpulse exact = planar_impact(law, planar);
      const ImpactOutcome<real> found = outcome<real>(blow);
      const double size = std::hypot(exact.normal, exact.tangent) * (sizeof(real) == 4 ? 30 : 1e3);
      SCOPED_TRACE(i);
      EXPECT_NEAR(double(found.impulse.normal), exact.normal, tolerance<real> * size) << law;
      EXPECT_NEAR(double(found.impulse.tangent_1), exact.tangent * d1, tolerance<real> * size) << law;
      EXPECT_NEAR(double(found.impulse.tangent_2), exact.tangent * d2, tolerance<real> * size) << law;
    }
    const PlanarImpulse p = planar_impact(IMPACT_POISSON, planar);
    const double end = planar.u_t + planar.w_nt * p.normal + planar.w_tt * p.tangent;
    stopped += std::abs(end) < 1e-9;
    reversed += end * planar.u_t < -1e-9;
    jammed += planar.w_nn < planar.friction * std::abs(planar.w_nt);
  }
  EXPECT_GT(stopped, 300);
  EXPECT_GT(reversed, 100);
  EXPECT_GT(jammed, 20);
}

// What the laws promise of any impact: a push within the cone, no approach after it, and no gain of energy. Stronge's
// and Chatterjee and Ruina's prove the last; of Poisson's nobody has, in space.
TYPED_TEST(ImpactLaws, KeepTheConeAndCreateNoEnergy) {
  using real = TypeParam;
  for (const ImpactLaw law : laws) {
    Random random(11);
    double most = -1;
    for (int i = 0; i < 10000; ++i) {
      const Blow blow = random_blow(random, law);
      const ImpactOutcome<real> o = outcome<real>(blow);
      const ConeVector<double> r = {double(o.impulse.normal), double(o.impulse.tangent_1), double(o.impulse.tangent_2)};
      const ConeVector<double> end = after(blow, o.impulse);
      const double work[3] = {r.normal * (blow.u.normal + end.normal) / 2,
                              r.tangent_1 * (blow.u.tangent_1 + end.tangent_1) / 2,
                              r.tangent_2 * (blow.u.tangent_2 + end.tangent_2) / 2};
      const double size = length(r) * (length(blow.u) + length(end));
      most = std::max(most, (work[0] + work[1] + work[2]) / size);
      ASSERT_GT(r.normal, 0) << i;
      ASSERT_LE(std::hypot(r.tangent_1, r.tangent_2),
                blow.material.friction * r.normal * (1 + tolerance<real>)+tolerance<real> * r.normal)
          << i;
      ASSERT_GE(end.normal, -20 * tolerance<real> * length(blow.u)) << i;
    }
    EXPECT_LT(most, 2 * tolerance<real>) << impact_law_names[law].first;
    EXPECT_GT(most, -0.01) << "no impact is near to elastic";
  }
}

// Without friction all laws are Newton's: u_n+ = -e u_n.
TYPED_TEST(ImpactLaws, AreNewtonsWithoutFriction) {
  using real = TypeParam;
  for (const ImpactLaw law : laws) {
    Random random(13);
    for (int i = 0; i < 1000; ++i) {
      Blow blow = random_blow(random, law);
      blow.material.friction = 0;
      const ImpactOutcome<real> o = outcome<real>(blow);
      EXPECT_NEAR(after(blow, o.impulse).normal, -blow.material.restitution * blow.u.normal, 3 * tolerance<real>)
          << law;
      EXPECT_EQ(o.impulse.tangent_1, 0);
      EXPECT_EQ(o.impulse.tangent_2, 0);
    }
  }
}

// Kane and Levinson's paradox (1985): a foot at (0.5, -0.9) m from the centre of 1 kg with 0.1 kg m^2, mu = 0.5,
// e = 0.8, comes down at 1 m/s, slipping outwards at 1 m/s. By Newton's law it leaves with more energy than it had.
TEST(ImpactEnergy, KaneAndLevinsonsParadoxIsNewtonsAlone) {
  PlanarImpact impact = {-1, -1, 3.5, 9.1, 4.5, 0.5, 0.8};
  EXPECT_NEAR(energy_of(impact, planar_impact(IMPACT_NEWTON, impact)), 0.0958621, 1e-6);
  const ConeVector<double> r =
      reference::solve_general<double>({-1 - 0.8, -1, 0}, {3.5, 9.1, 1, 4.5, 0, 0}, 0.5);  // what a step does
  EXPECT_NEAR(energy_of(impact, {r.normal, r.tangent_1}), 0.0958621, 1e-6);
  EXPECT_NEAR(energy_of(impact, planar_impact(IMPACT_POISSON, impact)), -0.0910269, 1e-6);
  EXPECT_NEAR(energy_of(impact, planar_impact(IMPACT_STRONGE, impact)), -0.0735416, 1e-6);
  impact.tangential_restitution = 0.5;
  EXPECT_LT(energy_of(impact, planar_impact(IMPACT_CHATTERJEE_RUINA, impact)), 0);
}

// The laws part where a slide stops on the way: Poisson's e and Stronge's are not one number.
TEST(ImpactEnergy, PoissonsAndStrongesDifferWhereASlideStops) {
  const PlanarImpact stops = {-1, 0.2, 1.4, 1.9, 0.6, 0.5, 0.5}, goes_on = {-1, 3, 1.4, 1.9, 0.6, 0.5, 0.5};
  const auto difference = [](const PlanarImpact& impact) {
    return std::abs(planar_impact(IMPACT_POISSON, impact).normal - planar_impact(IMPACT_STRONGE, impact).normal);
  };
  EXPECT_GT(difference(stops), 1e-3);
  EXPECT_LT(difference(goes_on), 1e-15);
}

// Garwin's superball (1969): with e = e_t = 1 and enough friction the slip turns round, and all energy is kept.
TYPED_TEST(ImpactLaws, ASuperballReversesItsSlip) {
  using real = TypeParam;
  const double u_t = 0.7;
  Blow blow = {{-2, u_t, 0}, {1, 3.5, 3.5, 0, 0, 0}, {IMPACT_CHATTERJEE_RUINA, 0.5, 1, 1}};
  const ImpactOutcome<real> o = outcome<real>(blow);
  EXPECT_NEAR(double(o.impulse.normal), 4, 1e-6);
  EXPECT_NEAR(double(o.impulse.tangent_1), -4.0 / 7 * u_t, 1e-6);
  EXPECT_FALSE(o.slides);
  blow.material.friction = 0.05;  // too smooth: it slides, as Coulomb has it
  EXPECT_NEAR(double(outcome<real>(blow).impulse.tangent_1), -0.05 * 4, 1e-6);
  EXPECT_TRUE(outcome<real>(blow).slides);
}

// A hundred thousand implicit steps, each with Coulomb's law at its end by bisection: nothing of impact.hpp.
ConeVector<double> by_small_steps(const Blow& b, double step) {
  const bool by_work = b.material.law == IMPACT_STRONGE;
  const double e = b.material.restitution, share = by_work ? e * e : e, limit = b.material.friction * step;
  const Delassus<double>& w = b.w;
  ConeVector<double> u = b.u;
  double owed = 0;
  for (int k = 0; k < 400000; ++k) {
    const double q1 = u.tangent_1 + w.n1 * step, q2 = u.tangent_2 + w.n2 * step;
    double t1 = 0, t2 = 0;
    const auto friction_excess = [&](double l) {
      const double x = w.t11 + l, y = w.t22 + l, d = x * y - w.t12 * w.t12;
      t1 = (w.t12 * q2 - y * q1) / d;
      t2 = (w.t12 * q1 - x * q2) / d;
      return std::hypot(t1, t2) - limit;
    };
    if (friction_excess(0) > 0) {
      double low = 0, high = std::hypot(q1, q2) / limit;
      for (int half = 0; half < 45; ++half) (friction_excess((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
    }
    const ConeVector<double> change = reference::times(w, {step, t1, t2});
    const double mean = u.normal + change.normal / 2, measure = by_work ? std::abs(step * mean) : step;
    if (mean >= 0 && owed <= 0) break;
    owed += mean < 0 ? share * measure : -measure;
    u = {u.normal + change.normal, u.tangent_1 + change.tangent_1, u.tangent_2 + change.tangent_2};
  }
  return u;
}

// In space the direction of a slide turns, and pieces are chords of its path.
TEST(ImpactPaths, InSpaceAreThoseOfSmallSteps) {
  for (const ImpactLaw law : {IMPACT_POISSON, IMPACT_STRONGE}) {
    Random random(17);
    double worst = 0, sum = 0;
    constexpr int count = 60;
    for (int i = 0; i < count; ++i) {
      Blow blow = random_blow(random, law);
      if (!(blow.material.friction > 0)) blow.material.friction = 0.3;
      const ImpactOutcome<double> o = outcome<double>(blow);
      const ConeVector<double> found = after(blow, o.impulse), exact = by_small_steps(blow, o.impulse.normal / 20000);
      const double off =
          length({found.normal - exact.normal, found.tangent_1 - exact.tangent_1, found.tangent_2 - exact.tangent_2}) /
          length(blow.u);
      worst = std::max(worst, off);
      sum += off;
    }
    EXPECT_LT(worst, 0.01) << impact_law_names[law].first;
    EXPECT_LT(sum / count, 1e-3) << impact_law_names[law].first;
  }
}

// The sub-step that is given the targets of an impact solves it by the impulse of its law.
TEST(ImpactTargets, AreReachedByTheImpulseOfTheLaw) {
  for (const ImpactLaw law : laws) {
    Random random(19);
    double worst = 0;
    for (int i = 0; i < 5000; ++i) {
      const Blow blow = random_blow(random, law);
      const ImpactOutcome<double> o = outcome<double>(blow);
      const reference::ImpactTarget<double> target = reference::target_of(o, blow.w, blow.material.friction);
      const ConeVector<double> r = reference::solve_general<double>(
          {blow.u.normal + target.bias.normal, blow.u.tangent_1 + target.bias.tangent_1,
           blow.u.tangent_2 + target.bias.tangent_2},
          blow.w, target.friction);
      const ConeVector<double> found = after(blow, r), wanted = after(blow, o.impulse);
      worst = std::max(worst, length({found.normal - wanted.normal, found.tangent_1 - wanted.tangent_1,
                                      found.tangent_2 - wanted.tangent_2}) /
                                  (length(blow.u) + length(wanted)));
      ASSERT_LE(target.friction, blow.material.friction) << i;
    }
    EXPECT_LT(worst, 1e-6) << impact_law_names[law].first;
  }
}

}  // namespace
}  // namespace lockstep::test::impact_laws_test
