#include <fmt/format.h>

#include <algorithm>

#include "host/app/commands.hpp"
#include "host/scene/read.hpp"

namespace lockstep::app {

namespace {

void list_scenes() {
  const std::vector<SceneListing> scenes = built_in_scenes();
  std::size_t width = 0;
  for (const SceneListing& scene : scenes) width = std::max(width, scene.name.size());
  for (const SceneListing& scene : scenes) fmt::print("{:<{}}  {}\n", scene.name, width, scene.description);
}

}  // namespace

void add_scenes(CLI::App& program) {
  CLI::App* command = program.add_subcommand("scenes", "List the built-in scenes");
  command->footer("Example:\n  lockstep scenes");
  command->callback(list_scenes);
}

}  // namespace lockstep::app
