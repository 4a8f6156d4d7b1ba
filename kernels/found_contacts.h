// What collide has found at a pair, ready to be put into the list of contacts once its slot is known.
#ifndef LOCKSTEP_FOUND_CONTACTS_H
#define LOCKSTEP_FOUND_CONTACTS_H

#include "shapes/manifold.h"

typedef struct FoundContacts {
  real points[PAIR_POINTS][8];  // the first eight reals of a ContactPoint
  real normal[4];
  Contact contact;  // of all points: without feature and rank
  u32 features[4];
} FoundContacts;

static inline void found_store3(Vec3 v, global real* p) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}

static inline Contact found_contact(Pair pair, u32 body_a, u32 body_b, u32 world, u32 frame) {
  const Contact contact = {pair.shape_a, pair.shape_b, 0u, body_a, body_b, world, 0u, frame};
  return contact;
}

// A manifold, about the centres of its shapes, in the frames of the bodies.
static inline void found_store(global FoundContacts* found, const Manifold* m, Quat orientation_a, Vec3 offset_a,
                               Quat orientation_b, Vec3 offset_b) {
  Vec3 normal = m->normal;
  if (m->frame == NORMAL_OF_A) normal = unrotate3(orientation_a, normal);
  if (m->frame == NORMAL_OF_B) normal = unrotate3(orientation_b, normal);
  found_store3(normal, found->normal);
  found->normal[3] = (real)0;
  for (u32 k = 0u; k < m->count; ++k) {
    found_store3(add3(offset_a, unrotate3(orientation_a, m->points[k].anchor_a)), found->points[k]);
    found->points[k][3] = m->radius_a;
    found_store3(add3(offset_b, unrotate3(orientation_b, m->points[k].anchor_b)), found->points[k] + 4);
    found->points[k][7] = m->radius_b;
    found->features[k] = m->points[k].feature;
  }
}

#endif
