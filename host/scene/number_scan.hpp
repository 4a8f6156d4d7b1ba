// Words and numbers of a text, one after the other.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace lockstep {

class NumberScan {
 public:
  explicit NumberScan(std::string_view text) : text_(text) {}

  /// The next line, without its end; nothing at the end of the text.
  std::optional<std::string_view> line() {
    if (text_.empty()) return std::nullopt;
    const std::size_t end = text_.find('\n');
    std::string_view found = text_.substr(0, end);
    text_.remove_prefix(end == text_.npos ? text_.size() : end + 1);
    if (found.ends_with('\r')) found.remove_suffix(1);
    return found;
  }

  /// The next word between blanks and ends of lines; empty at the end of the text.
  std::string_view word() {
    const std::size_t begin = text_.find_first_not_of(blanks);
    if (begin == text_.npos) return text_ = {};
    text_.remove_prefix(begin);
    const std::string_view found = text_.substr(0, text_.find_first_of(blanks));
    text_.remove_prefix(found.size());
    return found;
  }

  std::string_view rest() const { return text_; }

 private:
  static constexpr std::string_view blanks = " \t\r\n\v\f";
  std::string_view text_;
};

/// The number that a word is, to its last letter.
template <class Number>
std::optional<Number> number_in(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return number;
}

/// As a float, rounded as assimp rounds: the bits of built-in scenes, and of what was read before, rest on that.
std::optional<float> float_in(std::string_view word);

}  // namespace lockstep
