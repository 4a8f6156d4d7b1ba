#include "host/device/kernel_source.hpp"

#include <algorithm>
#include <unordered_map>

#include "host/embedded.hpp"
#include "host/error.hpp"

namespace lockstep {

namespace {

constexpr std::string_view folder = "kernels/";

bool ends_with_cl(std::string_view name) { return name.ends_with(".cl"); }
std::string_view stem(std::string_view name) { return name.substr(0, name.rfind('.')); }

bool is_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

// The name in `#include "name"`, nothing for any other line.
std::optional<std::string_view> included_name(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  if (!line.starts_with("#include")) return std::nullopt;
  const auto open = line.find('"'), close = line.rfind('"');
  if (open == std::string_view::npos || close == open) return std::nullopt;
  return line.substr(open + 1, close - open - 1);
}

// Comments become blanks, so that positions and words stay apart.
std::string without_comments(std::string text) {
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] != '/' || (text[i + 1] != '/' && text[i + 1] != '*')) continue;
    const bool line = text[i + 1] == '/';
    const auto end = line ? text.find('\n', i) : text.find("*/", i + 2);
    const auto stop = end == std::string::npos ? text.size() : line ? end : end + 2;
    std::fill(text.begin() + static_cast<std::ptrdiff_t>(i), text.begin() + static_cast<std::ptrdiff_t>(stop), ' ');
    i = stop - 1;
  }
  return text;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && is_word(text[end])) ++end;
    if (end > i)
      words.push_back(text.substr(i, end - i));
    else
      ++end;
    i = end;
  }
  return words;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\n";
  const auto first = std::min(text.find_first_not_of(blanks), text.size());
  return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

