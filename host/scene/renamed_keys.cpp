#include "host/scene/renamed_keys.hpp"

#include <algorithm>

namespace lockstep {

namespace {

struct RenamedKey {
  const char *old, *current;
};

constexpr RenamedKey renamed_keys[] = {
#define RENAMED_KEY(old, current) {#old, #current},
#include "host/scene/renamed_keys.def"
#undef RENAMED_KEY
};

bool update_object(nlohmann::json& object, const RenamedKey& key) {
  const auto found = object.find(key.old);
  if (found == object.end() || object.contains(key.current)) return false;
  object[key.current] = std::move(*found);
  object.erase(key.old);
  return true;
}

}  // namespace

const char* current_key(std::string_view key) {
  const auto found = std::ranges::find(renamed_keys, key, &RenamedKey::old);
  return found == std::end(renamed_keys) ? nullptr : found->current;
}

std::vector<std::string> update_keys(nlohmann::json& document) {
  std::vector<std::string> notes;
  std::vector<nlohmann::json*> open = {&document};  // the parser limits the depth, not the number of values
  while (!open.empty()) {
    nlohmann::json& value = *open.back();
    open.pop_back();
    if (value.is_object()) {
      for (const RenamedKey& key : renamed_keys) {
        if (!update_object(value, key)) continue;
        const std::string note = "the key \"" + std::string(key.old) + "\" is called \"" + key.current + "\" now";
        if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
      }
    }
    if (value.is_structured())
      for (nlohmann::json& element : value) open.push_back(&element);
  }
  return notes;
}

}  // namespace lockstep
