#include "host/device/pocl_cache.hpp"

#include <dlfcn.h>
#include <elf.h>
#include <link.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

namespace lockstep {

namespace {

namespace fs = std::filesystem;

// What the kernels of a scene take, with the files that they are made of.
constexpr std::uintmax_t room_for_kernels = 32u << 20;

// Of a file that is small enough to have it all at once, or its first bytes.
template <class T>
bool read_at(std::ifstream& file, std::uint64_t at, T& value) {
  file.seekg(static_cast<std::streamoff>(at));
  return static_cast<bool>(file.read(reinterpret_cast<char*>(&value), sizeof(value)));
}

bool is_whole_program(const fs::path& folder) {
  std::error_code ignored;
  for (fs::recursive_directory_iterator entry(folder, ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    const fs::path ending = entry->path().extension();
    if (ending == ".so" && !is_whole_library(entry->path())) return false;
    if (ending == ".bc" && !is_whole_bitcode(entry->path())) return false;
  }
  return true;
}

bool takes_files(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  struct statvfs disk;
  return ::access(folder.c_str(), W_OK) == 0 && ::statvfs(folder.c_str(), &disk) == 0 &&
         std::uintmax_t{disk.f_bavail} * disk.f_frsize >= room_for_kernels;
}

// A folder of this process, which goes with it.
class OwnFolder {
 public:
  bool make(const fs::path& parent) {
    std::string name = (parent / "lockstep-kernels-XXXXXX").string();
    if (!takes_files(parent) || ::mkdtemp(name.data()) == nullptr) return false;
    path_ = name;
    process_ = getpid();
    return true;
  }
  ~OwnFolder() {
    std::error_code ignored;
    if (!path_.empty() && process_ == getpid()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  pid_t process_ = 0;
};

std::vector<fs::path> other_disks() {
  std::vector<fs::path> folders;
  if (const char* temporary = std::getenv("TMPDIR"); temporary && *temporary) folders.emplace_back(temporary);
  folders.insert(folders.end(), {"/tmp", "/var/tmp", "/dev/shm"});
  return folders;
}

}  // namespace

fs::path pocl_cache_folder() {
  const auto set = [](const char* name) -> const char* {
    const char* value = std::getenv(name);
    return value && *value ? value : nullptr;
  };
  if (const char* own = set("POCL_CACHE_DIR")) return own;
  if (const char* caches = set("XDG_CACHE_HOME")) return fs::path(caches) / "pocl/kcache";
  if (const char* home = set("HOME")) return fs::path(home) / ".cache/pocl/kcache";
  return "/tmp/pocl/kcache";
}

// The table of sections is the last thing in one, and segments are mapped as far as they say.
bool is_whole_library(const fs::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  Elf64_Ehdr header;
  if (!read_at(file, 0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return false;
  if (header.e_ident[EI_CLASS] != ELFCLASS64) return true;  // of a machine that this code knows nothing of
  const auto within = [size](std::uint64_t first, std::uint64_t length) {
    return first <= size && length <= size - first;
  };
  if (!within(header.e_shoff, std::uint64_t{header.e_shnum} * header.e_shentsize)) return false;
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    Elf64_Phdr segment;
    if (!read_at(file, header.e_phoff + std::uint64_t{i} * header.e_phentsize, segment)) return false;
    if (!within(segment.p_offset, segment.p_filesz)) return false;
  }
  return true;
}

// Blocks one after the other, each with its length in words (LLVM Bitcode File Format, "Blocks"), the last of which
// that pocl's files always have is the table of names.
bool is_whole_bitcode(const fs::path& path) {
  constexpr std::uint32_t magic = 0xdec04342, wrapper = 0x0b17c0de, enter_block = 1, names = 23;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  std::uint32_t word = 0;
  if (!read_at(file, 0, word)) return false;
  if (word == wrapper) return true;
  if (word != magic) return false;
  bool has_names = false;
  std::uint64_t at = sizeof(word);
  while (at + 8 <= size) {
    std::array<std::uint32_t, 2> block;
    if (!read_at(file, at, block) || (block[0] & 3) != enter_block) return false;
    has_names = has_names || (block[0] >> 2 & 255) == names;
    at += 8 + std::uint64_t{4} * block[1];
  }
  return has_names && at == size;
}

unsigned remove_torn_programs(const fs::path& cache) {
  unsigned removed = 0;
  std::error_code ignored;
  std::vector<fs::path> torn;
  for (const auto& group : fs::directory_iterator(cache, ignored)) {
    if (!group.is_directory(ignored)) continue;
    for (const auto& program : fs::directory_iterator(group, ignored))
      if (program.is_directory(ignored) && !is_whole_program(program)) torn.push_back(program);
  }
  for (const fs::path& program : torn) removed += fs::remove_all(program, ignored) > 0 && !ignored;
  return removed;
}

bool prepare_pocl_cache(void (*note)(const std::string& line)) {
  const fs::path folder = pocl_cache_folder();
  if (takes_files(folder)) {
    if (const unsigned removed = remove_torn_programs(folder))
      note(folder.string() + ": pocl's cache of kernels had torn files in " + std::to_string(removed) + " program" +
           (removed == 1 ? "" : "s") + ", removed; they are built again");
    return true;
  }
  static OwnFolder own;
  for (const fs::path& parent : other_disks()) {
    if (!own.make(parent)) continue;
    ::setenv("POCL_CACHE_DIR", own.path().c_str(), 1);
    note(folder.string() +
         ": pocl's cache of kernels can have no files there, the disk is full or may not be written; "
         "kernels are built in " +
         own.path().string() + " for this run; free some disk, or set POCL_CACHE_DIR");
    return true;
  }
  note(folder.string() +
       ": pocl's cache of kernels can have no files there, nor has any other disk room for kernels: its devices are "
       "left "
       "out; free some disk, or set POCL_CACHE_DIR");
  return false;
}

void keep_loaded_kernels() {
  static std::mutex mutex;
  static auto& kept = *new std::set<std::string>;
  static const std::string folder = pocl_cache_folder().string() + "/";
  std::vector<std::string> found;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* to) {
        static_cast<std::vector<std::string>*>(to)->emplace_back(info->dlpi_name ? info->dlpi_name : "");
        return 0;
      },
      &found);
  const std::lock_guard lock(mutex);
  for (const std::string& path : found)
    if (path.starts_with(folder) && kept.insert(path).second) dlopen(path.c_str(), RTLD_NOW | RTLD_NOLOAD);
}

}  // namespace lockstep
