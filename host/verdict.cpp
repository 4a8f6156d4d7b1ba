#include "host/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lockstep {

namespace {

constexpr CriterionInfo infos[] = {
#define CRITERION(name, bound, unit, meaning) {#name, unit, meaning},
#include "host/verdict.def"
};

std::string with_unit(double value, const char* unit) {
  return fmt::format("{:.3g}{}{}", value, *unit ? " " : "", unit);
}

#define CRITERION(name, bound, unit, meaning) name,
enum class Row : u32 {
#include "host/verdict.def"
  count
};
static_assert(static_cast<u32>(Row::count) == criterion_count);
#define CRITERION(name, bound, unit, meaning) \
  static_assert(static_cast<u32>(Row::name) == static_cast<u32>(Criterion::name));
#include "host/verdict.def"

}  // namespace

Unsolved Unsolved::of(u32 sub_steps, u32 step, Stop stop, double residual, double tolerance) {
  Unsolved all;
  all.count = all.ended[static_cast<u32>(stop)] = sub_steps;
  all.first_step = all.worst_step = step;
  all.first_stop = all.worst_stop = stop;
  all.worst_residual = residual;
  all.tolerance = tolerance;
  return all;
}

void Unsolved::add(const Unsolved& later) {
  if (later.count == 0) return;
  const bool is_first = count == 0, is_worse = is_first || later.is_worse_than(*this);
  count += later.count;
  for (u32 stop = 0; stop < stop_count; ++stop) ended[stop] += later.ended[stop];
  if (is_first) {
    first_step = later.first_step;
    first_stop = later.first_stop;
  }
  if (!is_worse) return;
  worst_step = later.worst_step;
  worst_stop = later.worst_stop;
  worst_residual = later.worst_residual;
  tolerance = later.tolerance;
  of_changes = later.of_changes;
}

bool Unsolved::is_worse_than(const Unsolved& other) const {
  const bool bad = worst_stop == Stop::bad, other_bad = other.worst_stop == Stop::bad;
  if (bad || other_bad) return bad && !other_bad;
  return worst_residual > other.worst_residual;
}

const CriterionInfo& info(Criterion criterion) { return infos[static_cast<u32>(criterion)]; }

std::string title(Criterion criterion) {
  std::string words = info(criterion).name;
  std::ranges::replace(words, '_', ' ');
  return words;
}

bool Verdict::good() const {
  if (unsolved.count > 0) return false;
  for (u32 i = 0; i < criterion_count; ++i)
    if (!keeps(static_cast<Criterion>(i))) return false;
  return true;
}

void Verdict::add(const Verdict& other) {
  unsolved.add(other.unsolved);
  for (u32 i = 0; i < criterion_count; ++i) {
    Judgement& mine = judgements[i];
    const Judgement& theirs = other.judgements[i];
    mine.bound = theirs.bound;
    mine.first_step = std::min(mine.first_step, theirs.first_step);
    if (theirs.worst <= mine.worst) continue;
    mine.worst = theirs.worst;
    mine.worst_step = theirs.worst_step;
  }
  if (other.energy_source != EnergySource::none) energy_source = other.energy_source;
}

std::string in_words(const std::string& solver, const Unsolved& unsolved) {
  std::string ends;
  for (u32 stop = 1; stop < stop_count; ++stop) {
    if (unsolved.ended[stop] == 0) continue;
    const std::string_view name = stop_name(static_cast<Stop>(stop));
    ends += fmt::format("{}{} {}{}", ends.empty() ? "" : ", ", unsolved.ended[stop],
                        stop == static_cast<u32>(Stop::limit) ? "at its " : "", name);
  }
  const std::string first =
      unsolved.first_step == unsolved.worst_step
          ? std::string()
          : fmt::format("the first in step {} ({}), ", unsolved.first_step, stop_name(unsolved.first_stop));
  const std::string words =
      fmt::format("{} left {} sub-steps unsolved ({}), {}the worst in step {} ({})", solver, unsolved.count, ends,
                  first, unsolved.worst_step, stop_name(unsolved.worst_stop));
  if (unsolved.worst_stop == Stop::bad) return words;
  if (unsolved.of_changes)
    return fmt::format("{}: the last sweep changed velocities by more than {:.3g} m/s", words, unsolved.tolerance);
  return fmt::format("{}: a residual of {:.3g}, not {:.3g}", words, unsolved.worst_residual, unsolved.tolerance);
}

std::string in_words(const Verdict& verdict) {
  std::string text = verdict.unsolved.count > 0 ? in_words("the solver", verdict.unsolved) : "";
  for (u32 i = 0; i < criterion_count; ++i) {
    const Criterion criterion = static_cast<Criterion>(i);
    if (verdict.keeps(criterion)) continue;
    const CriterionInfo& of = info(criterion);
    const Judgement& j = verdict[criterion];
    text += fmt::format("{}{} {} after {} steps, above {} since {}", text.empty() ? "" : "; ", title(criterion),
                        with_unit(j.worst, of.unit), j.worst_step, with_unit(j.bound, of.unit), j.first_step);
  }
  return text.empty() ? "good" : text;
}

std::string in_words(EnergySource source) {
  switch (source) {
    case EnergySource::none: return "";
    case EnergySource::particles: return "particles push by springs";
    case EnergySource::soft_joints: return "soft joints keep some";
    case EnergySource::loads: return "loads act on bodies";
    case EnergySource::kinematic_bodies: return "kinematic bodies move";
    case EnergySource::unbounded_motors: return "motors of unbounded force drive it";
    case EnergySource::servos: return "servos drive it";
  }
  return "";
}

}  // namespace lockstep
