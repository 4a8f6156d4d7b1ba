// Shares of the lengths that follow the sizes of shapes; tolerances.h and cpu_reference/tolerances.hpp use them.
#ifndef LOCKSTEP_TOLERANCE_SHARES_H
#define LOCKSTEP_TOLERANCE_SHARES_H

// What is left of the margin of shapes at rest, and how much of it what they move in a step gives back.
#define MARGIN_AT_REST 0.125
#define MARGIN_OF_MOTION 0.25

// A shape is thin where its bounding radius is more than so many inner radii; its slop is then that of a shape with
// SLOP_OF_WIDTH of the bounding radius beyond, and of no more than SLOP_OF_THIN inner radii.
#define THIN_ASPECT 30.0
#define SLOP_OF_WIDTH 0.5
#define SLOP_OF_THIN 50.0

#endif
