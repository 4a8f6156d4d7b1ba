// The words of a text between blanks, read as numbers: what the formats of problems in text have in common.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace lockstep {

/// Reads one word after another. Complaints are Error (input), "path: line N: place: what is wrong".
class NumberText {
 public:
  /// Both are kept by reference.
  NumberText(const std::string& path, std::string_view text) : path_(path), text_(text) {}

  /// A whole number from `least` to `most`.
  long long count(const std::string& label, long long least, long long most);

  /// A finite number; what is too small for a double counts as zero.
  double number(const std::string& label);

  /// `size` of them.
  Eigen::VectorXd vector(const std::string& label, long long size);

  /// Refused where what is left is too short to hold so many numbers.
  void expect_room(const std::string& label, long long size) const;

  /// Whether a word follows.
  bool more();

  /// How many words follow.
  long long words_left() const;

  /// The next word as it is.
  std::string_view word(const std::string& label) { return next(label); }

  /// The first letter of the next word, or 0.
  char next_character();

  /// Refused where the next word is another one than this.
  void expect_word(std::string_view expected, const std::string& label);

  /// Leaves out the rest of the line.
  void skip_line();

  [[noreturn]] void refuse(const std::string& label, const std::string& what) const;

 private:
  void skip();
  std::string_view next(const std::string& label);

  const std::string& path_;
  const std::string_view text_;
  std::size_t at_ = 0;
  long long line_ = 1;
};

}  // namespace lockstep
