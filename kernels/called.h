// Which functions stay functions.
#ifndef LOCKSTEP_CALLED_H
#define LOCKSTEP_CALLED_H

// One that is compiled once, where a work-item is one pair: compilers of GPUs inline all others at every place where
// they are called, and would take minutes for a kernel of cylinders, hulls and seams. What is larger than a vector goes
// to it by address: to copy it in takes as many instructions as the work.
#if LANES == 1
#define CALLED static __attribute__((noinline))
#else
#define CALLED static inline
#endif

#endif
