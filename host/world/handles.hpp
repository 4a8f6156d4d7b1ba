// Handles of what stands in a list, where things go from the middle and come at the end.
#pragma once

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "include/lockstep/world.hpp"

namespace lockstep {

/// One of what `names` names by its place is gone: it is named NONE, and those behind it have moved up.
inline void rename_without(std::vector<u32>& names, u32 gone) {
  for (u32& name : names) name = name == gone || name == NONE ? NONE : name - (name > gone);
}

/// A handle stays good while its thing moves up the list, and is never given to another one.
template <class Handle>
class Handles {
 public:
  /// `what` one is called where it is asked for and not there; `world`: its number, from 1.
  Handles(const char* what, u32 world) : what_(what), world_(world) {}

  /// Of what has come to the end of the list.
  Handle add() {
    all_.push_back({static_cast<u32>(index_of_.size()), world_});
    index_of_.push_back(static_cast<u32>(all_.size()) - 1);
    return all_.back();
  }
  void remove(u32 index, const std::string& name) {
    if (!name.empty()) names_of_gone_[all_[index].id] = name;
    all_.erase(all_.begin() + index);
    rename_without(index_of_, index);
  }

  bool contains(Handle handle) const { return was_given(handle) && index_of_[handle.id] != NONE; }
  /// Throws Error (input) where it is gone.
  u32 index(Handle handle) const {
    if (contains(handle)) return index_of_[handle.id];
    if (!is_of_this_world(handle)) throw Error(Failure::input, called("", handle), "is of another world");
    const auto gone = names_of_gone_.find(handle.id);
    const std::string name = gone == names_of_gone_.end() ? std::string() : gone->second;
    throw Error(Failure::input, called(name, handle),
                was_given(handle) ? "is not in this world any more" : "is not in this world");
  }

  /// What errors call it: `body "crate"`, or by its handle where it has no name.
  std::string called(const std::string& name, Handle handle) const {
    return what_ + (name.empty() ? " with the handle " + std::to_string(handle.id) : " " + quote(name));
  }

  /// As they were when `before` was a copy of them; of those that have come since none is given again.
  void go_back(const Handles& before) {
    const std::size_t issued = index_of_.size();
    all_ = before.all_;
    index_of_ = before.index_of_;
    index_of_.resize(std::max(issued, index_of_.size()), NONE);
  }

  Handle operator[](std::size_t index) const { return all_[index]; }
  const std::vector<Handle>& all() const { return all_; }

 private:
  bool is_of_this_world(Handle handle) const { return handle.world == 0 || handle.world == world_; }
  bool was_given(Handle handle) const { return is_of_this_world(handle) && handle.id < index_of_.size(); }

  std::string what_;
  u32 world_;
  std::vector<Handle> all_;                   // in the order of the list
  std::vector<u32> index_of_;                 // by id; NONE: removed
  std::map<u32, std::string> names_of_gone_;  // by id
};

}  // namespace lockstep
