// The records of friction beyond one mu: a part of types.h, which includes it in its place. Of two materials, beside
// MaterialPair; of rows of contacts, beside PointBlock as the step finds them and beside ContactBlock as a sub-step
// does.
#ifndef LOCKSTEP_FRICTION_TYPES_H
#define LOCKSTEP_FRICTION_TYPES_H

// ---- angular friction: torsional and rolling (cpu_reference/solve_angular_friction.hpp) -------------------------

RECORD(AngularFrictionPair) {
  real torsion_radius;       // m: |(r_t, moment about the normal / torsion_radius)| <= mu r_n; 0: it rotates freely
  real rolling_coefficient;  // m: |moment in the tangent plane| <= rolling_coefficient r_n; 0: it rolls freely
};

RECORD(AngularFrictionPointBlock) {
  real torsion_radius[PACK], rolling_coefficient[PACK];
  real moment_x[PACK], moment_y[PACK], moment_z[PACK];  // to start the step from, world frame, N m s
};

// Of torsion, whose velocity is torsion_radius w_n, the part of the Delassus block, 1/kg; of rolling about the tangents
// the inverse of theirs, kg m^2.
RECORD(AngularFrictionBlock) {
  real torsion_radius[PACK], rolling_coefficient[PACK];
  real w_ss[PACK], w_ns[PACK], w_1s[PACK], w_2s[PACK];  // w_ss is w_nn where nothing resists rotation about the normal
  real inverse_11[PACK], inverse_12[PACK], inverse_22[PACK];  // 0 where nothing resists rolling
};

// N s at the torsion radius, N m s.
RECORD(AngularFrictionImpulse) { real torsion[PACK], roll_1[PACK], roll_2[PACK]; };

// ---- static friction above that of sliding (feature static_friction) -----------------------------------------

RECORD(StaticFrictionPair) {
  real friction;  // mu of what slides slower than `speed`
  // m/s, where it is given; else a share of the bounding radius of the smaller shape, 1/s
  real speed, speed_share;
};

RECORD(StaticFrictionBlock) { real friction[PACK], speed[PACK]; };

// ---- anisotropic friction (feature elliptic_friction) ----------------------------------------------------------

// mu is that along the axis of anisotropy, the x axis of a shape.
RECORD(AnisotropyPair) {
  real across;        // in parts of mu; 1: isotropic, 0: friction along the axis alone
  u32 side;           // 0: the axis is that of shape a, 1: of shape b
  u32 perpendicular;  // 1: no friction along that axis; mu and `across` are for the one across it in the tangent plane
};

RECORD(AnisotropyBlock) {
  real x[PACK], y[PACK], z[PACK];  // along the axis, unit, in the frame of the body whose it is
  real across[PACK];
  u32 side[PACK], perpendicular[PACK];
};

// S, symmetric, in the tangent plane: mu along the axis and mu across it are the axes of the ellipse |S^-1 r_t| <= mu
// r_n.
RECORD(EllipseBlock) {
  real s_11[PACK], s_12[PACK], s_22[PACK];
  real degenerate[PACK];  // 1: friction acts along one direction alone and S projects on it; else 0
};

#endif
