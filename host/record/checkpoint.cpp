#include "host/record/checkpoint.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "host/error.hpp"
#include "host/record/consistency.hpp"
#include "host/record/content_hash.hpp"
#include "host/record/state_group.hpp"
#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

constexpr u32 format = 1;

// In front of what HDF5 writes stands a block of its own ("user block"): one line that says how long the rest must be
// and what its hash is. So whatever is torn or damaged is refused before HDF5 sees it.
constexpr std::size_t block = 512;

std::uint64_t hash_of(std::span<const unsigned char> bytes) {
  ContentHash hash;
  hash.add(bytes.data(), bytes.size());
  return hash.value();
}

std::array<unsigned char, block> front_block(std::span<const unsigned char> rest) {
  std::array<unsigned char, block> bytes = {};
  std::snprintf(reinterpret_cast<char*>(bytes.data()), bytes.size(), "%s %u, %zu bytes, hash %016llx\n",
                checkpoint_signature.data(), format, rest.size(), static_cast<unsigned long long>(hash_of(rest)));
  return bytes;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) { throw Error(Failure::input, path, why); }

// The part behind the block in front, whole.
std::span<const unsigned char> checked(std::span<const unsigned char> bytes, const std::string& path) {
  const auto starts_with = [&](std::string_view text) {
    return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
  };
  if (starts_with("\x89HDF"))
    refuse(path, "is no checkpoint but another HDF5 file; 'lockstep verify' reads recordings");
  if (!starts_with(checkpoint_signature)) refuse(path, "is no checkpoint; 'lockstep run --checkpoint' writes them");
  if (bytes.size() < block) refuse(path, "is cut short; use an older checkpoint");
  const std::string line(bytes.begin(), bytes.begin() + block);
  unsigned written = 0;
  unsigned long long length = 0, hash = 0;
  const std::string pattern = std::string(checkpoint_signature) + " %u, %llu bytes, hash %llx\n";
  const int found = std::sscanf(line.c_str(), pattern.c_str(), &written, &length, &hash);
  if (found >= 1 && written != format)
    refuse(path, "has format " + std::to_string(written) + ", this program reads format " + std::to_string(format));
  if (found != 3) refuse(path, "is damaged in its first line; use an older checkpoint");
  const std::span<const unsigned char> rest = bytes.subspan(block);
  if (rest.size() != length)
    refuse(path, "has " + std::to_string(rest.size()) + " bytes behind its first block where " +
                     std::to_string(length) + " were written; use an older checkpoint");
  const auto front = front_block(rest);
  if (hash_of(rest) != hash || !std::equal(front.begin(), front.end(), bytes.begin()))
    refuse(path, "is damaged, its hash does not fit; use an older checkpoint");
  return rest;
}

template <class real>
void expect_same_scene(const CheckpointLabel& label, const std::string& scene, const InitialState<real>& state,
                       const std::string& path, OracleIs oracle) {
  const SceneIdentity here = identity_of(state, oracle);
  if (label.identity == here) return;
  if (label.scene != scene) refuse(path, "is a checkpoint of scene " + quote(label.scene) + ", not of " + quote(scene));
  if (label.identity.settings != here.settings)
    refuse(path,
           "was made with other settings; give the options of that run, as --dt, --substeps, --solver or --events");
  refuse(path, "was made of another version of scene " + quote(scene));
}

}  // namespace

std::vector<Buffer> persistent_buffers(Features features) {
  std::vector<Buffer> buffers;
  for (u32 i = 0; i < buffer_count; ++i) {
    const BufferInfo& about = info(static_cast<Buffer>(i));
    if (about.lifetime == Lifetime::persistent && has(features, about.feature))
      buffers.push_back(static_cast<Buffer>(i));
  }
  return buffers;
}

std::vector<unsigned char> seal_checkpoint(std::span<const unsigned char> contents) {
  const auto front = front_block(contents);
  std::vector<unsigned char> bytes(block + contents.size());
  std::copy(front.begin(), front.end(), bytes.begin());
  std::copy(contents.begin(), contents.end(), bytes.begin() + block);
  return bytes;
}

std::vector<unsigned char> checkpoint_contents(std::span<const unsigned char> bytes, const std::string& path) {
  const std::span<const unsigned char> contents = checked(bytes, path);
  return {contents.begin(), contents.end()};
}

template <class real>
std::vector<unsigned char> encode_checkpoint(const CheckpointLabel& label, const Buffers<real>& persistent,
                                             Features features) {
  h5::be_quiet();
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  h5::check(H5Pset_fapl_core(access, 1u << 20, false));
  const h5::Handle file(H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access));
  h5::write_attribute(file, "scene", label.scene);
  h5::write_attribute(file, "device", label.device);
  h5::write_attribute(file, "version", std::string(LOCKSTEP_VERSION));
  h5::write_attribute(file, "precision", std::string(sizeof(real) == 8 ? "double" : "float"));
  h5::write_attribute(file, "settings_identity", label.identity.settings);
  h5::write_attribute(file, "scene_identity", label.identity.constants);
  h5::write_attribute(file, "state_hash", label.state_hash);
  h5::write_attribute(file, "oracle", label.oracle);
  {
    const h5::Handle group(H5Gcreate2(file, "state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    write_persistent(group, persistent, features);
  }
  h5::check(H5Fflush(file, H5F_SCOPE_LOCAL));
  std::vector<unsigned char> contents(static_cast<std::size_t>(h5::check(H5Fget_file_image(file, nullptr, 0))));
  h5::check(H5Fget_file_image(file, contents.data(), contents.size()));
  return seal_checkpoint(contents);
}

template <class real>
CheckpointLabel resume_from(std::span<const unsigned char> bytes, const std::string& path, const std::string& scene,
                            InitialState<real>& state) {
  const std::span<const unsigned char> rest = checked(bytes, path);
  try {
    const h5::Handle file = h5::open_image(rest);
    CheckpointLabel label;
    label.scene = h5::read_text_attribute(file, "scene");
    label.device = h5::read_text_attribute(file, "device");
    label.identity.settings = h5::read_attribute<std::uint64_t>(file, "settings_identity");
    label.identity.constants = h5::read_attribute<std::uint64_t>(file, "scene_identity");
    label.state_hash = h5::read_attribute<std::uint64_t>(file, "state_hash");
    const bool names_oracle = h5::has_attribute(file, "oracle");
    if (names_oracle) label.oracle = h5::read_text_attribute(file, "oracle");
    if (names_oracle && label.oracle != state.oracle.name)
      refuse(path, label.oracle.empty() ? "was made by no oracle; leave " + quote(state.oracle.name) + " out"
                                        : "was made by an oracle; give --solver " + label.oracle);
    const std::string precision = read_precision(file);
    if (precision != (sizeof(real) == 8 ? "double" : "float"))
      refuse(path, "is in " + precision + "; ask for --precision " + precision);
    expect_same_scene(label, scene, state, path, names_oracle ? OracleIs::counted : OracleIs::left_out);
    read_persistent(h5::open_group(file, "state"), state);
    expect_consistent_lists(state);
    return label;
  } catch (const h5::Failed& failed) {
    refuse(path, std::string("is no checkpoint that this program reads: ") + failed.what());
  }
}

#define INSTANTIATE(real)                                                                                              \
  template std::vector<unsigned char> encode_checkpoint<real>(const CheckpointLabel&, const Buffers<real>&, Features); \
  template CheckpointLabel resume_from<real>(std::span<const unsigned char>, const std::string&, const std::string&,   \
                                             InitialState<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
