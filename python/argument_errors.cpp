#include "python/argument_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <regex>

#include "host/scene/json_node.hpp"

namespace lockstep::python {

namespace {

constexpr std::size_t longest_line = 300, longest_value = 60;

std::string cut(std::string text, std::size_t most) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20; }, ' ');
  if (text.size() <= most) return text;
  text.resize(most - 3);
  while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) text.pop_back();
  if (!text.empty() && static_cast<unsigned char>(text.back()) >= 0xc0) text.pop_back();
  return text + "...";
}

std::string shown(const py::handle& value) {
  if (value.is_none()) return "None";
  const std::string type = py::str(py::type::handle_of(value).attr("__name__"));
  std::string text;
  try {
    text = py::repr(value).cast<std::string>();
  } catch (py::error_already_set&) {
  } catch (const py::cast_error&) {
  }
  return text.empty() || text.starts_with('<') ? "a " + type : fmt::format("{} ({})", cut(text, longest_value), type);
}

// One of a call's, as its signature has it: `count: int = 1`.
struct Argument {
  std::string name, type;
  bool is_optional = false;
};

struct Signature {
  std::vector<Argument> arguments;
  std::size_t by_position = 0;  // so many of them need no name
};

// At commas that are in no bracket and no text.
std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> pieces(1);
  int depth = 0;
  char quote = 0;
  for (const char c : list) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '[' || c == '(' || c == '{') {
      ++depth;
    } else if (c == ']' || c == ')' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      pieces.emplace_back();
      continue;
    }
    pieces.back() += c;
  }
  return pieces;
}

Signature signature_of(const std::string& line) {
  Signature signature;
  bool is_named = false;
  for (std::string piece : split(line)) {
    piece.erase(0, piece.find_first_not_of(' '));
    if (piece.empty() || piece == "/") continue;
    if (piece.starts_with('*')) {
      is_named = true;
      continue;
    }
    const std::size_t colon = piece.find(": "), sign = piece.find(" = ");
    Argument argument;
    argument.name = piece.substr(0, colon);
    if (colon != piece.npos) argument.type = piece.substr(colon + 2, sign == piece.npos ? sign : sign - colon - 2);
    argument.is_optional = sign != piece.npos;
    signature.by_position += !is_named;
    signature.arguments.push_back(argument);
  }
  return signature;
}

// Signatures in pybind11's message: "    1. (self: lockstep.World, count: int = 1) -> None".
std::vector<Signature> signatures_in(const std::string& message) {
  std::vector<Signature> signatures;
  const std::regex line(R"(\n\s+\d+\. [^(\n]*\(([^\n]*)\)(?: -> [^\n]*)?(?=\n|$))");
  for (std::sregex_iterator i(message.begin(), message.end(), line), end; i != end; ++i)
    signatures.push_back(signature_of((*i)[1]));
  return signatures;
}

// pybind11's names of types, and what they are called here.
constexpr std::pair<std::string_view, std::string_view> type_words[] = {
    {"int", "a whole number from 0 on"},
    {"float", "a number"},
    {"str", "a str"},
    {"bool", "True or False"},
    {"function", "a function"},
    {"os.PathLike", "a path"},
    {"List[str]", "a list of str"},
    {"List[float]", "a list of numbers"},
    {"Dict[str, str]", "a dict of str"},
    {"dict", "a dict"},
    {"list", "a list"},
    {"List[List[float[6]]]", "a list of 6 numbers each"},
};

std::string in_words(const std::string& type) {
  for (const auto& [name, words] : type_words)
    if (type == name) return std::string(words);
  std::smatch parsed;
  if (std::regex_match(type, parsed, std::regex(R"(.*List\[float\[?(\d+)\]?\])"))) return parsed.str(1) + " numbers";
  if (std::regex_match(type, parsed, std::regex(R"(Annotated\[List\[float\], FixedSize\((\d+)\)\])")))
    return parsed.str(1) + " numbers";
  if (std::regex_match(type, parsed, std::regex(R"(Optional\[(.*)\])"))) return in_words(parsed[1]) + ", or None";
  if (std::regex_match(type, parsed, std::regex(R"(Union\[(.*)\])"))) {
    std::string all;
    for (std::string each : split(parsed[1])) {
      each.erase(0, each.find_first_not_of(' '));
      all += (all.empty() ? "" : " or ") + in_words(each);
    }
    return all;
  }
  if (type.starts_with("numpy.ndarray")) return "an array of numbers";
  return "a " + type;
}

