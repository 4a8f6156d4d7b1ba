// <include> elements of MJCF: files whose elements stand in their place.
#pragma once

#include <filesystem>

#include "host/scene/xml_node.hpp"

namespace lockstep {

/// Reads all files that a document includes, and those that they do. Each may be included once.
void follow_includes(XmlDocument& document, const XmlNode& top);

/// A file that an element names: from the folder of the element's own file, else from that of the main one. Nothing
/// where neither has it.
std::filesystem::path file_beside(const XmlNode& node, const std::filesystem::path& main, const std::string& file);

}  // namespace lockstep
