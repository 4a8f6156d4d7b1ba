// Files that travel inside the library: kernels and scenes (cmake/embed.cmake).
#pragma once

#include <span>
#include <string_view>

namespace lockstep {

struct EmbeddedFile {
  std::string_view name, text;
};

std::span<const EmbeddedFile> embedded_kernels();
std::span<const EmbeddedFile> embedded_scenes();

}  // namespace lockstep
