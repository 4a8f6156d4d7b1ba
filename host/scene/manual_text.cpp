#include "host/scene/manual_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "host/scene/joint_kinds.hpp"
#include "host/scene/setting_table.hpp"
#include "host/scene/shape_kinds.hpp"

namespace lockstep {

namespace {

using nlohmann::ordered_json;

// The rows by groups, and in each as the table has them.
std::vector<const SettingInfo*> ordered_rows() {
  std::vector<const SettingInfo*> rows;
  for (const SettingInfo& row : setting_infos()) rows.push_back(&row);
  std::ranges::stable_sort(rows, {}, &SettingInfo::group);
  return rows;
}

bool is_named(const SettingInfo& row, std::string_view name) { return name == row.name; }

// "`a`, `b` or `c`"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "`" : i + 1 == names.size() ? " or `" : ", `") + names[i] + "`";
  return text;
}

std::string type_text(const SettingInfo& row) {
  const std::string unit = *row.unit ? std::string(", ") + row.unit : "", bounds = row.bounds.text();
  switch (row.bounds.kind) {
    case Bounds::Kind::name: return is_named(row, "solver") ? "name" : listed(names_of(row));
    case Bounds::Kind::integers:
    case Bounds::Kind::fraction: return bounds + unit;
    case Bounds::Kind::positive:
    case Bounds::Kind::not_negative: return "number " + bounds + unit;
    case Bounds::Kind::any: break;
  }
  if (!is_named(row, "sleeping")) return "boolean";
  std::string text = "boolean, or object with ";
  for (const SettingInfo& key : sleep_setting_infos())
    text += fmt::format("{}`{}` ({})", &key == &sleep_setting_infos()[0] ? "" : ", ", key.name, type_text(key));
  return text;
}

std::string initial_text(const SettingInfo& row) {
  if (*row.bounds.in_words) return row.bounds.in_words;
  if (is_named(row, "sleeping")) {
    std::string values;
    for_each_sleep_setting(SleepSettings(), [&](const SettingInfo& key, const auto& x) {
      values += values.empty() ? "`false`; " : ", ";
      values += *key.bounds.in_words ? key.bounds.in_words : fmt::format("{}", std::optional<double>(x).value_or(0));
    });
    return values;
  }
  std::string text = "the solver's";
  for_each_scene_setting(Settings(), [&]<class T>(const SettingInfo& each, const T& setting) {
    if (&each != &row) return;
    if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
      text = fmt::format("{}", setting);
    else if constexpr (!requires { setting.value(); })
      text = fmt::format("`{}`", to_json(Settings())[row.name].dump());
  });
  std::erase(text, '"');
  return text;
}

// JSON on one line, as people write it.
std::string spaced(const ordered_json& value) {
  if (value.is_number_float()) return fmt::format("{}", value.get<double>());
  if (!value.is_structured()) return value.dump();
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty() ? "" : ", ") + (value.is_object() ? "\"" + key + "\": " : "") + spaced(item);
  return value.is_object() ? "{" + text + "}" : "[" + text + "]";
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

// In the words of a page that need not name itself.
std::string in_manual(std::string text) {
  replace_all(text, " (docs/reference/settings.md)", ", see below");
  replace_all(text, "(docs/", "(`docs/");
  replace_all(text, ".md)", ".md`)");
  return text;
}

std::string meaning_in_manual(const SettingInfo& row) { return in_manual(row.meaning); }

// An entry of a list, in lines of at most 120 characters.
std::string entry(const std::string& text) {
  std::istringstream words(text);
  std::string lines, line = "-";
  for (std::string word; words >> word; line += " " + word) {
    if (line.size() + 1 + word.size() <= 120) continue;
    lines += line + "\n";
    line = " ";
  }
  return lines + line + "\n";
}

std::string description(const SettingInfo& row) {
  return row.meaning + (*row.unit ? std::string(" (") + row.unit + ")" : "");
}

ordered_json schema_of(const SettingInfo& row, const ordered_json& initial);

ordered_json schema_of_sleeping() {
  ordered_json keys;
  for_each_sleep_setting(SleepSettings(), [&](const SettingInfo& key, const std::optional<double>& x) {
    keys[key.name] = schema_of(key, x ? ordered_json(*x) : ordered_json());
  });
  return {{"oneOf",
           {{{"type", "boolean"}, {"default", false}},
            {{"type", "object"}, {"additionalProperties", false}, {"properties", keys}}}}};
}

// `initial`: null where there is none.
ordered_json schema_of(const SettingInfo& row, const ordered_json& initial) {
  ordered_json schema;
  switch (row.bounds.kind) {
    case Bounds::Kind::any:
      schema = is_named(row, "sleeping") ? schema_of_sleeping() : ordered_json{{"type", "boolean"}};
      break;
    case Bounds::Kind::positive: schema["$ref"] = "#/$defs/positive"; break;
    case Bounds::Kind::not_negative: schema["$ref"] = "#/$defs/not_negative"; break;
    case Bounds::Kind::fraction: schema["$ref"] = "#/$defs/share"; break;
    case Bounds::Kind::integers:
      schema = {{"type", "integer"}, {"minimum", row.bounds.least}, {"maximum", row.bounds.most}};
      break;
    case Bounds::Kind::name: schema["enum"] = names_of(row);
  }
  if (!initial.is_null()) schema["default"] = initial;
  schema["description"] = description(row);
  return schema;
}

template <class Names>
std::string types_schema(const Names& names) {
  ordered_json known;
  for (const auto& named : names) known.push_back(named.first);
  return "        \"type\": " + spaced({{"enum", known}}) + ",\n";
}

}  // namespace