KernelParameter parse_parameter(std::string_view text, std::string_view file, std::string_view kernel) {
  using Kind = KernelParameter::Kind;
  const auto words = words_of(text);
  const auto has_word = [&](std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  const auto refuse = [&] {
    return Error(Failure::input, std::string(folder) + std::string(file),
                 std::string(kernel) + ": cannot bind the parameter '" + std::string(text) +
                     "': must be a global or constant pointer, 'const StepParams params' or a u32");
  };
  if (words.empty()) throw refuse();
  const std::string name(words.back());
  const std::string type(trimmed(text.substr(0, static_cast<std::size_t>(words.back().data() - text.data()))));
  const bool pointer = text.find('*') != std::string_view::npos;
  if (pointer) {
    const auto before_star = words_of(text.substr(0, text.find('*')));
    const bool constant = std::find(before_star.begin(), before_star.end(), "const") != before_star.end() ||
                          has_word("constant") || has_word("__constant");
    if (!constant && !has_word("global") && !has_word("__global")) throw refuse();
    return {name, type, constant ? Kind::read : Kind::written};
  }
  if (has_word("StepParams")) return {name, type, Kind::params};
  if (has_word("u32") || has_word("uint")) return {name, type, Kind::value};
  throw refuse();
}

// The position behind "kernel void NAME(" from `start` on, with NAME.
struct Head {
  std::size_t body;
  std::string_view name;
};
std::optional<Head> next_kernel(std::string_view text, std::size_t start) {
  for (auto at = text.find("kernel", start); at != std::string_view::npos; at = text.find("kernel", at + 1)) {
    const auto open = text.find('(', at);
    if (open == std::string_view::npos) return std::nullopt;
    const auto words = words_of(text.substr(at, open - at));
    if (words.size() == 3 && words[0] == "kernel" && words[1] == "void" &&
        (at == 0 || text[at - 1] == '_' || !is_word(text[at - 1])))
      return Head{open + 1, words[2]};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Stage> stage_named(std::string_view name) {
  for (u32 i = 0; i < stage_count; ++i)
    if (info(static_cast<Stage>(i)).name == name) return static_cast<Stage>(i);
  return std::nullopt;
}

std::optional<Buffer> buffer_named(std::string_view name) {
  static const auto by_name = [] {
    std::unordered_map<std::string_view, Buffer> all;
    for (u32 i = 0; i < buffer_count; ++i) all.emplace(info(static_cast<Buffer>(i)).name, static_cast<Buffer>(i));
    return all;
  }();
  const auto found = by_name.find(name);
  return found == by_name.end() ? std::nullopt : std::optional(found->second);
}

KernelSources::KernelSources(std::vector<KernelFile> files) : files_(std::move(files)) {}

KernelSources KernelSources::embedded(std::span<const KernelPatch> patches) {
  std::vector<KernelFile> files;
  for (const EmbeddedFile& file : embedded_kernels())
    files.push_back({std::string(file.name.substr(folder.size())), std::string(file.text)});
  for (const KernelPatch& patch : patches) {
    const auto file =
        std::find_if(files.begin(), files.end(), [&](const KernelFile& f) { return f.name == patch.file; });
    const auto at = file == files.end() ? std::string::npos : file->text.find(patch.from);
    if (at == std::string::npos)
      throw Error(Failure::input, std::string(folder) + patch.file, "holds no '" + patch.from + "' to patch");
    file->text.replace(at, patch.from.size(), patch.to);
  }
  return KernelSources(std::move(files));
}

const KernelFile& KernelSources::file(std::string_view name) const {
  for (const KernelFile& file : files_)
    if (file.name == name) return file;
  throw Error(Failure::input, std::string(folder) + std::string(name), "there is no such kernel file");
}

bool KernelSources::contains(std::string_view name) const {
  return std::any_of(files_.begin(), files_.end(), [&](const KernelFile& f) { return f.name == name; });
}

std::vector<std::string> KernelSources::kernel_files() const {
  std::vector<std::string> names;
  for (const KernelFile& file : files_)
    if (ends_with_cl(file.name)) names.push_back(file.name);
  std::sort(names.begin(), names.end());
  return names;
}

void KernelSources::append(std::string& out, const KernelFile& source, std::vector<std::string_view>& included) const {
  const auto mark_line = [&](std::size_t line) {
    out += "#line " + std::to_string(line) + " \"" + std::string(folder) + source.name + "\"\n";
  };
  included.push_back(source.name);
  mark_line(1);
  std::size_t number = 1;
  for (std::string_view rest = source.text; !rest.empty(); ++number) {
    const auto end = std::min(rest.find('\n'), rest.size() - 1) + 1;
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end);
    const auto name = included_name(line);
    if (!name) {
      out += line;
      continue;
    }
    const bool table = name->ends_with(".def");  // read again by each macro that wants it
    if (table || std::find(included.begin(), included.end(), *name) == included.end())
      append(out, file(*name), included);
    mark_line(number + 1);
  }
  if (!out.ends_with('\n')) out += '\n';
}

std::string KernelSources::assemble(std::span<const std::string> names) const {
  std::string out;
  std::vector<std::string_view> included;
  for (const std::string& name : names)
    if (std::find(included.begin(), included.end(), name) == included.end()) append(out, file(name), included);
  return out;
}

std::vector<KernelSignature> KernelSources::signatures(std::span<const std::string> names) const {
  std::vector<KernelSignature> found;
  for (const std::string& name : names) {
    const std::string text = without_comments(file(name).text);
    for (auto head = next_kernel(text, 0); head; head = next_kernel(text, head->body)) {
      KernelSignature signature = {std::string(head->name), name, {}};
      const auto close = std::min(text.find(')', head->body), text.size());
      std::string_view list = std::string_view(text).substr(head->body, close - head->body);
      while (!words_of(list).empty()) {
        const auto comma = std::min(list.find(','), list.size());
        signature.parameters.push_back(parse_parameter(list.substr(0, comma), name, signature.name));
        list.remove_prefix(std::min(comma + 1, list.size()));
      }
      found.push_back(std::move(signature));
    }
  }
  return found;
}

namespace {

// A file that is no stage of its own belongs to those who launch its kernels.
bool is_wanted_helper(std::string_view name, Features features) {
  if (name == "scan.cl") return has(features, Feature::contacts) || has(features, Feature::particles);
  if (name == "radix_sort.cl") return has(features, Feature::bvh) || has(features, Feature::particles);
  if (name == "solve_by_gradient.cl") return has(features, Feature::gradient);
  if (name == "solve_dense.cl") return has(features, Feature::dense);
  if (name == "average_body_copies.cl") return has(features, Feature::jacobi);
  return false;  // the canary has a program of its own
}

}  // namespace

std::vector<std::string> stage_files(const KernelSources& sources, Features features, std::span<const Stage> only) {
  std::vector<std::string> names;
  for (const std::string& name : sources.kernel_files()) {
    const auto stage = stage_named(stem(name));
    const bool wanted = stage && (only.empty() || std::find(only.begin(), only.end(), *stage) != only.end());
    if ((wanted && runs(*stage, features)) || (!stage && is_wanted_helper(name, features))) names.push_back(name);
  }
  return names;
}

void check_access(Stage stage, const KernelSignature& kernel, const KernelParameter& parameter, Buffer buffer) {
  const StageInfo& stage_info = info(stage);
  const auto in = [&](std::span<const Buffer> list) {
    return std::find(list.begin(), list.end(), buffer) != list.end();
  };
  const bool writes = parameter.kind == KernelParameter::Kind::written;
  if (buffer == Buffer::counters || in(stage_info.writes) || (!writes && in(stage_info.reads))) return;
  throw Error(Failure::input, std::string(folder) + kernel.file,
              "kernel " + kernel.name + (writes ? " writes " : " reads ") + std::string(info(buffer).name) +
                  ", which host/stages.def does not list among what " + std::string(stage_info.name) +
                  (writes ? " WRITES" : " READS or WRITES"));
}

void check_stage_table(std::span<const KernelSignature> kernels) {
  for (const KernelSignature& kernel : kernels) {
    const auto stage = stage_named(stem(kernel.file));
    if (!stage) continue;
    for (const KernelParameter& parameter : kernel.parameters)
      if (const auto buffer = buffer_named(parameter.name)) check_access(*stage, kernel, parameter, *buffer);
  }
}

}  // namespace lockstep
