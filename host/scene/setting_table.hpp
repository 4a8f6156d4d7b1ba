// The rows of host/settings.def as data, for what reads, checks and describes settings.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/json_node.hpp"
#include "host/scene/settings.hpp"

namespace lockstep {

/// Which values a setting takes.
struct Bounds {
  enum class Kind { any, positive, not_negative, fraction, integers, name } kind = Kind::any;
  u32 least = 0, most = 0;        // integers
  const char* noun = "";          // name: what it is called in errors
  const char* in_words = "";      // what holds where it is not given; empty: its initial value
  bool contains(double x) const;  // of numbers
  std::string text() const;       // as the manual has it: "> 0", "1 .. 100"; empty where any will do
  constexpr Bounds unless(const char* words) const { return {kind, least, most, noun, words}; }
};

enum class SettingGroup { time, solver, contacts, joints, bodies, verdict };
inline constexpr const char* setting_group_names[] = {"Time",   "Solver",           "Contacts",
                                                      "Joints", "Bodies and pairs", "Verdict"};

/// Where a setting acts: in the numbers of a step (StepParams), in what a scene is compiled to, in what runs it.
enum class Acts { step, scene, program };

struct SettingInfo {
  const char* name;
  Bounds bounds;
  const char* unit;
  SettingGroup group;
  Acts acts;
  const char* meaning;
};

/// The rows in their order, and those of `sleeping`.
std::span<const SettingInfo> setting_infos();
std::span<const SettingInfo> sleep_setting_infos();

/// The names that a setting takes; none where it takes no names.
std::vector<std::string> names_of(const SettingInfo& row);

/// The row of this name; there must be one.
const SettingInfo& setting_info(std::string_view name);

/// Calls function(row, setting) for each setting of Settings, const or not.
template <class Owner, class Function>
void for_each_scene_setting(Owner&& settings, Function&& function) {
  auto row = setting_infos().begin();
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) function(*row++, settings.name);
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) function(*row++, settings.name);
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) function(*row++, settings.name);
#include "host/settings.def"
}

/// The same of SleepSettings.
template <class Owner, class Function>
void for_each_sleep_setting(Owner&& settings, Function&& function) {
  auto row = sleep_setting_infos().begin();
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) function(*row++, settings.name);
#include "host/settings.def"
}

/// The object `settings` of a scene. Throws Error (input) for what is no setting, or out of its bounds.
Settings read_settings(const JsonNode& node);

/// Gives the setting of that row the value of a node, as read_settings() does.
void read_setting(const JsonNode& node, const SettingInfo& row, Settings& settings);

/// The same from the text of an option: "0.5", "jacobi", "true". Errors begin with the rule: "must be > 0, is -1".
void read_setting(const std::string& text, const SettingInfo& row, Settings& settings);

/// All that is set, or that the solver brings, as scenes write it.
nlohmann::ordered_json to_json(const Settings& settings);

/// Throws Error (input) for settings, made in code, that are out of their bounds.
void expect_in_bounds(const Settings& settings);

}  // namespace lockstep
