// Keys of scene files that had another name (renamed_keys.def).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace lockstep {

/// Gives old keys of the document, at any depth, their current names, but where an object has both. One line for each
/// old key that was met, however often.
std::vector<std::string> update_keys(nlohmann::json& document);

/// What an old key is called now; null for others.
const char* current_key(std::string_view key);

}  // namespace lockstep
