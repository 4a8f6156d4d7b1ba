// The records of the packed constraint stream: a part of types.h, which includes it in its place.
#ifndef LOCKSTEP_STREAM_TYPES_H
#define LOCKSTEP_STREAM_TYPES_H

// ---- the packed constraint stream: canonical cones ----------------------------------------------------------------

// A block has PACK lanes, a pair in contact each. Its members belong to one colour: no two share a movable body.
INDEX_RECORD(BlockBodies) {
  u32 body_a[PACK], body_b[PACK];  // the null body (index bodies) for padding
  u32 kind[PACK];                  // BlockKind
  u32 contact[PACK];               // the first of the pair; NONE for padding
  u32 count[PACK];                 // contacts of the pair; 0 for padding
};

// The rows of a block: row k, in contact_blocks and impulse_blocks, holds the k-th contact of each pair. Pairs of more
// points come first, so that a block has as many rows as its first lane has points.
INDEX_RECORD(BlockRows) { u32 first, count; };

// A row of contacts as the step finds them (ContactPoint), with the material of each pair.
RECORD(PointBlock) {
  real anchor_a_x[PACK], anchor_a_y[PACK], anchor_a_z[PACK], radius_a[PACK];
  real anchor_b_x[PACK], anchor_b_y[PACK], anchor_b_z[PACK], radius_b[PACK];
  real normal_x[PACK], normal_y[PACK], normal_z[PACK];
  real friction[PACK], restitution[PACK];
  // of the shape that is less deep, and of the smaller one, m; 0 where neither has an inside
  real inner_radius[PACK], bounding_radius[PACK];
  u32 frame[PACK];  // NormalFrame
};

// The axes of the cylinders of a row, unit, in the frames of their bodies; 0 of other shapes (feature foreseen_rims).
RECORD(RimBlock) {
  real axis_a_x[PACK], axis_a_y[PACK], axis_a_z[PACK];
  real axis_b_x[PACK], axis_b_y[PACK], axis_b_z[PACK];
};

// The laws of impact of a row of contacts (feature impact_laws), and the velocity that the law adds to the tangential
// ones of a sub-step, m/s: an impact that ends in a slide to elsewhere ends at -bias.
RECORD(ImpactBlock) {
  real tangential_restitution[PACK];
  u32 law[PACK];  // ImpactLaw
};
RECORD(SlideBlock) { real bias_1[PACK], bias_2[PACK]; };

// The impulses that a row of contacts starts the step from (ContactImpulse).
RECORD(StartBlock) { real normal[PACK], tangent_x[PACK], tangent_y[PACK], tangent_z[PACK]; };

// A row of contacts as a sub-step sees them. The tangents are recomputed from the normal.
RECORD(ContactBlock) {
  real normal_x[PACK], normal_y[PACK], normal_z[PACK];  // world frame, from b to a
  real arm_a_x[PACK], arm_a_y[PACK], arm_a_z[PACK];  // from the centre of mass of a to the contact point, world frame
  real arm_b_x[PACK], arm_b_y[PACK], arm_b_z[PACK];
  real bias[PACK];      // m/s, added to the normal relative velocity: u_n + bias >= 0
  real friction[PACK];  // mu
  real w_nn[PACK], w_11[PACK], w_22[PACK], w_n1[PACK], w_n2[PACK], w_12[PACK];  // Delassus block, 1/kg
};

// What is added to w_nn in the law of a soft contact, 1/kg: u_n + bias + softness r_n >= 0.
RECORD(SoftnessBlock) { real softness[PACK]; };

RECORD(ImpulseBlock) { real normal[PACK], tangent_1[PACK], tangent_2[PACK]; };

// What a row of contacts has given in the sub-steps of the step so far: on a, world frame, N s (feature
// summed_impulses).
RECORD(ImpulseSumBlock) { real x[PACK], y[PACK], z[PACK]; };

// A pair is hit where a point closes faster: this share of the bounding radius of its smaller shape, 1/s, and this one
// of the speed that its load takes from a contact in a sub-step.
#define HIT_SPEED_SHARE 0.1875f
#define HIT_LOAD_SHARE 0.25f

// What the normal impulses of two contacts of a pair make of each other's normal velocity, 1/kg (feature
// coupled_normals): what w_nn is of one, w_ij is of the i-th and the j-th. 0 where the pair has fewer.
RECORD(NormalCoupling) {
  real w_01[PACK], w_02[PACK], w_03[PACK], w_12[PACK], w_13[PACK], w_23[PACK];
  real hit_speed[PACK];  // m/s, of springs; negative from a solve on in which the pair is hit
};

// What the contacts of each pair share in a scene of patches: one friction block and a twist at the centre of pressure.
RECORD(PatchBlock) {
  real normal_x[PACK], normal_y[PACK], normal_z[PACK];  // world frame, from b to a
  real arm_a_x[PACK], arm_a_y[PACK], arm_a_z[PACK];     // from the centre of mass of a to that of pressure, world frame
  real arm_b_x[PACK], arm_b_y[PACK], arm_b_z[PACK];
  real friction[PACK];                                        // mu
  real distance[MANIFOLD_POINTS][PACK];                       // m, from the centre of pressure to each contact
  real inverse_11[PACK], inverse_12[PACK], inverse_22[PACK];  // of the tangential Delassus block, kg
  real inverse_twist[PACK];                                   // kg m^2
};

// What acts on a at the centre of pressure, its opposite on b: N s along the tangents, N m s about the normal.
RECORD(PatchImpulse) { real tangent_1[PACK], tangent_2[PACK], twist[PACK]; };

// The copy of each body that a pair is solved on (feature jacobi): a body in contact is as many as it has pairs.
RECORD(BodyCopyBlock) {
  real copies_a[PACK], copies_b[PACK];  // pairs that the body has; 0 of bodies that cannot move, and of padding
  u32 slot_a[PACK], slot_b[PACK];       // where the pair's copy of the body stands; NONE where it has none
};

// A tile is PACK contacts of a world, in the order of their list; the last of a world may have fewer (feature dense).
// Tiles of a world follow one another, and some that nobody has have a count of 0.
INDEX_RECORD(ContactTile) { u32 first, count; };

// Tiles of which some contacts share a movable body: what is done in `column` is felt in `row`. Those of a column are
// tile_starts[column] ... tile_starts[column + 1] - 1, in the order of the rows, the column itself among them.
INDEX_RECORD(CoupledTiles) { u32 row, column; };

// How a scene's convex problem is descended (feature gradient; cpu_reference/gradient/descent.hpp).
INDEX_RECORD(GradientLaw) {
  u32 accelerated;  // 1: with momentum; 0: straight along the projected gradient
};

// Where the sides of a block of joints stand among all sides of joints: those of body i are joint_side_starts[i] ...
// joint_side_starts[i + 1] - 1, in the order of the joints (feature gradient). NONE of bodies that cannot move.
INDEX_RECORD(JointSideSlots) { u32 slot_a[PACK], slot_b[PACK]; };

#endif
