// Which particles of other bodies, and which planes, can touch a particle within the step: of each particle of a
// dynamic body a list of its own, in order of their indices, so that it can add up what acts on it. Planes come behind
// all particles: plane k is `particles` + k.
#pragma once

#include <algorithm>

#include "cpu_reference/pair_test.hpp"
#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

/// Symmetric in i and j to the last bit, as shapes_in_range is.
template <class real>
bool are_neighbours(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 j) {
  const u32 body_i = b.particle_bodies[i], body_j = b.particle_bodies[j], world = b.body_infos[body_i].world;
  if (body_i == body_j || b.body_infos[body_j].world != world || are_joined(b, body_i, body_j)) return false;
  const Vec3<real> d = sub3(vec3_of(b.particle_positions[i]), vec3_of(b.particle_positions[j]));
  const Vec3<real> u = sub3(vec3_of(b.particle_velocities[i]), vec3_of(b.particle_velocities[j]));
  const real radius = b.particle_laws[world].radius;
  return within_range(params, pair_margin(params, own_margin(params, radius, radius), real(0)),
                      length3(d) - real(2) * radius, length3(u));
}

template <class real>
bool is_near_plane(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 k) {
  const u32 body = b.particle_bodies[i], body_p = b.plane_bodies[k];
  if (are_joined(b, body, body_p)) return false;
  const Vec3<real> x = vec3_of(b.particle_positions[i]);
  const CurrentPlane<real> plane = current_plane(b, k);
  const Vec3<real> there = point_velocity(b.motions[body_p], sub3(x, vec3_of(b.positions[body_p])));
  const real radius = b.particle_laws[b.body_infos[body].world].radius;
  const real gap = dot3(plane.normal, sub3(x, plane.point)) - radius;
  return within_range(params, pair_margin(params, own_margin(params, radius, radius), real(0)), gap,
                      length3(sub3(vec3_of(b.particle_velocities[i]), there)));
}

/// Appends the neighbours of particle i: particles cell by cell, then planes.
template <class real>
void search_neighbours(const Buffers<real>& b, const StepParams<real>& params, u32 i, std::vector<u32>& found) {
  const Cell cell = b.particle_cells[i];
  const BodyInfo& info = b.body_infos[b.particle_bodies[i]];
  if (cell.bucket == NONE || info.kind != BODY_DYNAMIC) return;
  for (i32 z = cell.z - 1; z <= cell.z + 1; ++z) {
    for (i32 y = cell.y - 1; y <= cell.y + 1; ++y) {
      for (i32 x = cell.x - 1; x <= cell.x + 1; ++x) {
        const u32 bucket = bucket_of(x, row_hash(y, z, info.world), params.buckets);
        for (u32 k = b.particle_starts[bucket]; k < b.particle_starts[bucket + 1]; ++k) {
          const u32 j = b.particle_items[k];
          const Cell& other = b.particle_cells[j];
          const bool is_there = other.x == x && other.y == y && other.z == z;  // cells share buckets
          if (is_there && are_neighbours(b, params, i, j)) found.push_back(j);
        }
      }
    }
  }
  const WorldRange& world = b.world_ranges[info.world];
  for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k)
    if (is_near_plane(b, params, i, k)) found.push_back(static_cast<u32>(b.particle_bodies.size()) + k);
}

/// Where the lists are longer than the capacity of pairs none is kept, and the step is aborted.
template <class real>
void find_neighbours(Buffers<real>& b, const StepParams<real>& params) {
  u32 total = 0;
  std::vector<u32> found;
  const u32 count = static_cast<u32>(b.particle_bodies.size());
  for (u32 i = 0; i < count; ++i) {
    found.clear();
    search_neighbours(b, params, i, found);
    std::sort(found.begin(), found.end());
    b.neighbour_starts[i] = total;
    for (const u32 j : found) {
      if (total < params.pair_capacity) b.neighbours[total] = j;
      ++total;
    }
  }
  b.neighbour_starts[count] = total;
  b.counters[COUNTER_PAIRS_NEEDED] = total;
  b.counters[COUNTER_PAIRS] = total <= params.pair_capacity ? total : 0;
  if (total > params.pair_capacity) b.counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
}

}  // namespace lockstep::reference
