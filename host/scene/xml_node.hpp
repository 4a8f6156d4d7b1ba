// An XML document and its elements, read strictly. Every refusal is one line, "file:LINE: <element> attribute: rule, is
// VALUE".
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/exact_math.hpp"

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace lockstep {

class XmlDocument;

class XmlNode {
 public:
  XmlNode(const tinyxml2::XMLElement& element, const std::string& source) : element_(&element), source_(&source) {}

  /// "file:LINE: <element>".
  std::string location() const;
  /// Throws Error (input): `what` is said of this element, or of one of its attributes.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(const char* attribute, const std::string& what) const;
  /// Throws Error: "unknown `kind` WORD", with the nearest of `names`.
  [[noreturn]] void unknown(const char* attribute, const std::string& kind, std::vector<std::string> names) const;

  std::string name() const;
  /// The file that the document stands in.
  const std::string& source() const { return *source_; }

  /// Refuses attributes other than these.
  void expect_attributes(std::initializer_list<std::string_view> known) const;
  /// Refuses elements within it other than `known`; those of `ignored`, and those of other namespaces, are for other
  /// programs.
  void expect_children(std::initializer_list<std::string_view> known,
                       std::initializer_list<std::string_view> ignored = {}) const;

  /// The names of its attributes, as they stand.
  std::vector<std::string> attributes() const;
  /// All elements within it, or those of a name: in the place of an element that includes a document, those of that.
  std::vector<XmlNode> children(const char* name = nullptr) const;
  /// The one of this name; refuses two.
  std::optional<XmlNode> child(const char* name) const;
  XmlNode needed_child(const char* name) const;

  bool has(const char* attribute) const;
  std::string value(const char* attribute) const;  // as it stands
  std::string text(const char* attribute) const;   // UTF-8 of one line, not empty
  double number(const char* attribute) const;      // finite
  double positive(const char* attribute) const;    // > 0
  double not_negative(const char* attribute) const;
  Vector3 vector(const char* attribute) const;  // three numbers
  /// So many numbers, with spaces or a comma between each two.
  std::vector<double> numbers(const char* attribute, std::size_t least, std::size_t most) const;

 private:
  friend class XmlDocument;
  void add_children(const char* name, std::vector<XmlNode>& nodes) const;

  const tinyxml2::XMLElement* element_;
  const std::string* source_;
};

/// Holds what its nodes stand in.
class XmlDocument {
 public:
  /// Throws Error (input) where `text` is not XML. `source` stands for the file in errors.
  XmlDocument(const std::string& text, const std::string& source);
  ~XmlDocument();
  XmlDocument(const XmlDocument&) = delete;
  XmlDocument& operator=(const XmlDocument&) = delete;

  /// The first element. Refuses one of another name: `format` says what the file then is none of, "a URDF file".
  XmlNode top(const char* name, const char* format) const;

  /// What is in the first element of `other` stands where `at`, an element of this one or of what it includes, does.
  /// Returns that first element.
  XmlNode include(const XmlNode& at, std::unique_ptr<XmlDocument> other);

 private:
  std::unique_ptr<tinyxml2::XMLDocument> document_;
  const std::string source_;
  struct Included {
    std::unique_ptr<XmlDocument> document;
    std::unique_ptr<const XmlNode> first;  // its first element
  };
  std::vector<Included> included_;
};

}  // namespace lockstep
