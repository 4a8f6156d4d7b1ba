#include "host/scene/renamed_keys.hpp"

#include <algorithm>

namespace lockstep {

namespace {

struct RenamedKey {
  const char *old, *current;
  bool is_met = false;
};

constexpr RenamedKey renamed_keys[] = {
#define RENAMED_KEY(old, current) {#old, #current},
#include "host/scene/renamed_keys.def"
#undef RENAMED_KEY
};

}  // namespace

const char* old_key(std::string_view key) {
  const auto found = std::ranges::find(renamed_keys, key, &RenamedKey::current);
  return found == std::end(renamed_keys) ? nullptr : found->old;
}

std::vector<std::string> notes_on_keys(const nlohmann::json& document) {
  std::vector<std::string> notes;
  std::vector<const nlohmann::json*> open = {&document};
  std::vector<RenamedKey> keys(std::begin(renamed_keys), std::end(renamed_keys));
  while (!open.empty()) {
    const nlohmann::json& value = *open.back();
    open.pop_back();
    for (RenamedKey& key : keys) key.is_met = key.is_met || value.contains(key.old);
    if (value.is_structured())
      for (const nlohmann::json& element : value) open.push_back(&element);
  }
  for (const RenamedKey& key : keys)
    if (key.is_met) notes.push_back("the key \"" + std::string(key.old) + "\" is called \"" + key.current + "\" now");
  return notes;
}

}  // namespace lockstep
