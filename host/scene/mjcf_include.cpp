#include "host/scene/mjcf_include.hpp"

#include <fmt/format.h>

#include <set>

#include "host/scene/json_node.hpp"
#include "host/scene/text_file.hpp"

namespace lockstep {

namespace fs = std::filesystem;

namespace {

void follow(XmlDocument& document, const XmlNode& node, const fs::path& main, std::set<fs::path>& known) {
  for (const XmlNode& child : node.children()) {
    if (child.name() != "include") {
      follow(document, child, main, known);
      continue;
    }
    const std::string file = child.text("file");
    const fs::path path = file_beside(child, main, file);
    if (path.empty())
      child.fail("file", fmt::format("names no file: {} does not exist; it is looked for from the folder of this file, "
                                     "and from that of the first one",
                                     quote(file)));
    if (!known.insert(path).second) child.fail("file", fmt::format("includes {} again", quote(file)));
    auto other = std::make_unique<XmlDocument>(read_text_file(path.string()), path.string());
    const XmlNode inside = document.include(child, std::move(other));
    follow(document, inside, main, known);
  }
}

}  // namespace

void follow_includes(XmlDocument& document, const XmlNode& top) {
  const fs::path main = fs::path(top.source()).lexically_normal();
  std::set<fs::path> known = {main};
  follow(document, top, main, known);
}

fs::path file_beside(const XmlNode& node, const fs::path& main, const std::string& file) {
  std::error_code ignored;
  for (const fs::path& near : {fs::path(node.source()), main}) {
    const fs::path path = (near.parent_path() / file).lexically_normal();
    if (fs::is_regular_file(path, ignored)) return path;
  }
  return {};
}

}  // namespace lockstep
