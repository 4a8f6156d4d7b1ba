#pragma OPENCL FP_CONTRACT OFF
// The pairs of boxes among the pairs, in lanes: first the separating axis of each, then those that meet on a face and
// those that meet on edges, each from a list of their own, so that no lane waits for another case. The order of a list
// depends on chance, what is made of its members does not. The same as collide_pairs does, bit for bit.
#include "common.h"
#include "grid.h"
#include "lane_math.h"
#include "shapes/box_box.h"
#include "shapes/manifold.h"
#include "types.h"

// What is read of a box: three half lines of eight reals.
typedef struct BoxLine {
  real arm[3], reach;  // from the centre of mass to the centre of the shape, world axes
  real rotation[4];
  real size[3], pad_0;
  real position[3], pad_1;  // of the body
  real v[3], pad_2;
  real w[3], pad_3;
} BoxLine;
#define BOX_HALF_LINES 3u

// How many are in each list.
#define BOX_FACE_COUNT 0u
#define BOX_EDGE_COUNT 1u
#define BOX_COUNTS 2u

#if FEATURE_BOXES

kernel void collide_box_lines(global const ShapeInfo* shape_infos, global const Shape* shapes,
                              global const Vec4* positions, global const Vec4* orientations,
                              global const Motion* motions, global BoxLine* box_lines, global u32* box_counts,
                              const StepParams params) {
  if (get_global_id(0) == 0) {
    for (u32 k = 0u; k < BOX_COUNTS; ++k) box_counts[k] = 0u;
  }
  FOR_EACH(i, params.shapes) {
    const ShapeInfo info = shape_infos[i];
    if (info.kind != SHAPE_BOX) continue;
    const Pose pose = make_pose(positions[info.body], orientations[info.body]);
    const Vec3 arm = rotate3(pose.orientation, make3(shapes[i].offset[0], shapes[i].offset[1], shapes[i].offset[2]));
    const Quat turn = shape_rotation(pose, &shapes[i]);
    BoxLine line = {{arm.x, arm.y, arm.z},
                    shapes[i].reach,
                    {turn.x, turn.y, turn.z, turn.w},
                    {shapes[i].size[0], shapes[i].size[1], shapes[i].size[2]},
                    (real)0,
                    {pose.position.x, pose.position.y, pose.position.z},
                    (real)0,
                    {motions[info.body].v[0], motions[info.body].v[1], motions[info.body].v[2]},
                    (real)0,
                    {motions[info.body].w[0], motions[info.body].w[1], motions[info.body].w[2]},
                    (real)0};
    box_lines[i] = line;
  }
}

// One side of LANES pairs.
typedef struct BoxSide {
  LaneBox box;
  Lane3 arm, position, v, w;
  lane reach;
} BoxSide;

static inline BoxSide box_side(global const BoxLine* box_lines, const u32* shapes) {
  global const Real8* lines = (global const Real8*)box_lines;
  const LaneLines first = lane_gather_lines(lines, BOX_HALF_LINES, shapes);
  const LaneLines second = lane_gather_lines(lines + 1, BOX_HALF_LINES, shapes);
  const LaneLines third = lane_gather_lines(lines + 2, BOX_HALF_LINES, shapes);
  BoxSide side;
  side.arm = lane_make3(first.c0, first.c1, first.c2);
  side.reach = first.c3;
  side.box.rotation.x = first.c4;
  side.box.rotation.y = first.c5;
  side.box.rotation.z = first.c6;
  side.box.rotation.w = first.c7;
  side.box.extents = lane_make3(second.c0, second.c1, second.c2);
  side.position = lane_make3(second.c4, second.c5, second.c6);
  side.v = lane_make3(third.c0, third.c1, third.c2);
  side.w = lane_make3(third.c4, third.c5, third.c6);
  return side;
}

typedef struct BoxSides {
  BoxSide a, b;
  Lane3 apart;  // of the centres of mass, from b to a
} BoxSides;

static inline BoxSides box_sides(global const BoxLine* box_lines, const u32* shapes_a, const u32* shapes_b) {
  BoxSides sides;
  sides.a = box_side(box_lines, shapes_a);
  sides.b = box_side(box_lines, shapes_b);
  sides.apart = lane_sub3(sides.a.position, sides.b.position);
  sides.a.box.center = lane_make3(LANE_OF(0), LANE_OF(0), LANE_OF(0));
  sides.b.box.center = lane_sub3(sides.b.arm, lane_add3(sides.a.arm, sides.apart));
  return sides;
}

