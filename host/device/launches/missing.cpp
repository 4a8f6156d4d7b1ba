// Stands in for the launch functions of stages that have none yet; each goes when its stage comes.
#include "host/device/launcher.hpp"

namespace lockstep {

#define STAGE(name, ...) \
  [[gnu::weak]] void launch_##name(Launcher&) {}
#include "host/stages.def"
#undef STAGE

}  // namespace lockstep
