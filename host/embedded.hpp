// Files that travel inside the library: kernels, scenes, their meshes and robots (cmake/embed.cmake).
#pragma once

#include <span>
#include <string_view>

namespace lockstep {

struct EmbeddedFile {
  std::string_view name, text;
};

std::span<const EmbeddedFile> embedded_kernels();
std::span<const EmbeddedFile> embedded_scenes();
std::span<const EmbeddedFile> embedded_meshes();
std::span<const EmbeddedFile> embedded_robots();

}  // namespace lockstep
