#include "host/buffers.hpp"

#include <algorithm>

namespace lockstep {

namespace {

// Sizes of an element in both precisions: `real` names the precision inside the table.
template <class real>
constexpr std::array<std::size_t, buffer_count> element_sizes() {
  return {
#define BUFFER(name, element, ...) sizeof(element),
#include "host/buffers.def"
#undef BUFFER
  };
}

constexpr auto float_sizes = element_sizes<float>();
constexpr auto double_sizes = element_sizes<double>();

constexpr std::array<BufferInfo, buffer_count> make_infos() {
  std::array<BufferInfo, buffer_count> infos = {{
#define BUFFER(name, element, domain, lifetime, feature) \
  BufferInfo{#name, Domain::domain, Lifetime::lifetime, Feature::feature, 0, 0},
#include "host/buffers.def"
#undef BUFFER
  }};
  for (u32 i = 0; i < buffer_count; ++i) {
    infos[i].float_bytes = float_sizes[i];
    infos[i].double_bytes = double_sizes[i];
  }
  return infos;
}

constexpr auto infos = make_infos();

}  // namespace

const BufferInfo& info(Buffer buffer) { return infos[static_cast<u32>(buffer)]; }

u32 tree_block_count(u32 shapes) {
  u32 count = 0, entries = shapes;
  do {
    entries = (entries + PACK - 1) / PACK;
    count += (entries + PACK - 1) / PACK;
  } while (entries > PACK);
  return count;
}

u32 tile_count(u32 contacts, u32 worlds) { return contacts / PACK + worlds; }

std::size_t capacity(Domain domain, const Sizes& sizes) {
  switch (domain) {
    case Domain::one: return 1;
    case Domain::counters: return COUNTER_COUNT;
    case Domain::worlds: return sizes.worlds;
    case Domain::bodies: return sizes.bodies;
    case Domain::body_lines: return std::size_t{sizes.bodies} + 1;
    case Domain::body_masks: return std::size_t{sizes.bodies} * 2;
    case Domain::shapes: return sizes.shapes;
    case Domain::shape_ends: return std::size_t{sizes.shapes} + 1;
    case Domain::top_level: return sizes.top_level();
    case Domain::shape_trees: return sizes.shape_trees;
    case Domain::tree_shapes: return sizes.tree_shapes;
    case Domain::shape_tree_blocks: return sizes.shape_tree_blocks;
    case Domain::planes: return sizes.planes;
    case Domain::hulls: return sizes.hulls;
    case Domain::hull_vertices: return sizes.hull_vertices;
    case Domain::hull_faces: return sizes.hull_faces;
    case Domain::hull_edges: return sizes.hull_edges;
    case Domain::hull_corners: return sizes.hull_corners;
    case Domain::facets: return sizes.facets;
    case Domain::facet_edges: return sizes.facet_edges;
    case Domain::seams: return sizes.seams;
    case Domain::materials: return sizes.material_pairs;
    case Domain::buckets: return std::size_t{sizes.buckets} + 1;
    case Domain::tree_blocks: return tree_block_count(sizes.top_level());
    case Domain::pairs: return sizes.pairs;
    case Domain::pair_ends: return std::size_t{sizes.pairs} + 1;
    case Domain::contacts:
    case Domain::cached:
    case Domain::slept: return sizes.contacts;
    case Domain::colors: return MAX_COLORS + 2;
    case Domain::cell_ends: return std::size_t{CELL_PHASES} * cells_in_phase(sizes.bodies, sizes.worlds) + 1;
    case Domain::blocks: return sizes.blocks;
    case Domain::rows: return sizes.rows;
    case Domain::tiles: return tile_count(sizes.contacts, sizes.worlds);
    case Domain::tile_ends: return std::size_t{tile_count(sizes.contacts, sizes.worlds)} + 1;
    case Domain::coupled_tiles: return sizes.coupled_tiles;
    case Domain::joints: return sizes.joints;
    case Domain::joint_phases: return std::size_t{sizes.joint_phases} + 1;
    case Domain::joint_blocks: return sizes.joint_blocks;
    case Domain::joined: return sizes.joined;
    case Domain::body_joints: return sizes.body_joints;
    case Domain::planar_joints: return sizes.planar_joints;
    case Domain::couplings: return sizes.couplings;
    case Domain::coupled_joints: return sizes.coupled_joints;
    case Domain::coupling_phases: return std::size_t{sizes.coupling_phases} + 1;
    case Domain::articulations: return sizes.articulations;
    case Domain::links: return sizes.links;
    case Domain::link_levels: return std::size_t{sizes.link_levels} + 1;
    case Domain::closures: return sizes.closures;
    case Domain::closure_rows: return std::size_t{sizes.closures} * LINK_ROWS;
    case Domain::closure_entries: return std::size_t{sizes.closures} * LINK_ROWS * CLOSURE_STRIDE;
    case Domain::touches: return sizes.pairs;
    case Domain::events: return std::size_t{sizes.pairs} * 2;  // each pair that touches, and each that did
    case Domain::rays: return sizes.rays;
    case Domain::volumes: return sizes.volumes;
    case Domain::volume_ends: return std::size_t{sizes.volumes} + 1;
    case Domain::overlaps: return sizes.overlaps;
    case Domain::particles: return sizes.particles;
    case Domain::particle_ends: return std::size_t{sizes.particles} + 1;
    case Domain::particle_planes: return sizes.particle_planes;
    case Domain::springs: return sizes.pairs;
  }
  return 0;
}

std::size_t live(Domain domain, const Sizes& sizes, std::span<const u32> counters, u32 cached_count) {
  switch (domain) {
    case Domain::pairs: return std::min(counters[COUNTER_PAIRS], sizes.pairs);
    case Domain::pair_ends: return std::min<std::size_t>(counters[COUNTER_PAIRS], sizes.pairs) + 1;
    case Domain::contacts: return std::min(counters[COUNTER_CONTACTS], sizes.contacts);
    case Domain::blocks: return std::min(counters[COUNTER_BLOCKS], sizes.blocks);
    case Domain::rows: return std::min(counters[COUNTER_ROWS], sizes.rows);
    case Domain::coupled_tiles: return std::min(counters[COUNTER_COUPLED_TILES_NEEDED], sizes.coupled_tiles);
    case Domain::cached: return std::min(cached_count, sizes.contacts);
    case Domain::events: return std::min<std::size_t>(counters[COUNTER_EVENTS], capacity(domain, sizes));
    default: return capacity(domain, sizes);
  }
}

template <class real>
void resize(Buffers<real>& buffers, const Sizes& sizes, Features features) {
  for_each_buffer(buffers, [&](Buffer buffer, auto& elements) {
    elements.resize(has(features, info(buffer).feature) ? capacity(info(buffer).domain, sizes) : 0);
  });
}

template <class real>
Buffers<real>::Buffers() = default;
template <class real>
Buffers<real>::Buffers(const Buffers&) = default;
template <class real>
Buffers<real>::Buffers(Buffers&&) noexcept = default;
template <class real>
Buffers<real>& Buffers<real>::operator=(const Buffers&) = default;
template <class real>
Buffers<real>& Buffers<real>::operator=(Buffers&&) noexcept = default;
template <class real>
Buffers<real>::~Buffers() = default;

template struct Buffers<float>;
template struct Buffers<double>;
template void resize<float>(Buffers<float>&, const Sizes&, Features);
template void resize<double>(Buffers<double>&, const Sizes&, Features);

}  // namespace lockstep
