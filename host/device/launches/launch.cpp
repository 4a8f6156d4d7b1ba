#include "host/device/launcher.hpp"

namespace lockstep {

#define STAGE(name, ...) void launch_##name(Launcher& launcher);
#include "host/stages.def"
#undef STAGE

void launch(Stage stage, Launcher& launcher) {
  switch (stage) {
#define STAGE(name, ...) \
  case Stage::name:      \
    return launch_##name(launcher);
#include "host/stages.def"
#undef STAGE
    case Stage::count: return;
  }
}

}  // namespace lockstep
