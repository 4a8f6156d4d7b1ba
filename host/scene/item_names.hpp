// What errors call the bodies and joints of scenes.
#pragma once

#include <span>
#include <string>

#include "host/item_error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// `body "crate"`, with its world where there are several; nothing of what has no name.
inline std::string item_name(std::span<const Scene> worlds, const ItemError& error) {
  const Scene& scene = worlds[error.world()];
  const bool is_body = error.item() == Item::body;
  const std::string& name = is_body ? scene.bodies[error.id()].name : scene.joints[error.id()].name;
  if (name.empty()) return {};
  const std::string text = (is_body ? "body " : "joint ") + quote(name);
  return worlds.size() == 1 ? text : text + " of world " + std::to_string(error.world());
}

/// Does the work; an ItemError of these worlds goes on as one that tells the item's name, if it has one.
template <class Work>
auto with_item_names(std::span<const Scene> worlds, Work&& work) {
  try {
    return work();
  } catch (const ItemError& error) {
    const std::string name = item_name(worlds, error);
    if (name.empty()) throw;
    throw error.named(name);
  }
}

}  // namespace lockstep