// Whether a value is surely not of a type; what is not known may be.
bool is_surely_not(const std::string& type, const py::handle& value) {
  const auto is_number = [&] {
    return PyFloat_Check(value.ptr()) || PyIndex_Check(value.ptr()) || py::hasattr(value, "__float__");
  };
  std::smatch parsed;
  if (std::regex_match(type, parsed, std::regex(R"(Optional\[(.*)\])")))
    return !value.is_none() && is_surely_not(parsed[1], value);
  if (type == "str") return !py::isinstance<py::str>(value) && !py::isinstance<py::bytes>(value);
  if (type == "bool") return !py::isinstance<py::bool_>(value);
  if (type == "float") return !is_number();
  if (type == "int") {
    if (PyFloat_Check(value.ptr()) || !PyIndex_Check(value.ptr())) return true;
    const py::object number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    return number < py::int_(0) || number > py::int_(0xffffffffu);
  }
  if (std::regex_match(type, parsed, std::regex(R"(.*List\[float(?:\[|\], FixedSize\()(\d+).*)"))) {
    if (!PySequence_Check(value.ptr()) || py::isinstance<py::str>(value)) return true;
    const py::ssize_t size = PySequence_Size(value.ptr());
    if (size < 0) PyErr_Clear();
    if (size != std::stol(parsed[1])) return true;
    for (const py::handle& each : py::reinterpret_borrow<py::sequence>(value))
      if (is_surely_not("float", each)) return true;
    return false;
  }
  if (type.starts_with("lockstep.")) {
    const py::object wanted = py::module_::import("lockstep").attr(type.substr(9).c_str());
    return PyObject_IsInstance(value.ptr(), wanted.ptr()) == 0;
  }
  const bool is_text = py::isinstance<py::str>(value);
  if (type == "function") return PyCallable_Check(value.ptr()) == 0;
  if (type.starts_with("Dict")) return !py::isinstance<py::dict>(value);
  if (type.starts_with("List") || type == "list") return is_text || PySequence_Check(value.ptr()) == 0;
  if (type == "os.PathLike") return !is_text && !py::isinstance<py::bytes>(value) && !py::hasattr(value, "__fspath__");
  if (type.starts_with("numpy.ndarray")) return is_text || py::isinstance<py::dict>(value);
  return false;
}

std::string in_words(const Argument& argument) {
  return argument.type == "object" ? argument.name : fmt::format("{}: {}", argument.name, in_words(argument.type));
}

// Those that are needed, and those that are given.
std::string list_of_arguments(const Signature& signature, const py::tuple& given, const py::dict& named) {
  std::string all;
  for (std::size_t i = 0; i < signature.arguments.size(); ++i) {
    const Argument& argument = signature.arguments[i];
    if (argument.is_optional && i >= given.size() && !named.contains(argument.name.c_str())) continue;
    all += (all.empty() ? "" : ", ") + in_words(argument);
  }
  return all.empty() ? "no argument" : all;
}

// What is wrong by a signature; empty: nothing that is seen.
std::string flaw_of_call(const Signature& signature, const py::tuple& given, const py::dict& named) {
  const std::vector<Argument>& arguments = signature.arguments;
  if (const std::size_t most = signature.by_position; given.size() > most)
    return fmt::format("takes at most {} argument{} without a name, is given {}", most, most == 1 ? "" : "s",
                       given.size());
  std::vector<std::string> names;
  for (const Argument& argument : arguments) names.push_back(argument.name);
  for (const auto& [key, value] : named) {
    const std::string name = py::str(key);
    if (std::ranges::find(names, name) == names.end())
      return fmt::format("has no argument {}; {}", quote(name), suggestion(name, names));
  }
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const Argument& argument = arguments[i];
    const bool is_named = named.contains(argument.name.c_str());
    if (i < given.size() && is_named) return fmt::format("is given {} twice", argument.name);
    if (i >= given.size() && !is_named) {
      if (argument.is_optional) continue;
      return fmt::format("needs {}", in_words(argument));
    }
    const py::object value = is_named ? py::object(named[argument.name.c_str()]) : py::object(given[i]);
    if (is_surely_not(argument.type, value))
      return fmt::format("{} must be {}, is {}", argument.name, in_words(argument.type), shown(value));
  }
  return "";
}

