#include "host/problems/lcp_text.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "host/error.hpp"

namespace lockstep {

namespace {

constexpr long most_unknowns = 10'000;  // a dense matrix of 800 MB

// Words of a text, each with the line that it stands in.
class Words {
 public:
  Words(const std::filesystem::path& path, std::string text) : path_(path.string()), text_(std::move(text)) {}

  long integer(const std::string& what) {
    const std::string_view word = next(what);
    long value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      refuse(what + ": not a whole number: " + std::string(word));
    return value;
  }

  double number(const std::string& what) {
    const std::string_view word = next(what);
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size())
      refuse(what + ": not a number: " + std::string(word));
    if (!std::isfinite(value)) refuse(what + ": must be finite, is " + std::string(word));
    return value;
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Failure::input, path_ + ":" + std::to_string(line_), what);
  }

 private:
  std::string_view next(const std::string& what) {
    const std::string_view blank = " \t\r\n";
    std::size_t begin = text_.find_first_not_of(blank, at_);
    if (begin == std::string::npos) refuse("the file ends where " + what + " should stand");
    for (std::size_t i = at_; i < begin; ++i) line_ += text_[i] == '\n';
    const std::size_t end = std::min(text_.find_first_of(blank, begin), text_.size());
    at_ = end;
    return std::string_view(text_).substr(begin, std::min<std::size_t>(end - begin, 40));
  }

  std::string path_, text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

}  // namespace

bool is_lcp_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  long unknowns = 0, storage = -1;
  return file >> unknowns >> storage && unknowns >= 0 && storage == 0;
}

oracle::lcp::Lcp read_lcp_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) throw Error(Failure::input, path.string(), "cannot be read");
  Words words(path, std::string(std::istreambuf_iterator<char>(file), {}));
  const long n = words.integer("the number of unknowns");
  if (n < 0 || n > most_unknowns) words.refuse("the number of unknowns must be 0 to 10000, is " + std::to_string(n));
  const long storage = words.integer("the storage of the matrix");
  if (storage != 0) words.refuse("only dense matrices (storage 0) are read, this is " + std::to_string(storage));
  for (const char* what : {"rows", "columns", "rows once more", "columns once more"}) {
    const long size = words.integer(std::string("the number of ") + what);
    if (size != n)
      words.refuse(std::string("the number of ") + what + " must be " + std::to_string(n) + ", is " +
                   std::to_string(size));
  }
  oracle::lcp::Lcp problem = {Eigen::MatrixXd(n, n), Eigen::VectorXd(n)};
  for (long j = 0; j < n; ++j) {
    for (long i = 0; i < n; ++i)
      problem.m(i, j) = words.number("M(" + std::to_string(i) + ", " + std::to_string(j) + ")");
  }
  for (long i = 0; i < n; ++i) problem.q[i] = words.number("q(" + std::to_string(i) + ")");
  return problem;
}

}  // namespace lockstep
