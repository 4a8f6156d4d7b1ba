// Of both twins of fall_asleep, exact in float: lengths in parts of the radius of the body, angles of a radian.
#ifndef LOCKSTEP_REST_BOUNDS_H
#define LOCKSTEP_REST_BOUNDS_H

// How far a still body may be from where it began to be still: 2^-8.
#define REST_JITTER 3.90625e-03f
// What it may go on by in the time that it has been still: 2^-16.
#define REST_DRIFT 1.52587890625e-05f
// Square of the part of gravity and load that is left where they balance each other, but for rounding: 2^-40.
#define REST_BALANCE 9.094947017729282e-13f

#endif
