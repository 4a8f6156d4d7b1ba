// How a run came out: whether its bodies stayed apart, its joints closed and its energy where it belongs, in every
// step, and what its solver left unsolved (docs/reference/error_measures.md, "The verdict").
#pragma once

#include <array>
#include <string>

#include "types.hpp"

namespace lockstep {

/// How a solve ended, in the order in which one is worse than another.
enum class Stop {
  solved,      // to the residual, or to the tolerance, that was asked for
  limit,       // at its limit of iterations or of time, or too large for the method
  stalled,     // nothing gained any more; or the method cannot act on the problem
  infeasible,  // there is no solution: a certificate of that was found and checked
  bad,         // not a number, or the step was aborted
};
inline constexpr unsigned stop_count = 5;

/// The sub-steps that did not end as solved, how many in each way, and which was the first and which the worst. Of
/// oracles (docs/theory/oracles.md), and of solvers with a tolerance that used up their sweeps; one that is to make so
/// many sweeps promises nothing and leaves nothing unsolved. A step that failed counts once, as bad, whatever its
/// sub-steps came to.
struct Unsolved {
  u32 count = 0;
  std::array<u32, stop_count> ended = {};    // of each Stop; of `solved` none are counted
  u32 first_step = 0, worst_step = 0;        // steps count from 0
  Stop first_stop = {}, worst_stop = {};     // how the solver ended there
  double worst_residual = 0, tolerance = 0;  // what was left, and what was asked for
  bool of_changes = false;  // that is a change of velocity in a sweep, m/s, and what was left is not known

  /// So many sub-steps of one step, of which the worst left this residual.
  static Unsolved of(u32 sub_steps, u32 step, Stop stop, double residual, double tolerance);

  /// Adds those of a later part of the same run.
  void add(const Unsolved& later);

 private:
  // What is no number is worse than any number.
  bool is_worse_than(const Unsolved& other) const;
};

/// "nsgs left 3 sub-steps unsolved (2 at its limit, 1 stalled), the first in step 4 (limit), the worst in step 7
/// (stalled): a residual of 2e-09, not 1e-10".
std::string in_words(const std::string& solver, const Unsolved& unsolved);

/// What a run is judged by; docs/reference/error_measures.md has the formulas.
enum class Criterion : u32 {
  overlap,           // of two shapes over the inner radius of the smaller one
  joint_separation,  // distance of a joint's anchors over the size of the smaller body
  joint_angle,       // by which what a joint keeps parallel is off, rad
  speed,             // of a dynamic body, m/s
  energy_gain,       // energy from nowhere over the kinetic energy that there has been
  count
};
inline constexpr u32 criterion_count = static_cast<u32>(Criterion::count);

struct CriterionInfo {
  const char *name, *unit, *meaning;
};
const CriterionInfo& info(Criterion criterion);
/// Its name in words: "energy gain".
std::string title(Criterion criterion);

/// Where energy comes from that nobody counts, so that a gain of it is no fault. Particles push by springs, which keep
/// some, and overlap as they do.
enum class EnergySource : u32 { none, particles, soft_joints, loads, kinematic_bodies, unbounded_motors, servos };

/// One figure of a run beside its bound. Steps are told by how many had been done: 0 is the state of the start.
struct Judgement {
  double worst = 0, bound = 0;  // in units of the criterion
  u32 worst_step = 0;
  u32 first_step = NONE;  // when it first was above the bound; NONE where it never was
};

struct Verdict {
  std::array<Judgement, criterion_count> judgements;
  Unsolved unsolved;  // what a solver that promises a residual or a tolerance did not keep
  EnergySource energy_source = EnergySource::none;  // for which the gain of energy is not judged

  const Judgement& operator[](Criterion criterion) const { return judgements[static_cast<u32>(criterion)]; }
  Judgement& operator[](Criterion criterion) { return judgements[static_cast<u32>(criterion)]; }

  /// Whether that figure counts: a gain of energy from outside does not, nor do overlaps of particles.
  bool is_judged(Criterion criterion) const {
    if (criterion == Criterion::overlap) return energy_source != EnergySource::particles;
    return criterion != Criterion::energy_gain || energy_source == EnergySource::none;
  }
  /// Whether it stayed within its bound.
  bool keeps(Criterion criterion) const { return !is_judged(criterion) || (*this)[criterion].first_step == NONE; }
  bool good() const;

  /// Takes the worse of both, figure by figure.
  void add(const Verdict& other);
};

/// "overlap 0.83 after 12 steps, more than 0.5 from 10 on; speed ..."; "good" where all is.
std::string in_words(const Verdict& verdict);

/// "kinematic bodies move": why the gain of energy is not judged.
std::string in_words(EnergySource source);

}  // namespace lockstep
