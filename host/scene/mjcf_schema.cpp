#include "host/scene/mjcf_schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>

namespace lockstep {

namespace {

constexpr MjcfRow rows[] = {
#define MJCF(parent, element, role, attributes, neutral) {parent, element, MjcfRole::role, attributes, neutral},
#include "host/scene/mjcf_schema.def"
#undef MJCF
};

bool is_among(std::string_view word, std::string_view words) {
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (words.substr(at, end - at) == word) return true;
    at = end + 1;
  }
  return false;
}

// The element that holds such elements in the table: what a <default> has stands elsewhere, too.
std::string_view home_of(std::string_view parent, std::string_view element) {
  if (parent == "worldbody" || parent == "frame" || parent == "replicate") return "body";
  if (parent != "default") return parent;
  if (element == "default" || element == "equality") return element;
  if (element == "tendon") return "tendon";
  if (element == "pair") return "contact";
  if (element == "mesh" || element == "material" || element == "texture") return "asset";
  if (std::ranges::any_of(rows, [&](const MjcfRow& row) { return row.parent == "actuator" && row.element == element; }))
    return "actuator";
  return "body";
}

bool is_neutral(const XmlNode& node, const std::string& attribute, std::string_view neutral) {
  std::istringstream words(node.value(attribute.c_str()));
  for (std::string word; words >> word;) {
    if (word == neutral) continue;
    const bool is_zero = neutral == "0" && word.find_first_not_of("+-0.") == word.npos;
    if (!is_zero) return false;
  }
  return true;
}

class Walk {
 public:
  explicit Walk(LeftOut& left_out) : left_out_(left_out) {}

  void children(const XmlNode& node, std::string_view parent) {
    for (const XmlNode& child : node.children()) element(child, home_of(parent, child.name()));
  }

  void element(const XmlNode& node, std::string_view parent) {
    const std::string name = node.name();
    // the defaults of tendons are those of both kinds
    const std::string_view looked_up = parent == "tendon" && name == "tendon" ? std::string_view("fixed") : name;
    const auto is_it = [&](const MjcfRow& row) { return row.parent == parent && row.element == looked_up; };
    if (name.starts_with("xacro:")) node.fail("is to be expanded first: xacro x.xml.xacro > x.xml");
    const auto whole =
        std::ranges::find_if(rows, [&](const MjcfRow& row) { return is_it(row) && row.attributes == "*"; });
    if (whole != std::end(rows) && whole->role == MjcfRole::MOVES) {
      left_out_.approximate(node.location(), "is not simulated, and moves bodies; remove it, or run with --approximate",
                            name);
      return;
    }
    if (whole != std::end(rows) || std::ranges::none_of(rows, is_it)) {
      left_out_.add(node.location(), name);
      return;
    }
    for (const std::string& attribute : node.attributes()) see(node, attribute, is_it);
    children(node, name);
  }

 private:
  template <class Predicate>
  void see(const XmlNode& node, const std::string& attribute, const Predicate& is_it) {
    const auto row =
        std::ranges::find_if(rows, [&](const MjcfRow& r) { return is_it(r) && is_among(attribute, r.attributes); });
    const std::string what = node.name() + " " + attribute, location = node.location() + " " + attribute;
    if (row == std::end(rows) || row->role == MjcfRole::LEFT) {
      if (attribute.find(':') == attribute.npos && attribute != "xmlns") left_out_.add(location, what);
    } else if (row->role == MjcfRole::SOFT) {
      left_out_.add_softness(location, what);
    } else if (row->role == MjcfRole::MOVES && !is_neutral(node, attribute, row->neutral)) {
      const std::string cure = row->neutral.empty() ? "leave it out" : fmt::format("set it to {}", row->neutral);
      left_out_.approximate(
          location, fmt::format("is not simulated, and changes the motion; {}, or run with --approximate", cure), what);
    }
  }

  LeftOut& left_out_;
};

}  // namespace

std::span<const MjcfRow> mjcf_rows() { return rows; }

void expect_mjcf(const XmlNode& top, LeftOut& left_out) { Walk(left_out).element(top, ""); }

}  // namespace lockstep
