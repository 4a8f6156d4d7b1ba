// A location in a JSON document: a value with its path, read strictly. Every refusal is one line, "file: /json/path:
// rule, is VALUE".
#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/error.hpp"
#include "host/scene/exact_math.hpp"
#include "kernels/types.h"

namespace lockstep {

/// Parses strict JSON: no deeper than 64 levels, no key twice, every number finite as a double. Throws Error (input).
nlohmann::json parse_json(const std::string& text, const std::string& source);

/// `text` as JSON writes it, in ASCII and cut short: fit for an error of one line.
std::string quote(const std::string& text);

/// The cure for an unknown name: the nearest of `names` when it is near, otherwise all of them.
std::string suggestion(const std::string& unknown, const std::vector<std::string>& names);

class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, const std::string& source, std::string path = "")
      : value_(&value), source_(&source), path_(std::move(path)) {}

  /// Throws Error: `what` is said of this location.
  [[noreturn]] void fail(const std::string& what) const;
  /// The file that the document stands in.
  const std::string& source() const { return *source_; }

  /// Throws Error: "must be `rule`, is VALUE".
  [[noreturn]] void must_be(const std::string& rule) const;
  /// Throws Error: "unknown `kind` WORD", with the nearest of `names`.
  [[noreturn]] void unknown(const std::string& kind, const std::string& word,
                            const std::vector<std::string>& names) const;

  /// Refuses anything but an object, and keys other than these.
  void expect_object(std::span<const std::string_view> known_keys) const;
  void expect_object(std::initializer_list<std::string_view> known_keys) const {
    expect_object(std::span(known_keys.begin(), known_keys.size()));
  }
  bool is_object() const { return value_->is_object(); }
  bool is_array() const { return value_->is_array(); }

  /// Keys are met by their old names too (renamed_keys.hpp).
  bool has(const char* key) const { return name_of(key) != nullptr; }
  JsonNode at(const char* key) const;  // refuses an object that lacks it

  /// The elements of an array.
  std::vector<JsonNode> elements() const;

  double number() const;
  double positive() const;      // > 0
  double not_negative() const;  // >= 0
  double fraction() const;      // 0 .. 1
  u32 integer(u32 least, u32 most) const;
  bool boolean() const;
  std::string text() const;  // not empty
  Vector3 vector() const;    // an array of 3 numbers

  /// One of a few words, each with its value.
  template <class Value>
  Value choice(const std::string& kind, std::initializer_list<std::pair<const char*, Value>> choices) const {
    return choice(kind, std::span(choices.begin(), choices.size()));
  }
  template <class Value>
  Value choice(const std::string& kind, std::span<const std::pair<const char*, Value>> choices) const {
    const std::string word = text();
    std::vector<std::string> words;
    for (const auto& [name, value] : choices) {
      if (word == name) return value;
      words.push_back(name);
    }
    unknown(kind, word, words);
  }

 private:
  // As which the object has a key: its name or its old one; null where it lacks it.
  const char* name_of(const char* key) const;

  const nlohmann::json* value_;
  const std::string* source_;
  std::string path_;  // a JSON pointer
};

}  // namespace lockstep
