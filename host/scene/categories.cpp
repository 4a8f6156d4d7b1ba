#include "host/scene/categories.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"

namespace lockstep {

u32 category_mask(const std::vector<std::string>& categories, const std::vector<std::string>& names) {
  const std::vector<std::string> known = categories.empty() ? std::vector<std::string>{"default"} : categories;
  u32 mask = 0;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(known, name);
    if (found == known.end())
      throw Error(Failure::input, "mask", "unknown category " + quote(name) + "; " + suggestion(name, known));
    mask |= 1u << (found - known.begin());
  }
  return mask;
}

}  // namespace lockstep
