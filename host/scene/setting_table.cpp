#include "host/scene/setting_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

namespace lockstep {

namespace {

// What the columns of the table are made of, and its rows.
namespace columns {

constexpr Bounds any = {}, positive = {Bounds::Kind::positive}, not_negative = {Bounds::Kind::not_negative},
                 fraction = {Bounds::Kind::fraction};
constexpr Bounds between(u32 least, u32 most) { return {Bounds::Kind::integers, least, most}; }
constexpr Bounds one_of(const char* noun) { return {.kind = Bounds::Kind::name, .noun = noun}; }

constexpr SettingInfo rows[] = {
#define SETTING(type, name, initial, bounds, unit, group, acts, meaning) \
  {#name, bounds, unit, SettingGroup::group, Acts::acts, meaning},
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) \
  {#name, bounds, unit, SettingGroup::group, Acts::step, meaning},
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) \
  {#name, bounds, unit, SettingGroup::group, Acts::step, meaning},
#include "host/settings.def"
};

constexpr SettingInfo sleep_rows[] = {
#define SLEEP_SETTING(type, name, initial, bounds, unit, meaning) \
  {#name, bounds, unit, SettingGroup::bodies, Acts::scene, meaning},
#include "host/settings.def"
};

}  // namespace columns

constexpr std::pair<const char*, const char*> floating_point_names[] = {{"float", "float"}, {"double", "double"}};

// The names that a setting of a type takes.
std::span<const std::pair<const char*, Solver>> names_of(Solver) { return solver_names; }
std::span<const std::pair<const char*, FrictionModel>> names_of(FrictionModel) { return friction_model_names; }
std::span<const std::pair<const char*, JointSolver>> names_of(JointSolver) { return joint_solver_names; }
std::span<const std::pair<const char*, Integrator>> names_of(Integrator) { return integrator_names; }
std::span<const std::pair<const char*, Gyroscopic>> names_of(Gyroscopic) { return gyroscopic_names; }
std::span<const std::pair<const char*, Stabilization>> names_of(Stabilization) { return stabilization_names; }
std::span<const std::pair<const char*, EventPairs>> names_of(EventPairs) { return event_pairs_names; }
std::span<const std::pair<const char*, Forces>> names_of(Forces) { return forces_names; }
std::span<const std::pair<const char*, BroadPhase>> names_of(BroadPhase) { return broad_phase_names; }
std::span<const std::pair<const char*, const char*>> names_of(const std::string&) { return floating_point_names; }

void read(const JsonNode& node, const Bounds& bounds, double& x) {
  switch (bounds.kind) {
    case Bounds::Kind::positive: x = node.positive(); break;
    case Bounds::Kind::not_negative: x = node.not_negative(); break;
    case Bounds::Kind::fraction: x = node.fraction(); break;
    default: x = node.number();
  }
}

void read(const JsonNode& node, const Bounds& bounds, u32& x) { x = node.integer(bounds.least, bounds.most); }

void read(const JsonNode& node, const Bounds&, bool& x) { x = node.boolean(); }

template <class Name>
requires std::is_enum_v<Name> || std::is_same_v<Name, std::string>
void read(const JsonNode& node, const Bounds& bounds, Name& name) { name = node.choice(bounds.noun, names_of(Name())); }

template <class T>
void read(const JsonNode& node, const Bounds& bounds, std::optional<T>& setting) {
  read(node, bounds, setting.emplace());
}

// true and false stand for what is usual, and for none.
void read(const JsonNode& node, const Bounds&, std::optional<SleepSettings>& sleeping) {
  sleeping.reset();
  if (!node.is_object() && !node.boolean()) return;
  sleeping.emplace();
  if (!node.is_object()) return;
  std::vector<std::string_view> keys;
  for (const SettingInfo& row : columns::sleep_rows) keys.push_back(row.name);
  node.expect_object(keys);
  for_each_sleep_setting(*sleeping, [&](const SettingInfo& row, auto& x) {
    if (node.has(row.name)) read(node.at(row.name), row.bounds, x);
  });
}

// What an option says, as a scene file would: text where it is no number.
nlohmann::json value_of(const std::string& text, Bounds::Kind kind) {
  if (kind == Bounds::Kind::name) return text;
  if (kind == Bounds::Kind::any && (text == "true" || text == "false")) return text == "true";
  const char* end = text.data() + text.size();
  const auto parses = [&](auto& number) {
    const auto [stop, failed] = std::from_chars(text.data(), end, number);
    return stop == end && failed == std::errc();
  };
  if (std::uint64_t number = 0; parses(number)) return number;
  if (std::int64_t number = 0; parses(number)) return number;
  if (double number = 0; parses(number) && std::isfinite(number)) return number;
  return text;
}

// Adds a setting to an object as scenes write it, unless it is unset.
template <class T>
void put(nlohmann::ordered_json& object, const SettingInfo& row, const T& setting) {
  if constexpr (std::is_enum_v<T>) {
    object[row.name] =
        std::ranges::find(names_of(setting), setting, [](const auto& named) { return named.second; })->first;
  } else {
    object[row.name] = setting;
  }
}

void put(nlohmann::ordered_json& object, const SettingInfo& row, const SleepSettings& sleeping);

template <class T>
void put(nlohmann::ordered_json& object, const SettingInfo& row, const std::optional<T>& setting) {
  if (setting) put(object, row, *setting);
}

void put(nlohmann::ordered_json& object, const SettingInfo& row, const SleepSettings& sleeping) {
  nlohmann::ordered_json& keys = object[row.name];
  for_each_sleep_setting(sleeping, [&](const SettingInfo& each, const auto& x) { put(keys, each, x); });
}

[[noreturn]] void refuse(const SettingInfo& row, const std::string& rule, const std::string& value) {
  throw Error(Failure::input, std::string("settings.") + row.name, "must be " + rule + ", is " + value);
}

void check(const SettingInfo& row, double x) {
  if (!row.bounds.contains(x)) refuse(row, row.bounds.text(), fmt::format("{}", x));
}

void check(const SettingInfo& row, const std::string& x) {
  if (x != "float" && x != "double") refuse(row, "float or double", x);
}

void check(const SettingInfo&, const SleepSettings& sleeping);

template <class T>
void check(const SettingInfo& row, const std::optional<T>& x) {
  if (x) check(row, *x);
}

void check(const SettingInfo&, const SleepSettings& sleeping) {
  for_each_sleep_setting(sleeping, [](const SettingInfo& row, const auto& x) { check(row, x); });
}

// The types of C++ keep these within their bounds.
template <class T>
requires std::is_enum_v<T> || std::is_same_v<T, bool>
void check(const SettingInfo&, T) {}

}  // namespace

bool Bounds::contains(double x) const {
  switch (kind) {
    case Kind::positive: return x > 0;
    case Kind::not_negative: return x >= 0;
    case Kind::fraction: return x >= 0 && x <= 1;
    case Kind::integers: return x >= least && x <= most;
    default: return true;
  }
}

std::string Bounds::text() const {
  switch (kind) {
    case Kind::positive: return "> 0";
    case Kind::not_negative: return ">= 0";
    case Kind::fraction: return "0 .. 1";
    case Kind::integers: return fmt::format("{} .. {}", least, most);
    default: return "";
  }
}

std::span<const SettingInfo> setting_infos() { return columns::rows; }
std::span<const SettingInfo> sleep_setting_infos() { return columns::sleep_rows; }

const SettingInfo& setting_info(std::string_view name) {
  return *std::ranges::find(columns::rows, name, &SettingInfo::name);
}

nlohmann::ordered_json to_json(const Settings& settings) {
  nlohmann::ordered_json written;
  for_each_scene_setting(resolved(settings),
                         [&](const SettingInfo& row, const auto& setting) { put(written, row, setting); });
  return written;
}

std::vector<std::string> names_of(const SettingInfo& row) {
  std::vector<std::string> names;
  const auto list = [&]<class T>(const T& like) {
    if constexpr (std::is_enum_v<T> || std::is_same_v<T, std::string>)
      for (const auto& named : names_of(like)) names.emplace_back(named.first);
  };
  const auto function = [&]<class T>(const SettingInfo& each, const T& setting) {
    if (&each != &row) return;
    if constexpr (requires { setting.value(); })
      list(typename T::value_type());
    else
      list(setting);
  };
  for_each_scene_setting(Settings(), function);
  return names;
}

Settings read_settings(const JsonNode& node) {
  std::vector<std::string_view> keys;
  for (const SettingInfo& row : columns::rows) keys.push_back(row.name);
  node.expect_object(keys);
  Settings settings;
  for_each_scene_setting(settings, [&](const SettingInfo& row, auto& setting) {
    if (node.has(row.name)) read(node.at(row.name), row.bounds, setting);
  });
  return settings;
}

void read_setting(const JsonNode& node, const SettingInfo& row, Settings& settings) {
  for_each_scene_setting(settings, [&](const SettingInfo& each, auto& setting) {
    if (&each == &row) read(node, row.bounds, setting);
  });
}

void read_setting(const std::string& text, const SettingInfo& row, Settings& settings) {
  const nlohmann::json value = value_of(text, row.bounds.kind);
  read_setting(JsonNode(value, ""), row, settings);
}

void expect_in_bounds(const Settings& settings) {
  for_each_scene_setting(settings, [](const SettingInfo& row, const auto& setting) { check(row, setting); });
}

}  // namespace lockstep
