// What the canary computes from operand set i; the result of case k is results[k * count + i].
// cpu_reference/canary.cpp is the twin.
#ifndef LOCKSTEP_CANARY_H
#define LOCKSTEP_CANARY_H

enum CanaryCase {
  CANARY_SUM_OF_PRODUCT = 0,  // contraction: what a compiler likes to turn into fma
  CANARY_DIFFERENCE_OF_PRODUCT = 1,
  CANARY_TWO_PRODUCTS = 2,
  CANARY_ACROSS_STATEMENTS = 3,
  CANARY_DOT_PRODUCT = 4,
  CANARY_ACCUMULATION = 5,
  CANARY_ACROSS_FUNCTIONS = 6,
  CANARY_QUOTIENT = 7,  // division
  CANARY_RECIPROCAL = 8,
  CANARY_ROOT = 9,  // square root
  CANARY_RECIPROCAL_ROOT = 10,
  CANARY_DENORMAL_SUM = 11,  // denormals as operands and results
  CANARY_DENORMAL_SCALED = 12,
  CANARY_DENORMAL_PRODUCT = 13,
  CANARY_DENORMAL_QUOTIENT = 14,
  CANARY_DENORMAL_ROOT = 15,
  CANARY_THIRD = 16,
  CANARY_TIMES_ZERO = 17,  // algebra: what is the same of real numbers
  CANARY_PLUS_ZERO = 18,
  CANARY_ZERO_MINUS = 19,
  CANARY_LARGER_ZERO = 20,
  CANARY_NEGATED_DIFFERENCE = 21,
  CANARY_SUM_TAKEN_BACK = 22,
  CANARY_SUM_OF_THREE = 23,
  CANARY_COMMON_FACTOR = 24,
  CANARY_SCALED_TWICE = 25,
  CANARY_QUOTIENT_TAKEN_BACK = 26,
  CANARY_ROOT_SQUARED = 27,
  CANARY_COMMON_START = 28,
  CANARY_SUM_IN_A_LOOP = 29,
  CANARY_CASES = 30
};

// Exponents of the operands are spread over so many powers of two, symmetrically about 1.
#define CANARY_NEAR 16u
#define CANARY_FAR 64u

// A sum in a loop has fewer terms than this.
#define CANARY_TERMS 64u

#endif
