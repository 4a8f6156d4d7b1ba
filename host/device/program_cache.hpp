// Built programs, kept on disk between runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lockstep {

/// 128 bits over everything that a binary depends on.
struct CacheKey {
  std::uint64_t high = 0, low = 0;

  bool operator==(const CacheKey&) const = default;
  std::string hex() const;  // 32 digits: the name of the file
};

CacheKey make_cache_key(const std::vector<std::string_view>& inputs);

/// Files of one folder, one a binary: magic, key, length, checksum, binary. A file that is torn, foreign or unreadable
/// counts as absent, and is written anew. Nothing here throws: where a folder cannot be written there is no cache.
class ProgramCache {
 public:
  /// An empty path: no cache.
  explicit ProgramCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// $LOCKSTEP_CACHE, else $XDG_CACHE_HOME/lockstep, else ~/.cache/lockstep. LOCKSTEP_CACHE set but empty: no cache.
  static ProgramCache of_user();

  bool exists() const { return !folder_.empty(); }

  std::optional<std::vector<unsigned char>> load(const CacheKey& key) const;

  /// Replaces the file in one rename, so that readers and other writers see a whole file or none.
  void store(const CacheKey& key, const std::vector<unsigned char>& binary) const;

  std::filesystem::path file(const CacheKey& key) const { return folder_ / (key.hex() + ".program"); }

 private:
  std::filesystem::path folder_;
};

}  // namespace lockstep
