#include "host/scene/json_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "host/scene/renamed_keys.hpp"

namespace lockstep {

namespace {

using nlohmann::json;

constexpr std::size_t deepest = 64;
constexpr std::size_t longest_quote = 48, longest_message = 200;

// Names come from the file: keep a line a line, and short.
std::string shortened(std::string text, std::size_t longest) {
  if (text.size() > longest) text = text.substr(0, longest - 3) + "...";
  return text;
}

std::string described(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  return shortened(value.dump(-1, ' ', true), longest_quote);
}

// A step of a JSON pointer (RFC 6901): ~ and / are escaped.
std::string pointer_step(const std::string& key) {
  std::string step = "/";
  for (const char c : shortened(key, longest_quote)) {
    if (c == '~')
      step += "~0";
    else if (c == '/')
      step += "~1";
    else
      step += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return step;
}

std::string location(const std::string& source, const std::string& path) {
  return path.empty() ? source : source + ": " + path;
}

// Builds the document from the parser's events. The parser keeps its own stack, so depth costs no recursion; it is
// limited all the same, because what follows recurses.
class Builder : public nlohmann::json_sax<json> {
 public:
  explicit Builder(const std::string& source) : source_(source) {}

  json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t&) override { return false; }

  bool start_object(std::size_t) override { return open(json::object()); }
  bool start_array(std::size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    json& object = *open_.back().value;
    if (object.contains(name)) {
      throw Error(Failure::input, location(source_, path()),
                  fmt::format("key {} stands twice; remove one", quote(name)));
    }
    open_.back().key = name;
    return true;
  }

  bool parse_error(std::size_t, const std::string& token, const nlohmann::detail::exception& error) override {
    if (error.id == 406) {  // out of range
      throw Error(Failure::input, location(source_, here()),
                  "must fit a double, is " + shortened(token, longest_quote));
    }
    std::string what = error.what();  // "[json.exception...] parse error at line 1, column 2: ..."
    what = what.substr(what.find("line"));
    for (char& c : what) {
      if (c < 0x20 || c > 0x7e) c = '?';
    }
    throw Error(Failure::input, source_, shortened("not JSON: " + what, longest_message));
  }

 private:
  struct Open {
    json* value;
    std::string key;  // of an object: the key that was read last
  };

  std::string path(std::size_t levels) const {
    std::string path;
    for (std::size_t i = 0; i < levels; ++i) {
      const Open& level = open_[i];
      if (level.value->is_array()) {
        path += fmt::format("/{}", level.value->size() - (i + 1 < open_.size() ? 1 : 0));
      } else {
        path += pointer_step(level.key);
      }
    }
    return path;
  }
  // Of the innermost open container, and of the value that comes next.
  std::string path() const { return path(open_.size() - 1); }
  std::string here() const { return path(open_.size()); }

  json* put(json value) {
    if (open_.empty()) return &(root_ = std::move(value));
    json& parent = *open_.back().value;
    if (parent.is_object()) return &(parent[open_.back().key] = std::move(value));
    parent.push_back(std::move(value));
    return &parent.back();
  }

  bool open(json container) {
    if (open_.size() == deepest) {
      throw Error(Failure::input, source_, fmt::format("nested deeper than {} levels; no scene needs that", deepest));
    }
    json* value = put(std::move(container));
    open_.push_back({value, ""});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  const std::string& source_;
  json root_;
  std::vector<Open> open_;
};

// Levenshtein's distance: insertions, deletions and replacements from a to b.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

json parse_json(const std::string& text, const std::string& source) {
  Builder builder(source);
  json::sax_parse(text, &builder);
  return builder.take();
}

std::string quote(const std::string& text) {
  // escapes all but printable ASCII, and shows what is no text at all as such
  return shortened(json(text).dump(-1, ' ', true, json::error_handler_t::replace), longest_quote);
}

std::string suggestion(const std::string& unknown, const std::vector<std::string>& names) {
  if (names.empty()) return "there are none";
  const std::string word = shortened(unknown, longest_quote);
  const auto nearest = std::min_element(
      names.begin(), names.end(), [&](const auto& a, const auto& b) { return distance(word, a) < distance(word, b); });
  const std::size_t near = std::max<std::size_t>(2, nearest->size() / 3);
  if (distance(word, *nearest) <= near) return fmt::format("did you mean \"{}\"?", *nearest);
  std::string known = "known: " + names[0];
  for (std::size_t i = 1; i < names.size(); ++i) known += ", " + names[i];
  return known;
}

void JsonNode::fail(const std::string& what) const { throw Error(Failure::input, location(*source_, path_), what); }

void JsonNode::must_be(const std::string& rule) const { fail("must be " + rule + ", is " + described(*value_)); }

void JsonNode::unknown(const std::string& kind, const std::string& word, const std::vector<std::string>& names) const {
  fail(fmt::format("unknown {} {}; {}", kind, quote(word), suggestion(word, names)));
}

void JsonNode::expect_object(std::span<const std::string_view> known_keys) const {
  if (!value_->is_object()) must_be("an object");
  for (const auto& item : value_->items()) {
    if (std::find(known_keys.begin(), known_keys.end(), item.key()) != known_keys.end()) continue;
    const auto renamed = std::ranges::find_if(known_keys, [&](std::string_view key) {
      const char* old = old_key(key);
      return old != nullptr && item.key() == old;
    });
    if (renamed != known_keys.end()) {
      if (value_->contains(*renamed))
        fail(fmt::format("has the key \"{}\" by its old name too, \"{}\"; remove that", *renamed, item.key()));
      continue;
    }
    const std::vector<std::string> names(known_keys.begin(), known_keys.end());
    unknown("key", item.key(), names);
  }
}

const char* JsonNode::name_of(const char* key) const {
  if (value_->contains(key)) return key;
  const char* old = old_key(key);
  return old != nullptr && value_->contains(old) ? old : nullptr;
}

JsonNode JsonNode::at(const char* key) const {
  const char* name = name_of(key);
  if (name == nullptr) fail(fmt::format("needs the key \"{}\"", key));
  return {value_->at(name), *source_, path_ + pointer_step(name)};
}

std::vector<JsonNode> JsonNode::elements() const {
  if (!value_->is_array()) must_be("an array");
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < value_->size(); ++i)
    nodes.emplace_back((*value_)[i], *source_, fmt::format("{}/{}", path_, i));
  return nodes;
}

double JsonNode::number() const {
  if (!value_->is_number()) must_be("a number");
  return value_->get<double>();
}

double JsonNode::positive() const {
  const double x = number();
  if (!(x > 0)) must_be("> 0");
  return x;
}

double JsonNode::not_negative() const {
  const double x = number();
  if (!(x >= 0)) must_be(">= 0");
  return x;
}

double JsonNode::fraction() const {
  const double x = number();
  if (!(x >= 0 && x <= 1)) must_be("in 0 .. 1");
  return x;
}

u32 JsonNode::integer(u32 least, u32 most) const {
  const bool fits =
      value_->is_number_unsigned() && value_->get<std::uint64_t>() >= least && value_->get<std::uint64_t>() <= most;
  if (!fits) must_be(fmt::format("an integer in {} .. {}", least, most));
  return value_->get<u32>();
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) must_be("true or false");
  return value_->get<bool>();
}

std::string JsonNode::text() const {
  if (!value_->is_string() || value_->get_ref<const std::string&>().empty()) must_be("a text, and not empty");
  return value_->get<std::string>();
}

Vector3 JsonNode::vector() const {
  if (!value_->is_array() || value_->size() != 3) must_be("an array of 3 numbers");
  Vector3 v;
  for (std::size_t i = 0; i < 3; ++i) v[i] = JsonNode((*value_)[i], *source_, fmt::format("{}/{}", path_, i)).number();
  return v;
}

}  // namespace lockstep
