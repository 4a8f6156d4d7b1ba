// An Error about one body or joint of a scene.
#pragma once

#include "host/error.hpp"

namespace lockstep {

/// What an ItemError is about.
enum class Item { body, joint };

/// An Error about one body or joint of a scene, which it tells by its number: who knows its name says it by that.
class ItemError : public Error {
 public:
  ItemError(Failure failure, const std::string& where, Item item, unsigned world, unsigned id, const std::string& what)
      : Error(failure, where, numbered(item, world, id) + ": " + what),
        item_(item),
        world_(world),
        id_(id),
        where_(where),
        what_(what) {}

  Item item() const { return item_; }
  unsigned world() const { return world_; }
  unsigned id() const { return id_; }  // local to the world
  /// The same of what is called `name`.
  Error named(const std::string& name) const { return {failure(), where_, name + ": " + what_}; }

 private:
  static std::string numbered(Item item, unsigned world, unsigned id) {
    return (item == Item::body ? "body " : "joint ") + std::to_string(id) + " of world " + std::to_string(world);
  }

  Item item_;
  unsigned world_, id_;
  std::string where_, what_;
};

}  // namespace lockstep
