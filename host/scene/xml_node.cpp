#include "host/scene/xml_node.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

bool is_among(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string nearest(std::string_view word, std::initializer_list<std::string_view> known) {
  return suggestion(std::string(word), std::vector<std::string>(known.begin(), known.end()));
}

// Names come from the file: keep a line a line, and short.
std::string in_brackets(std::string_view name) {
  const std::string quoted = quote(std::string(name));
  return fmt::format("<{}>", std::string_view(quoted).substr(1, quoted.size() - 2));
}

bool is_utf8(const std::string& words) {
  try {
    static_cast<void>(nlohmann::json(words).dump());
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

}  // namespace

std::string XmlNode::location() const {
  return fmt::format("{}:{}: {}", *source_, element_->GetLineNum(), in_brackets(element_->Name()));
}

void XmlNode::fail(const std::string& what) const { throw Error(Failure::input, location(), what); }

void XmlNode::fail(const char* attribute, const std::string& what) const {
  throw Error(Failure::input, location() + " " + attribute, what);
}

void XmlNode::unknown(const char* attribute, const std::string& kind, std::vector<std::string> names) const {
  constexpr std::size_t most = 64;  // of a large robot
  const std::string word = text(attribute);
  if (names.size() > most) names.resize(most);
  fail(attribute, fmt::format("unknown {} {}; {}", kind, quote(word), suggestion(word, names)));
}

std::string XmlNode::name() const { return element_->Name(); }

void XmlNode::expect_attributes(std::initializer_list<std::string_view> known) const {
  for (const auto* a = element_->FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string_view word = a->Name();
    if (!is_among(word, known) && word.find(':') == word.npos && word != "xmlns")
      fail(fmt::format("unknown attribute {}; {}", quote(a->Name()), nearest(word, known)));
  }
}

void XmlNode::expect_children(std::initializer_list<std::string_view> known,
                              std::initializer_list<std::string_view> ignored) const {
  for (const auto* e = element_->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string_view word = e->Name();
    if (word.starts_with("xacro:")) XmlNode(*e, *source_).fail("is to be expanded first: xacro x.urdf.xacro > x.urdf");
    if (!is_among(word, known) && !is_among(word, ignored) && word.find(':') == word.npos)
      XmlNode(*e, *source_)
          .fail(fmt::format("is no element of {}; {}", in_brackets(element_->Name()), nearest(word, known)));
  }
}

std::vector<std::string> XmlNode::attributes() const {
  std::vector<std::string> names;
  for (const auto* a = element_->FirstAttribute(); a != nullptr; a = a->Next()) names.emplace_back(a->Name());
  return names;
}

void XmlNode::add_children(const char* name, std::vector<XmlNode>& nodes) const {
  for (const auto* e = element_->FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (e->GetUserData() != nullptr)
      static_cast<const XmlNode*>(e->GetUserData())->add_children(name, nodes);
    else if (name == nullptr || std::string_view(name) == e->Name())
      nodes.emplace_back(*e, *source_);
  }
}

std::vector<XmlNode> XmlNode::children(const char* name) const {
  std::vector<XmlNode> nodes;
  add_children(name, nodes);
  return nodes;
}

std::optional<XmlNode> XmlNode::child(const char* name) const {
  const std::vector<XmlNode> found = children(name);
  if (found.empty()) return std::nullopt;
  if (found.size() > 1) found[1].fail(fmt::format("stands twice in {}; remove one", in_brackets(element_->Name())));
  return found[0];
}

XmlNode XmlNode::needed_child(const char* name) const {
  const std::optional<XmlNode> found = child(name);
  if (!found) fail(fmt::format("needs the element <{}>", name));
  return *found;
}

bool XmlNode::has(const char* attribute) const { return element_->Attribute(attribute) != nullptr; }

std::string XmlNode::value(const char* attribute) const {
  const char* words = element_->Attribute(attribute);
  if (words == nullptr) fail(fmt::format("needs the attribute {}", quote(attribute)));
  return words;
}

std::string XmlNode::text(const char* attribute) const {
  std::string words = value(attribute);
  if (words.empty()) fail(attribute, "must not be empty");
  const bool one_line = std::none_of(words.begin(), words.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (!one_line || !is_utf8(words))
    fail(attribute, fmt::format("must be a text of one line in UTF-8, is {}", quote(words)));
  return words;
}

// The nearest doubles, whatever the locale.
std::vector<double> XmlNode::numbers(const char* attribute, std::size_t least, std::size_t most) const {
  const std::string words = value(attribute);
  const char *at = words.data(), *end = at + words.size();
  const auto skip_spaces = [&] {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
  };
  std::vector<double> values;
  bool good = true;
  const auto skip_separator = [&] {
    skip_spaces();
    if (!good || at == end || *at != ',') return;
    ++at;
    skip_spaces();
    good = at != end;
  };
  for (skip_spaces(); at != end && good; skip_separator()) {
    if (*at == '+') ++at;
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    good = error == std::errc() && std::isfinite(value) && values.size() < most;
    at = next;
    values.push_back(value);
  }
  if (good && values.size() >= least) return values;
  const std::string count = least == most    ? fmt::format("{}", most)
                            : most > 1000000 ? fmt::format("{} or more", least)
                                             : fmt::format("{} to {}", least, most);
  fail(attribute,
       fmt::format("must be {}, is {}", most == 1 ? "a finite number" : count + " finite numbers", quote(words)));
}

double XmlNode::number(const char* attribute) const { return numbers(attribute, 1, 1)[0]; }

double XmlNode::positive(const char* attribute) const {
  const double x = number(attribute);
  if (!(x > 0)) fail(attribute, fmt::format("must be > 0, is {}", x));
  return x;
}

double XmlNode::not_negative(const char* attribute) const {
  const double x = number(attribute);
  if (!(x >= 0)) fail(attribute, fmt::format("must be >= 0, is {}", x));
  return x;
}

Vector3 XmlNode::vector(const char* attribute) const {
  const std::vector<double> v = numbers(attribute, 3, 3);
  return {v[0], v[1], v[2]};
}

XmlDocument::XmlDocument(const std::string& text, const std::string& source)
    : document_(std::make_unique<tinyxml2::XMLDocument>()), source_(source) {
  if (document_->Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw Error(Failure::input, fmt::format("{}:{}", source, document_->ErrorLineNum()),
                fmt::format("not XML: {}", document_->ErrorName()));
}

XmlDocument::~XmlDocument() = default;

XmlNode XmlDocument::include(const XmlNode& at, std::unique_ptr<XmlDocument> other) {
  const tinyxml2::XMLElement* element = other->document_->RootElement();
  if (element == nullptr) at.fail("file", "names a file that holds no element");
  included_.push_back({std::move(other), {}});
  Included& last = included_.back();
  last.first = std::make_unique<const XmlNode>(*element, last.document->source_);
  // the elements are those of its own documents
  const_cast<tinyxml2::XMLElement*>(at.element_)->SetUserData(const_cast<XmlNode*>(last.first.get()));
  return *last.first;
}

XmlNode XmlDocument::top(const char* name, const char* format) const {
  const tinyxml2::XMLElement* element = document_->RootElement();
  if (element == nullptr)
    throw Error(Failure::input, source_, fmt::format("holds no element; {} begins with <{}>", format, name));
  const XmlNode node(*element, source_);
  if (node.name() != name) node.fail(fmt::format("is no <{}>, as the first element of {} must be", name, format));
  return node;
}

}  // namespace lockstep
