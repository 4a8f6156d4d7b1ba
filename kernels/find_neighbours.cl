#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "shapes/may_touch.h"
#include "sort.h"
#include "tolerances.h"
#include "types.h"

// What a search reads.
typedef struct Search {
  u32 particles;
  global const WorldRange* worlds;
  global const ParticleLaw* laws;
  global const BodyInfo* body_infos;
  global const u32* bodies;
  global const Vec4* particle_positions;
  global const Vec4* velocities;
  global const Cell* cells;
  global const u32* starts;
  global const u32* items;
  global const u32* owners;
  global const u32* joined_starts;
  global const u32* joined_bodies;
  global const ParticlePlane* planes;
  global const u32* plane_bodies;
  global const Vec4* positions;
  global const Vec4* orientations;
  global const Motion* motions;
} Search;

static inline bool are_joined(const Search* s, u32 body_a, u32 body_b) {
#if FEATURE_JOINTS
  for (u32 k = s->joined_starts[body_a]; k < s->joined_starts[body_a + 1u]; ++k)
    if (s->joined_bodies[k] == body_b) return true;
#endif
  return false;
}

static inline bool are_neighbours(const Search* s, const StepParams* params, u32 i, u32 j) {
  const u32 body_i = s->bodies[i], body_j = s->bodies[j], world = s->body_infos[body_i].world;
  if (body_i == body_j || s->body_infos[body_j].world != world || are_joined(s, body_i, body_j)) return false;
  const Vec3 d = sub3(vec3_of(s->particle_positions[i]), vec3_of(s->particle_positions[j]));
  const Vec3 u = sub3(vec3_of(s->velocities[i]), vec3_of(s->velocities[j]));
  const real radius = s->laws[world].radius;
  return within_range(params, pair_margin(params, own_margin(params, radius, radius), (real)0),
                      length3(d) - (real)2 * radius, length3(u));
}

static inline bool is_near_plane(const Search* s, const StepParams* params, u32 i, u32 k) {
  const u32 body = s->bodies[i], body_p = s->plane_bodies[k];
  if (are_joined(s, body, body_p)) return false;
  const Vec3 x = vec3_of(s->particle_positions[i]), x_p = vec3_of(s->positions[body_p]);
  const CurrentPlane plane = current_plane(s->planes[k], x_p, quat(s->orientations[body_p]));
  const Vec3 there = point_velocity(&s->motions[body_p], sub3(x, x_p));
  const real radius = s->laws[s->body_infos[body].world].radius;
  const real gap = dot3(plane.normal, sub3(x, plane.point)) - radius;
  return within_range(params, pair_margin(params, own_margin(params, radius, radius), (real)0), gap,
                      length3(sub3(vec3_of(s->velocities[i]), there)));
}

// Counts the neighbours of particle i, and writes them where there is a list: particles by cells, planes in order.
static inline u32 search_neighbours(const Search* s, const StepParams* params, u32 i, global u32* list) {
  const Cell cell = s->cells[i];
  const u32 body = s->bodies[i];
  const BodyInfo info = s->body_infos[body];
  u32 count = 0u;
  if (cell.bucket == NONE || info.kind != BODY_DYNAMIC) return 0u;
  for (i32 z = cell.z - 1; z <= cell.z + 1; ++z) {
    for (i32 y = cell.y - 1; y <= cell.y + 1; ++y) {
      const u32 row = row_hash(y, z, info.world);
      for (i32 x = cell.x - 1; x <= cell.x + 1; ++x) {
        const u32 bucket = bucket_of(x, row, params->buckets), owner = s->owners[bucket];
        if (owner == NONE || owner == body) continue;
        for (u32 k = s->starts[bucket]; k < s->starts[bucket + 1u]; ++k) {
          const u32 j = s->items[k];
          const Cell other = s->cells[j];
          const bool is_there = other.x == x && other.y == y && other.z == z;
          if (!is_there || !are_neighbours(s, params, i, j)) continue;
          if (list != 0) list[count] = j;
          ++count;
        }
      }
    }
  }
  if (list != 0) sort_ascending(list, count);
  const WorldRange world = s->worlds[info.world];
  for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {
    if (!is_near_plane(s, params, i, k)) continue;
    if (list != 0) list[count] = s->particles + k;
    ++count;
  }
  return count;
}

