#include "host/problems/number_text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "host/problems/formats.hpp"

namespace lockstep {

namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

}  // namespace

long long NumberText::count(const std::string& label, long long least, long long most) {
  const std::string_view word = next(label);
  long long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc() && end == word.data() + word.size() && value >= least && value <= most) return value;
  const std::string range =
      least == most ? fmt::format("{}", least) : fmt::format("a whole number from {} to {}", least, most);
  refuse(label, fmt::format("must be {}, is '{}'", range, word.substr(0, 40)));
}

double NumberText::number(const std::string& label) {
  std::string_view word = next(label);
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = end == word.data() + word.size() && !word.empty();
  if (error == std::errc::result_out_of_range && whole && word.find("e-") != word.npos) return 0;
  if (error != std::errc() || !whole || !std::isfinite(value))
    refuse(label, fmt::format("must be a finite number, is '{}'; write the file anew", word.substr(0, 40)));
  return value;
}

Eigen::VectorXd NumberText::vector(const std::string& label, long long size) {
  expect_room(label, size);
  Eigen::VectorXd values(size);
  for (double& value : values) value = number(label);
  return values;
}

void NumberText::expect_room(const std::string& label, long long size) const {
  if (static_cast<unsigned long long>(size) > text_.size() - at_)
    refuse(label, fmt::format("{} numbers are announced, the file is too short for them", size));
}

bool NumberText::more() {
  skip();
  return at_ < text_.size();
}

long long NumberText::words_left() const {
  long long words = 0;
  for (std::size_t i = at_; i < text_.size(); ++i) words += !blank(text_[i]) && (i == at_ || blank(text_[i - 1]));
  return words;
}

char NumberText::next_character() {
  skip();
  return at_ < text_.size() ? text_[at_] : '\0';
}

void NumberText::expect_word(std::string_view expected, const std::string& label) {
  const std::string_view found = next(label);
  if (found != expected) refuse(label, fmt::format("must be '{}', is '{}'", expected, found.substr(0, 40)));
}

void NumberText::skip_line() {
  while (at_ < text_.size() && text_[at_] != '\n') ++at_;
}

void NumberText::refuse(const std::string& label, const std::string& what) const {
  refuse_problem(path_, fmt::format("line {}: {}", line_, label), what);
}

void NumberText::skip() {
  for (; at_ < text_.size() && blank(text_[at_]); ++at_) line_ += text_[at_] == '\n';
}

std::string_view NumberText::next(const std::string& label) {
  skip();
  if (at_ == text_.size()) refuse(label, "the file ends here; it may be cut short");
  const std::size_t start = at_;
  while (at_ < text_.size() && !blank(text_[at_])) ++at_;
  return text_.substr(start, at_ - start);
}

}  // namespace lockstep
