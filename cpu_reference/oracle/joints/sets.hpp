// Sets that only ever grow together (union-find).
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace lockstep::oracle {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False where they were in one set already.
  bool unite(std::size_t i, std::size_t j) {
    const std::size_t a = find(i), b = find(j);
    parent_[b] = a;
    return a != b;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace lockstep::oracle
