// Launches of the stages that say who touches.
#include "host/device/launcher.hpp"

namespace lockstep {

void launch_mark_touching(Launcher& launcher) { launcher.run("mark_touching", launcher.plan().contacts); }

void launch_find_events(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("touch_slots", std::size_t{plan.sizes.pairs} + 1);
  launcher.scratch("touching_starts", std::size_t{plan.sizes.shapes} + 1);
  launcher.scratch("current_touching", std::size_t{plan.sizes.pairs} * 2);
  launcher.scratch("event_slots", std::size_t{plan.sizes.pairs} * 2 + 1);
  launcher.run("find_events_mark", plan.pairs + 1);
  launcher.scan("touch_slots", plan.sizes.pairs + 1, COUNTER_PAIRS, plan.pairs + 1);
  launcher.run("find_events_gather", plan.pairs);
  const bool sleeping = has(plan.features, Feature::sleeping);
  if (sleeping) {
    launcher.scratch("touch_stays", std::size_t{plan.sizes.pairs} * 2 + 1);
    launcher.scratch("touching_after", std::size_t{plan.sizes.pairs} * 2);
  }
  // at most all pairs touch, as many as did
  launcher.run("find_events_compare", 2 * plan.pairs + 1,
               {{"touch_stays", std::string_view(sleeping ? "touch_stays" : "event_slots")}});
  if (sleeping) launcher.scan("touch_stays", 2 * plan.sizes.pairs + 1, COUNTER_EVENTS, 2 * plan.pairs + 1);
  launcher.scan("event_slots", 2 * plan.sizes.pairs + 1, COUNTER_EVENTS, 2 * plan.pairs + 1);
  launcher.run("find_events_write", 2 * plan.pairs);
  if (!sleeping) return launcher.run("find_events_keep", plan.pairs);
  launcher.run("find_events_merge", 2 * plan.pairs);
  launcher.run_group("find_events_replace");
}

}  // namespace lockstep
