// Links of a robot that move and have no mass: nothing can be simulated that weighs nothing.
#pragma once

#include "host/scene/robot_model.hpp"

namespace lockstep {

/// Links that are fixed to each other count as one. One at the root stays where it is; one from which nothing hangs is
/// fixed to what it hangs on; one between two joints takes 5 % of the first that hangs from it. What was done is said
/// in the robot's notes.
void settle_massless_links(Robot& robot);

}  // namespace lockstep
