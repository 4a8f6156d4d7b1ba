// Where shapes lie flush: part of kernels/types.h, which includes it.
#ifndef LOCKSTEP_SEAM_TYPES_H
#define LOCKSTEP_SEAM_TYPES_H

// Of a gap between shapes (feature seams), as shares of the length of half the box around what comes: how wide it may
// be for that to span it, and how deep below the edge that may be.
#define SEAM_SPAN 0.5f
#define SEAM_DIP 0.01f

// A shape that covers edges of another one while it does not move against it (feature seams), in the frame of that one:
// a box or a hull, its fields as those of ShapeInfo and Shape. Within `tolerance`, m, the two lie flush; `has_gap`:
// there is a gap between them.
LINE_RECORD(Seam) {
  real offset[3], tolerance;
  real rotation[4];
  real size[4];
  u32 kind, hull, has_gap, pad;
};

// Whose seam it is (feature moving_seams): of `shape`, with the shape `neighbour` of another body where one of the two
// bodies is kinematic, else NONE.
INDEX_RECORD(SeamSides) { u32 shape, neighbour; };

#endif
