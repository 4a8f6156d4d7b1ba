// How a run came out: whether its bodies stayed apart, its joints closed and its energy where it belongs, in every step
// (docs/error_measures.md, "The verdict").
#pragma once

#include <array>
#include <string>

#include "host/unsolved.hpp"

namespace lockstep {

enum class Criterion : u32 {
#define CRITERION(name, bound, unit, meaning) name,
#include "host/verdict.def"
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
