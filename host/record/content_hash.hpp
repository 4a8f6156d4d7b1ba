// A hash of bytes in their order: tells a damaged file from a whole one, and one scene from another. No secret.
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>

namespace lockstep {

class ContentHash {
 public:
  void add(std::uint64_t word) {
    // SplitMix64's finalizer (Steele, Lea, Flood 2014)
    std::uint64_t h = (hash_ + 0x9e3779b97f4a7c15u) ^ word;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    hash_ = h ^ (h >> 31);
  }

  /// The bytes and how many they are.
  void add(const void* bytes, std::size_t count) {
    add(count);
    const char* next = static_cast<const char*>(bytes);
    for (; count > 0;) {
      std::uint64_t word = 0;
      const std::size_t taken = count < sizeof(word) ? count : sizeof(word);
      std::memcpy(&word, next, taken);
      add(word);
      next += taken;
      count -= taken;
    }
  }
  void add(std::string_view text) { add(text.data(), text.size()); }

  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace lockstep