std::string settings_manual() {
  std::string text;
  for (const SettingInfo* row : ordered_rows())
    text += entry(fmt::format("`{}` ({}; unless given: {}): {}", row->name, type_text(*row), initial_text(*row),
                              meaning_in_manual(*row)));
  return text;
}

std::string solvers_manual() {
  std::string text;
  for (const SolverInfo& solver : solver_infos)
    if (!solver.is_oracle)
      text += entry(fmt::format("`{}` (sub-steps: {}; iterations: {}): {}. Use it for: {}", solver.name,
                                solver.substeps, solver.iterations, in_manual(solver.what), in_manual(solver.use)));
  return text;
}

std::string oracles_manual() {
  std::string text;
  for (const SolverInfo& solver : solver_infos)
    if (solver.is_oracle) text += entry(fmt::format("`{}`: {}", solver.name, in_manual(solver.what)));
  return text;
}

std::string shapes_manual() {
  std::string text;
  for (const ShapeKindInfo& kind : shape_kind_infos) {
    std::string keys;
    for (const auto& [key, bit] : shape_keys)
      if (((kind.needs | kind.may) & bit) != 0) keys += fmt::format("{}`{}`", keys.empty() ? " (" : ", ", key);
    text += entry(fmt::format("`{}`{}: {}", kind.name, keys.empty() ? keys : keys + ")", kind.meaning));
  }
  return text;
}

std::string joints_manual() {
  std::string text;
  for (const JointKindInfo& kind : joint_kind_infos) text += entry(fmt::format("`{}`: {}", kind.name, kind.leaves));
  return text;
}

std::string shape_types_schema() { return types_schema(shape_names); }
std::string joint_types_schema() { return types_schema(joint_names); }

std::string settings_schema() {
  ordered_json initial;
  for_each_scene_setting(Settings(), [&](const SettingInfo& row, const auto& setting) {
    if constexpr (!requires { setting.value(); }) initial[row.name] = to_json(Settings())[row.name];
  });
  std::string text;
  for (const SettingInfo* row : ordered_rows())
    text += fmt::format("{}        \"{}\": {}", text.empty() ? "" : ",\n", row->name,
                        spaced(schema_of(*row, initial.value(row->name, ordered_json()))));
  return text + "\n";
}

}  // namespace lockstep
