#include "host/device/program_cache.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>

namespace lockstep {

namespace {

constexpr std::array<char, 8> magic = {'l', 'o', 'c', 'k', 's', 't', 'p', '1'};

struct Header {
  std::array<char, 8> magic;
  CacheKey key;
  std::uint64_t length, checksum;
};

// FNV-1a, finished by the mix of splitmix64.
std::uint64_t hash_bytes(std::span<const unsigned char> bytes, std::uint64_t hash) {
  for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
  return hash ^ (hash >> 31);
}

std::uint64_t hash_text(std::string_view text, std::uint64_t hash) {
  return hash_bytes({reinterpret_cast<const unsigned char*>(text.data()), text.size()}, hash);
}

std::filesystem::path user_folder() {
  if (const char* own = std::getenv("LOCKSTEP_CACHE")) return own;
  if (const char* caches = std::getenv("XDG_CACHE_HOME"); caches && *caches)
    return std::filesystem::path(caches) / "lockstep";
  if (const char* home = std::getenv("HOME"); home && *home) return std::filesystem::path(home) / ".cache" / "lockstep";
  return {};
}

}  // namespace

std::string CacheKey::hex() const {
  char text[33];
  std::snprintf(text, sizeof(text), "%016llx%016llx", static_cast<unsigned long long>(high),
                static_cast<unsigned long long>(low));
  return text;
}

CacheKey make_cache_key(const std::vector<std::string_view>& inputs) {
  CacheKey key = {0xcbf29ce484222325u, 0x9e3779b97f4a7c15u};
  for (const std::string_view input : inputs) {
    // the length keeps "ab" "c" apart from "a" "bc"
    key.high = hash_text(input, key.high ^ input.size());
    key.low = hash_text(input, key.low + input.size());
  }
  return key;
}

ProgramCache ProgramCache::of_user() { return ProgramCache(user_folder()); }

std::optional<std::vector<unsigned char>> ProgramCache::load(const CacheKey& key) const {
  if (folder_.empty()) return std::nullopt;
  std::ifstream in(file(key), std::ios::binary);
  Header header;
  if (!in.read(reinterpret_cast<char*>(&header), sizeof(header))) return std::nullopt;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file(key), error);
  if (error || header.magic != magic || !(header.key == key) || size != sizeof(header) + header.length)
    return std::nullopt;
  std::vector<unsigned char> binary(header.length);
  if (!in.read(reinterpret_cast<char*>(binary.data()), static_cast<std::streamsize>(binary.size())))
    return std::nullopt;
  if (hash_bytes(binary, header.key.low) != header.checksum) return std::nullopt;
  return binary;
}

void ProgramCache::store(const CacheKey& key, const std::vector<unsigned char>& binary) const {
  if (folder_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  std::filesystem::path written = file(key);
  written += '.';
  written += std::to_string(getpid());
  const Header header = {magic, key, binary.size(), hash_bytes(binary, key.low)};
  std::ofstream out(written, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(&header), sizeof(header));
  out.write(reinterpret_cast<const char*>(binary.data()), static_cast<std::streamsize>(binary.size()));
  out.close();
  if (out) std::filesystem::rename(written, file(key), error);
  if (!out || error) std::filesystem::remove(written, error);
}

}  // namespace lockstep