static inline Lane3 box_point_velocity(const BoxSide* side, Lane3 arm) {
  return lane_add3(side->v, lane_cross3(side->w, arm));
}

// As collide_limit.
static inline lane box_limit(StepParams params, const BoxSides* s) {
  const Lane3 arm_b = lane_add3(s->a.arm, s->apart);
  const Lane3 v = lane_sub3(box_point_velocity(&s->b, arm_b), box_point_velocity(&s->a, s->a.arm));
  const Lane3 w = lane_sub3(s->b.w, s->a.w);
  return LANE_OF(params.margin) + LANE_OF(step_length(params)) * (lane_length3(v) + lane_length3(w) * s->a.reach);
}

kernel void collide_box_axes(global const ShapeInfo* shape_infos, global const BoxLine* box_lines,
                             global const Pair* pairs, global u32* contact_starts, global u32* box_codes,
                             global u32* box_counts, global u32* box_faces_list, global u32* box_edges_list,
                             global u32* counters, const StepParams params) {
  const u32 count = counters[COUNTER_PAIRS];
  FOR_EACH(group, (count + LANES - 1u) / LANES) {
    u32 at[LANES], shapes_a[LANES], shapes_b[LANES];
    u32 boxes = 0u;
    for (u32 k = 0u; k < LANES; ++k) {
      const u32 p = group * LANES + k;
      at[k] = NONE;
      if (p >= count || !is_box_pair(shape_infos, pairs[p])) continue;
      at[boxes] = p;
      shapes_a[boxes] = pairs[p].shape_a;
      shapes_b[boxes++] = pairs[p].shape_b;
    }
    if (boxes == 0u) continue;
    for (u32 k = boxes; k < LANES; ++k) shapes_a[k] = shapes_a[0], shapes_b[k] = shapes_b[0];
    const BoxSides sides = box_sides(box_lines, shapes_a, shapes_b);
    const BoxPair pair = box_pair(&sides.a.box, &sides.b.box);
    lane code;
    const lane separation = box_axis(&sides.a.box, &sides.b.box, &pair, &code);
    real codes[LANES];
    LANE_STORE(code, codes);
    const u32 apart = LANE_BITS(separation > box_limit(params, &sides));
    const u32 on_edge = LANE_BITS(code >= LANE_OF(6));
    const u32 members = (1u << boxes) - 1u;
    const u32 faces = members & ~apart & ~on_edge, edges = members & ~apart & on_edge;
    u32 face = faces != 0u ? atomic_add(&box_counts[BOX_FACE_COUNT], popcount(faces)) : 0u;
    u32 edge = edges != 0u ? atomic_add(&box_counts[BOX_EDGE_COUNT], popcount(edges)) : 0u;
    atomic_add(&counters[COUNTER_BOX_PAIRS], boxes);
    for (u32 k = 0u; k < boxes; ++k) {
      box_codes[at[k]] = (u32)codes[k];
      if ((apart >> k & 1u) != 0u)
        contact_starts[at[k]] = 0u;
      else if ((on_edge >> k & 1u) != 0u)
        box_edges_list[edge++] = at[k];
      else
        box_faces_list[face++] = at[k];
    }
  }
}

