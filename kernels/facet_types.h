// Triangles of surfaces as bodies collide with them: part of kernels/types.h, which includes it.
#ifndef LOCKSTEP_FACET_TYPES_H
#define LOCKSTEP_FACET_TYPES_H

#define HULL_IS_FACET 0x80000000u
#define FACET_CORNER(facet, k) ((facet) << 2 | (k))
// What a facet says of its edge k and its corner k.
#define FACET_OWNS_EDGE(k) (1u << (k))        // no other facet tells of contacts there
#define FACET_OWNS_CORNER(k) (8u << (k))      // nor there
#define FACET_IS_AT_RIM(k) (64u << (k))       // the surface ends at corner k
#define FACET_CORNER_COUNTS(k) (512u << (k))  // it does, or no vertex around corner k rises above it, and some fall
#define FACET_EDGE_SHIFT(k) (12u + 2u * (k))  // from here on the FacetEdgeKind of edge k, two bits
enum FacetEdgeKind {
  FACET_EDGE_FLAT = 0,   // the other side is level, or rises: its own normal counts as that on both sides
  FACET_EDGE_ROOF = 1,   // the two sides meet like a roof
  FACET_EDGE_STORED = 2  // a FacetEdge says what is across
};

// A triangle of a surface in the frame of its shape, a hull of one face that knows what is around it (feature facets).
// Edge k runs from corner k to the next. `next` of corner k is FACET_CORNER of the one that follows it around their
// vertex: clockwise seen from outside, so that the two facets share edge k. At an edge that is FACET_EDGE_STORED it is
// the index of a FacetEdge instead, which has the corner that follows.
RECORD(Facet) {
  real corners[9];         // x y z of each, counter-clockwise seen from outside
  real normal[3], height;  // its plane is normal . x = height
  u32 next[3];
  u32 flags;  // FACET_..., or-ed
};

// What is across an edge of a facet where that is no normal of a neighbour, and the corner that follows.
RECORD(FacetEdge) {
  real across[3];
  u32 next, pad;
};

#endif
