#include "host/record/state_group.hpp"

#include <algorithm>

#include "host/record/layout.hpp"
#include "host/record/stored_name.hpp"
#include "host/scene/compile_articulations.hpp"
#include "host/scene/step_params.hpp"

namespace lockstep {

namespace {

template <class real>
void write_buffers(hid_t group, const Buffers<real>& buffers, Lifetime lifetime, Features features) {
  for_each_buffer(buffers, [&](Buffer buffer, const auto& elements) {
    if (info(buffer).lifetime != lifetime || !has(features, info(buffer).feature)) return;
    const Words<real> words(buffer);
    const auto write = words.integers ? h5::write_words<u32> : h5::write_words<real>;
    write(group, stored_name(buffer).data(), elements.data(), rows_in_use(buffer, buffers, elements.size()),
          words.columns);
  });
}

template <class real>
void read_buffer(hid_t group, Buffer buffer, void* elements, std::size_t rows) {
  const Words<real> words(buffer);
  const auto read = words.integers ? h5::read_words<u32> : h5::read_words<real>;
  read(group, stored_name(buffer).data(), elements, rows, words.columns);
}

// How many records of a buffer are stored; 0 where the scene has none.
u32 stored_rows(hid_t group, Buffer buffer) {
  const char* name = stored_name(buffer).data();
  if (!h5::has(group, name)) return 0;
  const h5::Handle dataset = h5::open_dataset(group, name);
  const std::vector<hsize_t> extent = h5::extent_of(dataset);
  if (extent.size() != 2 || extent[0] >= NONE) throw h5::Failed(std::string(name) + " has no shape of a buffer");
  // what a file says is there must be there: nobody is to ask for more memory than the file is long
  if (H5Dget_storage_size(dataset) < extent[0] * sizeof(u32)) throw h5::Failed(std::string(name) + " is not all there");
  return static_cast<u32>(extent[0]);
}

Sizes stored_sizes(hid_t group, Features features) {
  Sizes sizes;
  sizes.worlds = stored_rows(group, Buffer::world_ranges);
  sizes.bodies = stored_rows(group, Buffer::body_infos);
  sizes.shapes = stored_rows(group, Buffer::shape_infos);
  sizes.planes = stored_rows(group, Buffer::planes);
  sizes.material_pairs = stored_rows(group, Buffer::material_pairs);
  sizes.tree_shapes = stored_rows(group, Buffer::shape_tree_items);
  sizes.shape_trees = stored_rows(group, Buffer::shape_trees);
  sizes.shape_tree_blocks = stored_rows(group, Buffer::shape_tree_blocks);
  sizes.hulls = stored_rows(group, Buffer::hulls);
  sizes.hull_vertices = stored_rows(group, Buffer::hull_vertices);
  sizes.hull_faces = stored_rows(group, Buffer::hull_faces);
  sizes.hull_edges = stored_rows(group, Buffer::hull_edges);
  sizes.hull_corners = stored_rows(group, Buffer::hull_corners);
  sizes.facets = stored_rows(group, Buffer::facets);
  sizes.facet_edges = stored_rows(group, Buffer::facet_edges);
  sizes.seams = stored_rows(group, Buffer::seams);
  sizes.joints = stored_rows(group, Buffer::joint_infos);
  sizes.joint_blocks = stored_rows(group, Buffer::joint_lanes);
  const u32 phases = stored_rows(group, Buffer::joint_phases);  // one more than there are
  sizes.joint_phases = phases > 0 ? phases - 1 : 0;
  sizes.joined = stored_rows(group, Buffer::joined_bodies);
  sizes.body_joints = stored_rows(group, Buffer::body_joints);
  sizes.planar_joints = stored_rows(group, Buffer::planar_joints);
  sizes.couplings = stored_rows(group, Buffer::couplings);
  sizes.coupled_joints = stored_rows(group, Buffer::coupled_joints);
  const u32 coupling_phases = stored_rows(group, Buffer::coupling_phases);  // one more than there are
  sizes.coupling_phases = coupling_phases > 0 ? coupling_phases - 1 : 0;
  sizes.articulations = stored_rows(group, Buffer::articulations);
  sizes.links = stored_rows(group, Buffer::links);
  const u32 level_ends = stored_rows(group, Buffer::link_levels);  // one more than there are levels
  sizes.link_levels = level_ends > 0 ? level_ends - 1 : 0;
  sizes.closures = stored_rows(group, Buffer::closures);
  sizes.particles = stored_rows(group, Buffer::particle_bodies);
  sizes.particle_planes = stored_rows(group, Buffer::plane_bodies);
  if (sizes.worlds == 0 || sizes.bodies == 0) throw h5::Failed("has no bodies");
  if (sizes.tree_shapes > sizes.shapes) throw h5::Failed("has more shapes in trees than shapes");
  if (std::max(sizes.shapes, sizes.particles) > (NONE >> 8)) throw h5::Failed("has more shapes than there can be");
  set_first_capacities(sizes, features);
  return sizes;
}

}  // namespace

std::string read_precision(hid_t file) {
  std::string precision = h5::read_text_attribute(file, "precision");
  if (precision != "float" && precision != "double") throw h5::Failed("precision is neither float nor double");
  return precision;
}

template <class real>
void write_constants(hid_t group, const InitialState<real>& state) {
  h5::write_attribute(group, "features", state.features);
  for_each_setting(state.params, [&](const char* name, auto value) { h5::write_attribute(group, name, value); });
  if (state.oracle) {
    h5::write_attribute(group, "oracle", state.oracle.name);
    h5::write_attribute(group, "directions", state.oracle.directions);
  }
  write_buffers(group, state.buffers, Lifetime::constant, state.features);
}

OracleChoice read_oracle(hid_t group) {
  if (!h5::has_attribute(group, "oracle")) return {};
  return {h5::read_text_attribute(group, "oracle"), h5::read_attribute<u32>(group, "directions")};
}

template <class real>
InitialState<real> read_constants(hid_t group) {
  InitialState<real> state;
  state.features = h5::read_attribute<Features>(group, "features");
  for_each_setting(state.params, [&](const char* name, auto& value) {
    value = h5::read_attribute<std::decay_t<decltype(value)>>(group, name);
  });
  state.oracle = read_oracle(group);
  state.sizes = stored_sizes(group, state.features);
  set_sizes(state.params, state.sizes);
  resize(state.buffers, state.sizes, state.features);
  for_each_buffer(state.buffers, [&](Buffer buffer, auto& elements) {
    if (info(buffer).lifetime == Lifetime::constant && has(state.features, info(buffer).feature))
      read_buffer<real>(group, buffer, elements.data(), elements.size());
  });
  state.sizes.closure_columns = count_closure_columns(state.buffers.closure_sets, state.sizes.links);
  return state;
}

template <class real>
void write_persistent(hid_t group, const Buffers<real>& buffers, Features features) {
  write_buffers(group, buffers, Lifetime::persistent, features);
}

template <class real>
void read_persistent(hid_t group, InitialState<real>& state) {
  const auto in_blocks = [](u32 count) { return (count + PACK - 1) / PACK * PACK; };
  for (const Buffer list : {Buffer::cached_keys, Buffer::slept_keys})
    state.sizes.contacts = std::max(state.sizes.contacts, in_blocks(stored_rows(group, list)));
  for (const Buffer list : {Buffer::touching, Buffer::spring_keys})
    state.sizes.pairs = std::max(state.sizes.pairs, in_blocks(stored_rows(group, list)));
  set_sizes(state.params, state.sizes);
  resize(state.buffers, state.sizes, state.features);
  for_each_buffer(state.buffers, [&](Buffer buffer, auto& elements) {
    if (info(buffer).lifetime != Lifetime::persistent || !has(state.features, info(buffer).feature)) return;
    // the counts come first in the table, so that they say how much of their lists there is
    read_buffer<real>(group, buffer, elements.data(), rows_in_use(buffer, state.buffers, elements.size()));
  });
}

#define INSTANTIATE(real)                                                      \
  template void write_constants<real>(hid_t, const InitialState<real>&);       \
  template InitialState<real> read_constants<real>(hid_t);                     \
  template void write_persistent<real>(hid_t, const Buffers<real>&, Features); \
  template void read_persistent<real>(hid_t, InitialState<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