// What collide_pair does behind collide_shapes: leaves out points that are out of reach, and puts the others in the
// order of their features; anchors of b are seen from its own centre.
static inline void box_store(StepParams params, const BoxSides* s, LaneManifold* m, const u32* at, u32 members,
                             global Manifold* manifolds, global u32* contact_starts) {
  const lane h = LANE_OF(step_length(params)), zero = LANE_OF(0), none = LANE_OF(BOX_NO_FEATURE);
  for (int k = 0; k < 4; ++k) {
    const Lane3 arm = lane_add3(s->a.arm, m->anchor_a[k]);
    const Lane3 u = lane_sub3(box_point_velocity(&s->b, lane_add3(arm, s->apart)), box_point_velocity(&s->a, arm));
    const lane approach = lane_dot3(m->normal, u), speed = approach > zero ? approach : zero;
    const lane gap = lane_dot3(m->normal, lane_sub3(m->anchor_a[k], m->anchor_b[k])) - zero - zero;
    m->feature[k] = gap <= LANE_OF(params.margin) + h * speed ? m->feature[k] : none;
    m->anchor_b[k] = lane_sub3(m->anchor_b[k], s->b.box.center);
  }
  real normal[3][LANES], anchors[4][6][LANES], features[4][LANES], frame[LANES];
  LANE_STORE(m->normal.x, normal[0]);
  LANE_STORE(m->normal.y, normal[1]);
  LANE_STORE(m->normal.z, normal[2]);
  LANE_STORE(m->frame, frame);
  for (int k = 0; k < 4; ++k) {
    LANE_STORE(m->anchor_a[k].x, anchors[k][0]);
    LANE_STORE(m->anchor_a[k].y, anchors[k][1]);
    LANE_STORE(m->anchor_a[k].z, anchors[k][2]);
    LANE_STORE(m->anchor_b[k].x, anchors[k][3]);
    LANE_STORE(m->anchor_b[k].y, anchors[k][4]);
    LANE_STORE(m->anchor_b[k].z, anchors[k][5]);
    LANE_STORE(m->feature[k], features[k]);
  }
  for (u32 l = 0u; l < members; ++l) {
    global Manifold* out = manifolds + at[l];
    u32 order[4];
    u32 points = 0u;
    for (u32 k = 0u; k < 4u; ++k) {
      if (!(features[k][l] < (real)BOX_NO_FEATURE)) continue;
      u32 place = points++;
      for (; place > 0u && features[order[place - 1u]][l] > features[k][l]; --place) order[place] = order[place - 1u];
      order[place] = k;
    }
    contact_starts[at[l]] = points;
    if (points == 0u) continue;
    out->normal = make3(normal[0][l], normal[1][l], normal[2][l]);
    out->frame = (u32)frame[l];
    out->radius_a = (real)0;
    out->radius_b = (real)0;
    out->count = points;
    for (u32 k = 0u; k < points; ++k) {
      const u32 from = order[k];
      out->points[k].anchor_a = make3(anchors[from][0][l], anchors[from][1][l], anchors[from][2][l]);
      out->points[k].anchor_b = make3(anchors[from][3][l], anchors[from][4][l], anchors[from][5][l]);
      out->points[k].feature = (u32)features[from][l];
    }
  }
}

// LANES members of a list; behind its end the last one is repeated, and not stored.
typedef struct BoxGroup {
  u32 at[LANES], members;
  BoxSides sides;
  BoxPair pair;
  lane code;
} BoxGroup;

static inline BoxGroup box_group(u32 first, u32 count, global const u32* list, global const Pair* pairs,
                                 global const u32* box_codes, global const BoxLine* box_lines) {
  BoxGroup group;
  u32 shapes_a[LANES], shapes_b[LANES];
  real codes[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    group.at[k] = list[first + k < count ? first + k : count - 1u];
    shapes_a[k] = pairs[group.at[k]].shape_a;
    shapes_b[k] = pairs[group.at[k]].shape_b;
    codes[k] = (real)box_codes[group.at[k]];
  }
  group.members = count - first < LANES ? count - first : LANES;
  group.sides = box_sides(box_lines, shapes_a, shapes_b);
  group.pair = box_pair(&group.sides.a.box, &group.sides.b.box);
  group.code = LANE_LOAD(codes);
  return group;
}

kernel void collide_box_faces(global const BoxLine* box_lines, global const Pair* pairs, global u32* contact_starts,
                              global const u32* box_codes, global const u32* box_counts,
                              global const u32* box_faces_list, global Manifold* manifolds, const StepParams params) {
  const u32 count = box_counts[BOX_FACE_COUNT];
  FOR_EACH(i, (count + LANES - 1u) / LANES) {
    const BoxGroup g = box_group(i * LANES, count, box_faces_list, pairs, box_codes, box_lines);
    LaneManifold m = box_faces(&g.sides.a.box, &g.sides.b.box, &g.pair, g.code, box_limit(params, &g.sides));
    box_store(params, &g.sides, &m, g.at, g.members, manifolds, contact_starts);
  }
}

kernel void collide_box_edges(global const BoxLine* box_lines, global const Pair* pairs, global u32* contact_starts,
                              global const u32* box_codes, global const u32* box_counts,
                              global const u32* box_edges_list, global Manifold* manifolds, const StepParams params) {
  const u32 count = box_counts[BOX_EDGE_COUNT];
  FOR_EACH(i, (count + LANES - 1u) / LANES) {
    const BoxGroup g = box_group(i * LANES, count, box_edges_list, pairs, box_codes, box_lines);
    LaneManifold m = box_edges(&g.sides.a.box, &g.sides.b.box, &g.pair, g.code);
    box_store(params, &g.sides, &m, g.at, g.members, manifolds, contact_starts);
  }
}

#endif
