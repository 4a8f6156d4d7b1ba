// Launches of the stages that answer questions about the shapes.
#include "host/device/launcher.hpp"

namespace lockstep {

void launch_cast_rays(Launcher& launcher) {
  const u32 rays = launcher.plan().sizes.rays;
  launcher.run("cast_rays", rays, {{"room", rays}});
}

void launch_find_overlaps(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  launcher.run("find_overlaps", sizes.volumes + 1, {{"room", sizes.volumes}, {"overlap_room", 0u}});
  launcher.scan("overlap_starts", sizes.volumes + 1);
  if (sizes.overlaps > 0)
    launcher.run("find_overlaps", sizes.volumes + 1, {{"room", sizes.volumes}, {"overlap_room", sizes.overlaps}});
}

}  // namespace lockstep