py::tuple without_first(const py::tuple& all) {
  py::tuple rest(all.size() - 1);
  for (std::size_t i = 1; i < all.size(); ++i) rest[i - 1] = all[i];
  return rest;
}

std::string one_line(const std::string& message, const py::tuple& arguments, const py::dict& named) {
  const std::string function = message.substr(0, message.find("():"));
  std::vector<Signature> signatures = signatures_in(message);
  std::string name = function;
  py::tuple given = arguments;
  const bool makes = function == "__init__";  // whose signatures begin after self
  const bool has_self =
      !makes && !signatures.empty() && !signatures[0].arguments.empty() && signatures[0].arguments[0].name == "self";
  if ((makes || has_self) && arguments.size() > 0) {
    const std::string type = py::str(py::type::handle_of(arguments[0]).attr("__name__"));
    name = makes ? type : type + "." + function;
    given = without_first(arguments);
  }
  for (Signature& signature : signatures) {
    if (!has_self || signature.arguments.empty()) continue;
    signature.arguments.erase(signature.arguments.begin());
    --signature.by_position;
  }
  std::string what;
  if (signatures.size() == 1) what = flaw_of_call(signatures[0], given, named);
  if (what.empty()) {
    what = "takes (";
    for (std::size_t i = 0; i < signatures.size(); ++i)
      what += (i == 0 ? "" : ") or (") + list_of_arguments(signatures[i], given, named);
    std::string all;
    for (const py::handle& value : given) all += (all.empty() ? "" : ", ") + shown(value);
    for (const auto& [key, value] : named)
      all += fmt::format("{}{} = {}", all.empty() ? "" : ", ", py::str(key).cast<std::string>(), shown(value));
    what += "), is given " + (all.empty() ? "nothing" : all);
  }
  return cut(fmt::format("{}(): {}", name, what), longest_line);
}

// pybind11's function for all calls, which each of them has in its definition.
PyCFunctionWithKeywords dispatch = nullptr;

PyObject* call(PyObject* self, PyObject* given, PyObject* named) {
  PyObject* result = dispatch(self, given, named);
  if (result != nullptr || PyErr_ExceptionMatches(PyExc_TypeError) == 0) return result;
  py::error_already_set error;
  const std::string message = py::str(error.value());
  if (message.find("(): incompatible ") == message.npos) {
    error.restore();
    return nullptr;
  }
  try {
    const py::dict names = named == nullptr ? py::dict() : py::reinterpret_borrow<py::dict>(named);
    PyErr_SetString(PyExc_TypeError, one_line(message, py::reinterpret_borrow<py::tuple>(given), names).c_str());
  } catch (const std::exception&) {
    PyErr_Clear();
    error.restore();
  }
  return nullptr;
}

void replace_in(const py::handle& item) {
  PyObject* function = item.ptr();
  if (PyInstanceMethod_Check(function)) function = PyInstanceMethod_GET_FUNCTION(function);
  if (Py_TYPE(function) == &PyStaticMethod_Type || std::string_view(Py_TYPE(function)->tp_name) == "staticmethod") {
    replace_in(py::handle(function).attr("__func__"));
    return;
  }
  if (!PyCFunction_Check(function)) return;
  PyMethodDef* definition = reinterpret_cast<PyCFunctionObject*>(function)->m_ml;
  const auto method = reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(definition->ml_meth));
  if (definition->ml_flags != (METH_VARARGS | METH_KEYWORDS) || method == call) return;
  dispatch = method;
  definition->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call));
}

}  // namespace

void tell_argument_errors_in_one_line(py::module_& module) {
  for (const auto& [name, item] : py::reinterpret_borrow<py::dict>(module.attr("__dict__"))) {
    replace_in(item);
    if (!PyType_Check(item.ptr())) continue;
    for (const auto& [member, value] : py::dict(item.attr("__dict__"))) replace_in(value);
  }
}

}  // namespace lockstep::python
