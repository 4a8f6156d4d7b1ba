// The buffers of a simulation: one table (buffers.def) feeds the names, the reference's storage and the device's.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "host/features.hpp"
#include "kernels/types.h"

namespace lockstep {

/// What the elements of a buffer belong to.
enum class Domain : u32 {
  one,
  counters,
  worlds,
  bodies,
  body_lines,
  body_masks,
  shapes,
  shape_ends,
  top_level,
  shape_trees,
  tree_shapes,
  shape_tree_blocks,
  planes,
  hulls,
  hull_vertices,
  hull_faces,
  hull_edges,
  hull_corners,
  facets,
  facet_edges,
  seams,
  materials,
  buckets,
  tree_blocks,
  pairs,
  pair_ends,
  contacts,
  colors,
  cell_ends,
  blocks,
  rows,
  tiles,
  tile_ends,
  coupled_tiles,
  cached,
  slept,
  joints,
  joint_phases,
  joint_blocks,
  joined,
  body_joints,
  planar_joints,
  couplings,
  coupled_joints,
  coupling_phases,
  articulations,
  links,
  link_levels,
  closures,
  closure_rows,
  closure_entries,
  touches,
  events,
  rays,
  volumes,
  volume_ends,
  overlaps,
  particles,
  particle_ends,
  particle_planes,
  springs
};

enum class Lifetime : u32 { constant, persistent, transient };

enum class Buffer : u32 {
#define BUFFER(name, ...) name,
#include "host/buffers.def"
#undef BUFFER
  count
};

constexpr u32 buffer_count = static_cast<u32>(Buffer::count);

struct BufferInfo {
  std::string_view name;
  Domain domain;
  Lifetime lifetime;
  Feature feature;
  std::size_t float_bytes, double_bytes;  // of an element, by precision

  template <class real>
  constexpr std::size_t element_bytes() const {
    return sizeof(real) == 4 ? float_bytes : double_bytes;
  }
};

/// Storage of the reference backend, and the host's image of what a scene compiles to. Copies are made in one place:
/// with so many members they are most of what a file that makes one compiles.
template <class real>
struct Buffers {
  Buffers();
  Buffers(const Buffers&);
  Buffers(Buffers&&) noexcept;
  Buffers& operator=(const Buffers&);
  Buffers& operator=(Buffers&&) noexcept;
  ~Buffers();

#define BUFFER(name, element, ...) std::vector<element> name;
#include "host/buffers.def"
#undef BUFFER
};

/// How many elements each domain can hold. Lists grow when a step or a query asks for more.
struct Sizes {
  u32 worlds = 0, bodies = 0, shapes = 0, planes = 0, material_pairs = 0, buckets = 0;
  u32 tree_shapes = 0, shape_trees = 0, shape_tree_blocks = 0;
  u32 hulls = 0, hull_vertices = 0, hull_faces = 0, hull_edges = 0, hull_corners = 0;
  u32 facets = 0, facet_edges = 0, seams = 0;
  u32 pairs = 0, contacts = 0, blocks = 0, rows = 0, coupled_tiles = 0;
  u32 joints = 0, joint_phases = 0, joint_blocks = 0, joined = 0, body_joints = 0, planar_joints = 0;
  u32 couplings = 0, coupled_joints = 0, coupling_phases = 0;
  u32 articulations = 0, links = 0, link_levels = 0, closures = 0;
  u32 closure_columns = 0;  // answers of links to rows of closures, of all articulations
  u32 rays = 0, volumes = 0, overlaps = 0;
  u32 particles = 0, particle_planes = 0;

  /// Shapes that the broad phase looks at one by one: those of no tree.
  u32 top_level() const { return shapes - tree_shapes; }
  bool operator==(const Sizes&) const = default;
};

/// Blocks of all levels of the tree of bounds: a block of the lowest level holds the boxes of PACK runs of PACK shapes.
u32 tree_block_count(u32 shapes);

/// Tiles of so many contacts, of which each world begins one of its own.
u32 tile_count(u32 contacts, u32 worlds);

/// Places for the cells of one phase of a sweep, those of all worlds (cpu_reference/solver_cell.hpp).
constexpr u32 cells_in_phase(u32 bodies, u32 worlds) { return bodies / CELL_BODIES + worlds; }

/// Elements that a buffer of this domain is allocated with.
std::size_t capacity(Domain domain, const Sizes& sizes);

/// Elements that hold results after a stage, from the counters and the cache count of that moment.
std::size_t live(Domain domain, const Sizes& sizes, std::span<const u32> counters, u32 cached_count);

const BufferInfo& info(Buffer buffer);

/// Calls `function(Buffer, vector)` for each buffer in table order.
template <class real, class Function>
void for_each_buffer(Buffers<real>& buffers, Function&& function) {
#define BUFFER(name, ...) function(Buffer::name, buffers.name);
#include "host/buffers.def"
#undef BUFFER
}
template <class real, class Function>
void for_each_buffer(const Buffers<real>& buffers, Function&& function) {
#define BUFFER(name, ...) function(Buffer::name, buffers.name);
#include "host/buffers.def"
#undef BUFFER
}

/// Gives every buffer of the features its capacity; new elements are zero. Constant and persistent contents are kept.
template <class real>
void resize(Buffers<real>& buffers, const Sizes& sizes, Features features);

}  // namespace lockstep
