// The processes of a run that is spread over ranks of MPI: `mpirun -n 4 lockstep run SCENE --worlds 1000`. Without
// mpirun there is one, and MPI is not started.
#pragma once

#include <cstring>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/types.h"

namespace lockstep::app {

/// Ends the program without a word: another rank tells what went wrong.
struct SilentExit {
  int status;
};

class Ranks {
 public:
  /// Throws Error (input) where mpirun started several and this build knows no MPI.
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  u32 rank() const { return rank_; }
  u32 size() const { return size_; }
  // of those on this machine
  u32 local_rank() const { return local_rank_; }
  u32 local_size() const { return local_size_; }

  /// Runs the work of each rank. Where that of any fails, all of them end: rank 0 throws the Error of the first that
  /// failed, the others SilentExit.
  void together(const std::function<void()>& work) const;

  /// On rank 0 what all have, in order of ranks; on others nothing.
  template <class Item>
  std::vector<std::vector<Item>> gather(const std::vector<Item>& mine) const {
    static_assert(std::is_trivially_copyable_v<Item>);
    std::vector<std::vector<Item>> all;
    for (const std::string& bytes :
         gather_bytes({reinterpret_cast<const char*>(mine.data()), mine.size() * sizeof(Item)})) {
      all.emplace_back(bytes.size() / sizeof(Item));
      std::memcpy(all.back().data(), bytes.data(), bytes.size());
    }
    return all;
  }

 private:
  std::vector<std::string> gather_bytes(const std::string& mine) const;

  u32 rank_ = 0, size_ = 1, local_rank_ = 0, local_size_ = 1;
  bool joined_ = false;
};

}  // namespace lockstep::app
