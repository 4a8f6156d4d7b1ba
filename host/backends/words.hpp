// Words of results: compared as bits, shown as bits and as numbers.
#pragma once

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string>
#include <type_traits>

namespace lockstep {

/// NaNs count as equal: their payloads are not promised.
template <class Word>
bool same_bits(Word a, Word b) {
  using Bits = std::conditional_t<sizeof(Word) == 8, std::uint64_t, std::uint32_t>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b) || (a != a && b != b);
}

/// "0x3f800000 (1)": the bits, and the shortest number that gives them back.
template <class Word>
std::string show_word(Word value) {
  using Bits = std::conditional_t<sizeof(Word) == 8, std::uint64_t, std::uint32_t>;
  char hex[24], number[40];
  std::snprintf(hex, sizeof(hex), "0x%0*llx", static_cast<int>(2 * sizeof(Word)),
                static_cast<unsigned long long>(std::bit_cast<Bits>(value)));
  const auto end = std::to_chars(number, number + sizeof(number), value).ptr;
  return std::string(hex) + " (" + std::string(number, end) + ")";
}

}  // namespace lockstep
