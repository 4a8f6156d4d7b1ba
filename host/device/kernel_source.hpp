// Kernel files: one program text from several, and what their kernels' parameters are called.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/stages.hpp"

namespace lockstep {

struct KernelFile {
  std::string name, text;  // name: relative to kernels/
};

/// A test's change to a kernel file: the first `from` becomes `to`.
struct KernelPatch {
  std::string file, from, to;
};

struct KernelParameter {
  enum class Kind { read, written, params, value };  // const buffer, buffer, StepParams, u32
  std::string name, type;                            // type: as it stands in the source
  Kind kind;
};

struct KernelSignature {
  std::string name, file;
  std::vector<KernelParameter> parameters;
};

class KernelSources {
 public:
  explicit KernelSources(std::vector<KernelFile> files);

  /// The files embedded in the library. Throws Error (input) where a patch finds nothing to change.
  static KernelSources embedded(std::span<const KernelPatch> patches = {});

  bool contains(std::string_view name) const;

  /// The kernel files (.cl) in order of name.
  std::vector<std::string> kernel_files() const;

  /// The named files one after another. Quoted includes are replaced by the file, headers once each; #line directives
  /// keep compilers' messages at the files' own lines.
  std::string assemble(std::span<const std::string> names) const;

  /// The kernels of the named files. Throws Error (input) for a parameter list that the binder does not understand.
  std::vector<KernelSignature> signatures(std::span<const std::string> names) const;

 private:
  const KernelFile& file(std::string_view name) const;
  void append(std::string& out, const KernelFile& file, std::vector<std::string_view>& included) const;

  std::vector<KernelFile> files_;
};

std::optional<Stage> stage_named(std::string_view name);
std::optional<Buffer> buffer_named(std::string_view name);

/// Kernel files of the stages that run, those of `only` where it names some, and those that several stages share.
std::vector<std::string> stage_files(const KernelSources& sources, Features features, std::span<const Stage> only = {});

/// Throws Error (input) where `kernel`, as a part of the stage, takes a buffer for writing that is not among the
/// stage's WRITES, or for reading one that is in neither list (host/stages.def). Every stage may use `counters`.
void check_access(Stage stage, const KernelSignature& kernel, const KernelParameter& parameter, Buffer buffer);

/// The same for every kernel in a stage's own file.
void check_stage_table(std::span<const KernelSignature> kernels);

}  // namespace lockstep
