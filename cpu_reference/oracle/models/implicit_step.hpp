// Model-mNCP (survey 3.4, definition 6, equations 39 - 44): a step of backward Euler in which inertia, Jacobians, gaps
// and loads are those of the step's end,
//   M' (u' - u) = J_n'^T p_n + J_f'^T p_f + p_ext'                                    (39)
//   q' - q = dt H' u'                                                                  (40)
//   C_b(q') = 0,   0 <= C_n(q')  _|_  p_n >= 0                                         (41, 42)
//   friction against the velocity at the end, in Coulomb's cone; in joints, in an interval   (43, 44).
// The kinematic map needs no iteration: Q' - Q = dt/2 (0, w') Q' says (1 - dt/2 w') Q' = Q, and the inverse of
// 1 - dt/2 w' is a multiple of 1 + dt/2 w', so that, normalised, Q' = (1 + dt/2 w') Q / |..|: q' is a function of u'.
// (42) - (44) are said without slack variables: p_n = max(0, x_n), p_f = P_D(mu max(0, x_n))(x_f) with x = p - rho (C_n
// / dt, nu_f) and any rho > 0 (Alart and Curnier 1991). Where (43) is 0 = 0, at p_n = 0, these still say p_f = 0. World
// frame unless said, SI units.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cpu_reference/oracle/models/multibody.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle::models {

struct ImplicitBody {
  double mass = 0;                                               // kg; 0: immovable, and then it stands still
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();         // body frame, kg m^2
  Vector3d x = Vector3d::Zero();                                 // of the centre of mass, m
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();         // body to world
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();           // m/s, rad/s
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();  // from outside, N, N m
};

enum class Surface { plane, ball, bowl };

/// A ball (or a point: radius 0) of body a on a surface of body b. Points and directions in the frames of their bodies.
struct SurfaceContact {
  std::size_t body_a = 0, body_b = 0;
  Vector3d centre_a = Vector3d::Zero();
  double radius_a = 0;
  Surface surface = Surface::plane;
  Vector3d point_b = Vector3d::Zero();    // of the plane; centre of the ball or the bowl
  Vector3d normal_b = Vector3d::UnitZ();  // of the plane, unit
  double radius_b = 0;                    // of ball and bowl, m
  double friction = 0;                    // mu
};

/// A ball joint, or a hinge: then the axes stay parallel, and dry friction of at most `dry` acts about them.
struct ImplicitJoint {
  std::size_t body_a = 0, body_b = 0;
  Vector3d anchor_a = Vector3d::Zero(), anchor_b = Vector3d::Zero();  // in the frames of their bodies
  bool hinge = false;
  Vector3d axis_a = Vector3d::UnitZ(), axis_b = Vector3d::UnitZ();  // unit, in the frames of their bodies
  double dry = 0;                                                   // N m
};

struct ImplicitSystem {
  std::vector<ImplicitBody> bodies;
  std::vector<SurfaceContact> contacts;
  std::vector<ImplicitJoint> joints;
  double dt = 0.01;  // s
};

/// The unknowns of a step in one vector: u' of the bodies that move, 6 after another; (p_n, p_t, p_o) of each contact,
/// N s; the impulses of each joint, 3 or, of a hinge, 6: its point, two axes across, and dry friction.
Index unknowns(const ImplicitSystem& system);

/// Newton's method on all equations, with exact derivatives and a line search. `y`: where to start (empty: free
/// motion), and the best that was seen. Residuals are the largest defect in m/s, over the largest speed of free motion.
SolveReport implicit_newton(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y);

/// Fixed point: in each iteration the step is linearised where the last one ended, and solved; the first is linearised
/// where the step starts.
SolveReport implicit_fixed_point(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y);

/// Model-mLCP with Coulomb's cone (45 - 49): the first of these iterations alone. Its residual is that of the linear
/// step.
SolveReport linearised_step(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y);

/// The same bodies at the end of the step.
ImplicitSystem moved(const ImplicitSystem& system, const VectorXd& y);

/// C_n of a contact, m, and the largest distance of the two anchors of a joint, m, as bodies stand.
double gap(const ImplicitSystem& system, std::size_t contact);
double joint_error(const ImplicitSystem& system, std::size_t joint);

}  // namespace lockstep::oracle::models