// Whose particles a bucket holds: of one body, of several (which is no body's index), or of none. Most are one body's,
// and a particle has nothing to look for in those of its own.
kernel void find_neighbours_owners(global const u32* particle_bodies, global const u32* particle_starts,
                                   global const u32* particle_items, global u32* bucket_owners,
                                   const StepParams params) {
  FOR_EACH(k, params.buckets) {
    u32 owner = NONE;
    for (u32 slot = particle_starts[k]; slot < particle_starts[k + 1u]; ++slot) {
      const u32 body = particle_bodies[particle_items[slot]];
      owner = owner == NONE || owner == body ? body : params.bodies;
    }
    bucket_owners[k] = owner;
  }
}

kernel void find_neighbours_count(global const WorldRange* world_ranges, global const ParticleLaw* particle_laws,
                                  global const BodyInfo* body_infos, global const u32* body_particles,
                                  global const u32* particle_bodies, global const ParticlePlane* particle_planes,
                                  global const u32* plane_bodies, global const Vec4* positions,
                                  global const Vec4* orientations, global const Motion* motions,
                                  global const Vec4* particle_positions, global const Vec4* particle_velocities,
                                  global const Cell* particle_cells, global const u32* particle_starts,
                                  global const u32* particle_items, global const u32* bucket_owners,
                                  global const u32* joined_starts, global const u32* joined_bodies,
                                  global u32* neighbour_starts, const StepParams params) {
  const u32 particles = body_particles[params.bodies];
  const Search s = {particles,          world_ranges,        particle_laws,  body_infos,      particle_bodies,
                    particle_positions, particle_velocities, particle_cells, particle_starts, particle_items,
                    bucket_owners,      joined_starts,       joined_bodies,  particle_planes, plane_bodies,
                    positions,          orientations,        motions};
  FOR_EACH(i, particles + 1u) { neighbour_starts[i] = i < particles ? search_neighbours(&s, &params, i, 0) : 0u; }
}

// After the scan of neighbour_starts.
kernel void find_neighbours_write(
    global const WorldRange* world_ranges, global const ParticleLaw* particle_laws, global const BodyInfo* body_infos,
    global const u32* body_particles, global const u32* particle_bodies, global const ParticlePlane* particle_planes,
    global const u32* plane_bodies, global const Vec4* positions, global const Vec4* orientations,
    global const Motion* motions, global const Vec4* particle_positions, global const Vec4* particle_velocities,
    global const Cell* particle_cells, global const u32* particle_starts, global const u32* particle_items,
    global const u32* bucket_owners, global const u32* joined_starts, global const u32* joined_bodies,
    global const u32* neighbour_starts, global u32* neighbours, global u32* counters, const StepParams params) {
  const u32 particles = body_particles[params.bodies];
  const Search s = {particles,          world_ranges,        particle_laws,  body_infos,      particle_bodies,
                    particle_positions, particle_velocities, particle_cells, particle_starts, particle_items,
                    bucket_owners,      joined_starts,       joined_bodies,  particle_planes, plane_bodies,
                    positions,          orientations,        motions};
  const u32 total = neighbour_starts[particles];
  const bool full = total > params.pair_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_PAIRS_NEEDED] = total;
    counters[COUNTER_PAIRS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
  }
  FOR_EACH(i, full ? 0u : particles) {
    if (neighbour_starts[i + 1u] == neighbour_starts[i]) continue;
    global u32* list = neighbours + neighbour_starts[i];
    search_neighbours(&s, &params, i, list);
  }
}
