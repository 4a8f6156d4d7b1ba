#include <algorithm>

#include "host/scene/compile.hpp"

namespace lockstep {

void set_first_capacities(Sizes& sizes, Features features) {
  sizes.buckets = 64;
  while (sizes.buckets < 2 * sizes.top_level()) sizes.buckets *= 2;
  while (sizes.buckets < sizes.particles) sizes.buckets *= 2;
  sizes.pairs = std::max(8 * sizes.top_level(), 4 * sizes.particles) + 64;
  sizes.contacts = sizes.pairs * (has(features, Feature::manifolds) ? 2 : 1);
  // each colour, and the overflow, may end in a block that is not full
  sizes.blocks = sizes.contacts / PACK + MAX_COLORS + 1;
  sizes.rows = sizes.blocks;
  // a contact feels those of its own tile and of a few others
  if (has(features, Feature::dense)) sizes.coupled_tiles = 8 * tile_count(sizes.contacts, sizes.worlds);
}

}  // namespace lockstep
