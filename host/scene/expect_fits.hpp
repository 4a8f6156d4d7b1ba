// Whether the precision of a run holds the numbers of what joins it, before anything else changes.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Refuses a body whose numbers this precision does not hold, as compile() would, in a line that begins with `where`.
template <class real>
void expect_fits(const BodyDescription& body, const std::string& where);

/// The same of a joint between bodies of the scene.
template <class real>
void expect_fits(const JointDescription& joint, const Scene& scene, const std::string& where);

}  // namespace lockstep
