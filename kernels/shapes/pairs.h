// The dispatch over shape pairs. cpu_reference/shapes/pairs.hpp is the twin.
#ifndef LOCKSTEP_PAIRS_H
#define LOCKSTEP_PAIRS_H

#include "shapes/box_box.h"
#include "shapes/box_round.h"
#include "shapes/capsule_box.h"
#include "shapes/capsules.h"
#include "shapes/patch_pairs.h"
#include "shapes/seam_pairs.h"
#include "shapes/sphere_cylinder.h"
#include "shapes/sphere_hull.h"
#include "shapes/sphere_plane.h"
#include "shapes/sphere_sphere.h"

// Pairs of kinds that the scene lacks are not compiled.
#define HAS_SPHERE 1
#define HAS_CAPSULE FEATURE_CAPSULES
#define HAS_BOX FEATURE_BOXES
#define HAS_CYLINDER FEATURE_CYLINDERS
#define HAS_HULL FEATURE_HULLS
#define HAS_PLANE 1

// Where impacts are looked for, several places call it.
#if FEATURE_CONTINUOUS
CALLED
#else
static inline
#endif
Manifold collide_shapes(u32 kind_a, const WorldShape* shape_a, u32 kind_b, const WorldShape* shape_b,
                        const HullTables* tables, real limit) {
  const bool swapped = kind_a > kind_b;
  WorldShape first = *shape_a, second = *shape_b;
  if (swapped) {
    first = *shape_b;
    second = *shape_a;
    const u32 kind = kind_a;
    kind_a = kind_b;
    kind_b = kind;
  }
  const WorldShape *a = &first, *b = &second;
  Manifold m = no_manifold();
  bool by_patches = false;
#define SHAPE_PAIR(first, second, manifold) \
  if (HAS_##first && HAS_##second && kind_a == SHAPE_##first && kind_b == SHAPE_##second) m = manifold;
#define PATCH_PAIR(first, second) \
  if (HAS_##first && HAS_##second && kind_a == SHAPE_##first && kind_b == SHAPE_##second) by_patches = true;
#include "shape_pairs.def"
#undef SHAPE_PAIR
#undef PATCH_PAIR
  if (by_patches) m = patches_touch(kind_a, a, kind_b, b, tables, limit);
#if FEATURE_SEAMS
  if (seams_cover_all(kind_a, a, kind_b, b, tables, &m)) m = touch_over_seams(kind_a, a, kind_b, b, tables, limit);
#endif
  if (swapped) flip(&m);
  return m;
}

#endif
