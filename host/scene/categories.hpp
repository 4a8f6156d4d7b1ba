// Categories of shapes by their names.
#pragma once

#include <string>
#include <vector>

#include "kernels/types.h"

namespace lockstep {

/// The bits of those with these names: `categories` are those of a scene (Scene::categories). Throws Error (input) for
/// a name that is not among them.
u32 category_mask(const std::vector<std::string>& categories, const std::vector<std::string>& names);

}  // namespace lockstep
