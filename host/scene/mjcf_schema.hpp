// The elements and attributes of MJCF, and what becomes of each: the table mjcf_schema.def, walked once through a
// document before it is read.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/scene/left_out.hpp"
#include "host/scene/xml_node.hpp"

namespace lockstep {

enum class MjcfRole { READ, LEFT, SOFT, MOVES };

struct MjcfRow {
  std::string_view parent, element;
  MjcfRole role;
  std::string_view attributes, neutral;
};

std::span<const MjcfRow> mjcf_rows();

/// Counts what no reader looks at, and refuses what changes the motion.
void expect_mjcf(const XmlNode& top, LeftOut& left_out);

}  // namespace lockstep
