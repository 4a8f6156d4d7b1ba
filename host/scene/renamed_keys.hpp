// Keys of scene files that had another name (renamed_keys.def): JsonNode finds them by either.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace lockstep {

/// What a key was called before; null where it always had its name.
const char* old_key(std::string_view key);

/// A line for each old key in the document, however often it stands there: how it is called now.
std::vector<std::string> notes_on_keys(const nlohmann::json& document);

}  // namespace lockstep
