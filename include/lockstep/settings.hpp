// How a scene is simulated. What is left as it is here holds as in a scene file that does not set it
// (docs/reference/settings.md, "Settings").
#pragma once

#include <optional>
#include <string>

#include "types.hpp"

namespace lockstep {

/// How a body moves. `explicit_euler`, `semi_implicit_euler` and `trapezoidal` are the time-stepping schemes (positions
/// move with the old, the new, the mean velocity); `runge_kutta` is of fourth order, for free flight and pivots only.
enum class Integrator { explicit_euler, semi_implicit_euler, trapezoidal, runge_kutta };

/// At which angular velocity the gyroscopic moment w x I w is taken: left out, at the old, the new or the mean one.
enum class Gyroscopic { none, explicit_, implicit, midpoint };

/// Friction model. `cones`: each contact point has a cone of its own, exact Coulomb friction; `patches`: the contacts
/// of two shapes share one friction and one twist, cheaper, another model (docs/theory/solvers.md).
enum class FrictionModel { cones, patches };

/// How joints that have come apart are closed, but for those of small_steps and those that are soft on purpose: by
/// velocities, which take back the share `correction` of the error in a sub-step and stay (Baumgarte), or by moving the
/// bodies once a sub-step has moved them, their velocities left alone.
enum class Stabilization { velocities, positions };

/// How joints are solved in each sweep: one after another, or all those of a tree of bodies at once, exactly, with
/// those that close its loops. `automatic`: at once those of trees in which some body carries ten times its mass, with
/// solvers that can.
enum class JointSolver { automatic, sweeps, direct };

/// How candidate pairs are found. `automatic` takes the tree where shapes differ much in size.
enum class BroadPhase { automatic, grid, bvh };

/// What events are of: pairs of shapes, of bodies, or of the triangles of surfaces.
enum class EventPairs { shapes, bodies, triangles };

/// Of which time impulses and forces are told (docs/reference/forces.md): `automatic` is `step` in a World, with
/// `impact_speed` and with sensors.
enum class Forces { automatic, step, substep };

/// How contacts and joints are solved; docs/theory/solvers.md says which for what.
enum class Solver {
  // written from host/solvers.def and host/oracles.def by the test Manual.*
  /// `iterations` sweeps over hard contacts in each sub-step; overlap is pushed apart by a velocity that stays
  gauss_seidel,
  /// few sweeps in each of several sub-steps; contacts that overlap are springs, and a last sweep takes back the
  /// velocity that they gave
  small_steps,
  /// `iterations` sweeps over hard contacts, in each of which all pairs are solved at once, on copies of their bodies
  jacobi,
  /// `iterations` steps along the projected gradient of one convex problem of all contacts and joints; what slides
  /// lifts by friction times its speed (docs/theory/other_solvers.md). Not with `patches`
  gradient,
  /// `gradient` with momentum
  accelerated_gradient,
  /// `iterations` sweeps over hard contacts one after another in the order of their list, by the dense Delassus matrix
  /// (docs/theory/other_solvers.md). At most 4,096 contacts a world; not with `patches`, torsional, rolling or
  /// anisotropic friction
  dense_gauss_seidel,
  /// the sweeps of `gauss_seidel` in another order: pairs are solved cell by cell of a grid, every second cell along
  /// each axis at once, as work-groups of a GPU like it; on a CPU it does not pay. Not with `sleeping`
  cell_gauss_seidel,
  /// Gauss-Seidel first, then what gets further
  automatic,
  /// blocked Gauss-Seidel, each contact solved exactly
  nsgs,
  /// the same, each contact by enumeration
  nsgs_enumeration,
  /// the same, each contact by splitting
  nsgs_splitting,
  /// normal and friction impulses in turn
  staggered,
  /// projected gradient with line search
  projected_gradient,
  /// accelerated projected gradient with De Saxce's fixed point
  apgd,
  /// the same on the relaxed cone complementarity problem, another model
  ccp_apgd,
  /// alternating direction method of multipliers
  admm,
  /// semi-smooth Newton on Alart and Curnier's function
  newton,
  /// proximal point around Newton
  proximal_point,
  /// contacts one by one, joints together along their tree (Baraff)
  mixed_ldlt,
  /// the same, joints by a parallel sparse factorisation (CHOLMOD)
  mixed_sparse,
  /// the same, joints by conjugate gradients
  mixed_pcg,
  /// the same, with an incomplete Cholesky factorisation
  mixed_ichol,
  /// contacts one by one, each felt by all that hangs on its bodies
  mixed_articulated,
  /// joints closed at the end of each sub-step, by predicting it; contacts beside them
  impulse_based,
  /// friction pyramids, by enumeration of index sets
  pyramid_enumeration,
  /// friction pyramids, by Lemke's method
  pyramid_lemke,
  /// friction pyramids, by Keller's principal pivoting
  pyramid_keller,
  /// friction pyramids, by Baraff's incremental pivoting
  pyramid_baraff,
  /// friction pyramids, by Murty's least-index pivoting
  pyramid_murty,
  /// friction pyramids, by projected Jacobi
  pyramid_jacobi,
  /// friction pyramids, by damped projected Jacobi
  pyramid_damped_jacobi,
  /// friction pyramids, by projected Gauss-Seidel
  pyramid_pgs,
  /// friction pyramids, by projected successive over-relaxation
  pyramid_psor,
  /// friction pyramids, by projected Gauss-Seidel with subspace minimisation
  pyramid_pgs_sm,
  /// friction pyramids, by nonsmooth nonlinear conjugate gradients
  pyramid_nncg,
  /// friction pyramids, by Fischer-Newton
  pyramid_fischer_newton,
  /// friction boxes, by Baraff's incremental pivoting
  box_baraff,
  /// friction boxes, by projected Jacobi
  box_jacobi,
  /// friction boxes, by damped projected Jacobi
  box_damped_jacobi,
  /// friction boxes, by projected Gauss-Seidel
  box_pgs,
  /// friction boxes, by projected successive over-relaxation
  box_psor,
  /// friction boxes, by projected Gauss-Seidel with subspace minimisation
  box_pgs_sm,
  /// friction boxes, by nonsmooth nonlinear conjugate gradients
  box_nncg,
  /// friction boxes, by Fischer-Newton
  box_fischer_newton,
  /// cones in reduced coordinates, by `auto`
  reduced_auto,
  /// cones in reduced coordinates, by `nsgs`
  reduced_nsgs,
  /// cones in reduced coordinates, by `nsgs_enumeration`
  reduced_nsgs_enumeration,
  /// cones in reduced coordinates, by `nsgs_splitting`
  reduced_nsgs_splitting,
  /// cones in reduced coordinates, by `staggered`
  reduced_staggered,
  /// cones in reduced coordinates, by `projected_gradient`
  reduced_projected_gradient,
  /// cones in reduced coordinates, by `apgd`
  reduced_apgd,
  /// cones in reduced coordinates, by `ccp_apgd`
  reduced_ccp_apgd,
  /// cones in reduced coordinates, by `admm`
  reduced_admm,
  /// cones in reduced coordinates, by `newton`
  reduced_newton,
  /// cones in reduced coordinates, by `proximal_point`
  reduced_proximal_point,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by enumeration of index sets
  reduced_pyramid_enumeration,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by Lemke's method
  reduced_pyramid_lemke,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by Keller's principal pivoting
  reduced_pyramid_keller,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by Baraff's incremental pivoting
  reduced_pyramid_baraff,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by Murty's least-index pivoting
  reduced_pyramid_murty,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by projected Jacobi
  reduced_pyramid_jacobi,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by damped projected Jacobi
  reduced_pyramid_damped_jacobi,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by projected Gauss-Seidel
  reduced_pyramid_pgs,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by projected successive over-relaxation
  reduced_pyramid_psor,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by projected Gauss-Seidel with subspace minimisation
  reduced_pyramid_pgs_sm,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by nonsmooth nonlinear conjugate gradients
  reduced_pyramid_nncg,
  /// friction pyramids in reduced coordinates (Model-DCA-LCP), by Fischer-Newton
  reduced_pyramid_fischer_newton,
  /// the same as a mixed problem with velocities of bodies in contact and at the ends of trees (Model-DCA-mLCP1)
  reduced_mlcp1_fischer_newton,
  /// the same as a mixed problem with velocities of bodies at the ends of trees (Model-DCA-mLCP2)
  reduced_mlcp2_fischer_newton,
  // end of solvers
};

/// A setting that is unset until somebody sets it: the solver brings it then
/// (docs/reference/settings.md, "Solvers").
template <class T>
using BySolver = std::optional<T>;

/// When islands fall asleep (docs/how_to/let_bodies_sleep.md).
struct SleepSettings {
  // written from host/settings.def by the test Manual.*: sleeping
  /// All bodies of an island have been still for so long, s
  double after = 0.5;
  /// A still body has no higher speed of its centre of mass, m/s
  std::optional<double> speed = {};
  /// Nor a higher angular velocity, rad/s
  double angular_speed = 0.8;
  // end of sleeping
};

struct Settings {
  // written from host/settings.def by the test Manual.*: settings
  /// Time step, s
  double dt = 1.0 / 60;
  /// Time steps of a run
  u32 steps = 300;
  /// How contacts and joints are solved (docs/reference/settings.md)
  Solver solver = Solver::gauss_seidel;
  /// Oracles with friction pyramids (`pyramid_lemke` and its like): how many sides these have
  u32 directions = 4;
  /// `cones`: exact Coulomb friction at each contact point; `patches`: one friction and one torsion for all contacts of
  /// two shapes, cheaper and another model (docs/how_to/choose_a_solver.md)
  FrictionModel friction_model = FrictionModel::cones;
  /// The normal impulses of all points of a pair are found together, exactly, before its friction and once more behind
  /// it; false: one point after another. With solvers by sweeps over pairs, in `small_steps` where a pair is hit, and
  /// not with a `tolerance` (docs/theory/solvers.md)
  bool coupled_normals = true;
  /// `cell_gauss_seidel`: edge of its cells (docs/theory/other_solvers.md), m
  std::optional<double> cell_size = {};
  /// How a sweep solves joints: `sweeps`, one after another; `direct`, all those of a tree of bodies at once, exactly,
  /// with `gauss_seidel` and `cell_gauss_seidel`; `auto`, trees at once in which some body carries ten times its own
  /// mass (docs/theory/articulations.md)
  JointSolver joint_solver = JointSolver::automatic;
  /// Light bodies between loaded joints count with the least inertia for which a sub-step is stable, and what swings
  /// too fast for it is damped; not with oracles (docs/theory/joints.md)
  bool geometric_stiffness = true;
  /// How positions follow velocities (docs/reference/settings.md)
  Integrator integrator = Integrator::semi_implicit_euler;
  /// Angular velocity at which the gyroscopic moment w x I w is taken: `none` (left out), `explicit` (the old one:
  /// gains energy), `implicit` (the new one: loses it), `midpoint` (their mean): a free body keeps its energy and its
  /// angular momentum by it (docs/theory/substep.md)
  Gyroscopic gyroscopic = Gyroscopic::midpoint;
  /// Share of the penetration beyond the slop that is taken back: by moving bodies, in a sweep over the contacts; with
  /// the `stabilization` velocities, `jacobi`, `cell_gauss_seidel` and along gradients, in a sub-step by a velocity
  /// that stays (Baumgarte, ERP), and so of the error of joints; not in `small_steps`
  double correction = 0.2;
  /// How joints that came apart are closed, and contacts that overlap: `positions`, by moving the bodies after each
  /// sub-step, which leaves velocities alone; `velocities`, by the share `correction` (Baumgarte), which adds energy.
  /// `small_steps` has springs instead; `jacobi`, `cell_gauss_seidel` and solvers along a gradient take overlap back by
  /// velocities (docs/theory/joints.md)
  Stabilization stabilization = Stabilization::positions;
  /// `small_steps`: of the spring that pushes overlap apart, Hz
  std::optional<double> contact_frequency = {};
  /// `small_steps`: of that spring, in parts of the critical damping
  double contact_damping = 5;
  /// `small_steps`: of the springs that close joints; at most a quarter of the rate of sub-steps is used, Hz
  double joint_frequency = 1000;
  /// `small_steps`: of those springs, in parts of the critical damping
  double joint_damping = 2;
  /// Fastest velocity by which penetration is taken back, in a sweep where bodies are moved apart, m/s
  std::optional<double> correction_limit = {};
  /// Penetration that is left alone, m
  std::optional<double> slop = {};
  /// Speculative margin: shapes closer than this plus their relative motion in the step get contacts, m
  std::optional<double> margin = {};
  /// Slower approaches do not bounce, m/s
  double restitution_threshold = 0;
  /// A body that becomes faster stops the run; angular velocity times the largest extent is not limited, m/s
  double speed_limit = 1e5;
  /// The first sweep in which no relative velocity at a contact or joint changes by more is the last of its sub-step;
  /// 0: all `iterations` are made (docs/theory/solvers.md), m/s; unset: what the solver brings
  BySolver<double> tolerance = {};
  /// Sweeps of the solver in a sub-step; with a `tolerance`, at most; unset: what the solver brings
  BySolver<u32> iterations = {};
  /// `small_steps`: sweeps that take back, in each sub-step, the velocity that springs gave to close overlap and
  /// joints; 2 keep buildings still that tremble and creep with 1 (docs/theory/solvers.md)
  u32 relaxations = 1;
  /// Sub-steps of a step, each `dt / substeps` long: contacts are found once a step and solved in each sub-step; unset:
  /// what the solver brings
  BySolver<u32> substeps = {};
  /// Sweeps over the joints and the contacts in a sub-step that close and separate them by moving bodies
  /// (`stabilization`)
  u32 position_sweeps = 2;
  /// How candidate pairs are found: `grid`, a uniform one; `bvh`, a tree of boxes, for shapes of unequal sizes; it
  /// changes speed, never a bit (docs/reference/settings.md)
  BroadPhase broad_phase = BroadPhase::automatic;
  /// Report which shapes begin and cease to touch (docs/reference/events.md)
  bool events = false;
  /// Of which time contacts, joints, events and pictures tell impulses and forces: `step`, of all its sub-steps;
  /// `substep`, of the last one; `auto`: `step` in worlds of the library, with `impact_speed`, with sensors and where
  /// pictures show forces or recordings have them, else `substep` (docs/reference/forces.md)
  Forces forces = Forces::automatic;
  /// Tell of impacts: of what comes together faster than this, with its speed and impulse. Asks for `events`
  /// (docs/reference/events.md), m/s
  std::optional<double> impact_speed = {};
  /// What events are of: `shapes`, one for two shapes of the scene, a mesh or a height field being one; `bodies`, one
  /// for all shapes of two bodies; `triangles`, those of surfaces by themselves (docs/reference/events.md)
  EventPairs event_pairs = EventPairs::shapes;
  /// Islands of bodies that are all at rest sleep until they are touched (docs/how_to/let_bodies_sleep.md)
  std::optional<SleepSettings> sleeping = {};
  /// A run is bad in which two shapes overlap by more, in parts of the inner radius of the smaller one
  double max_overlap = 0.5;
  /// A run is bad in which a joint opens by more, in parts of the size of the smaller body: the distance from its
  /// centre of mass to the anchor, or its radius of gyration
  double max_joint_separation = 0.5;
  /// A run is bad in which axes that a joint keeps parallel are off by more, rad
  double max_joint_angle = 0.2;
  /// A run is bad in which a dynamic body is faster, m/s
  double max_speed = 1e4;
  /// A run is bad that gains more energy than motors give it, in parts of the largest kinetic energy so far; not judged
  /// where kinematic bodies, loads or motors of unbounded force drive it (docs/reference/error_measures.md)
  double max_energy_gain = 0.25;
  /// Floating-point precision of a run; unset: what the solver brings
  BySolver<std::string> precision = {};
  // end of settings

  // of worlds, no settings of files
  bool loads = false;         // forces and torques from outside
  bool keeps_shapes = false;  // for questions, though none can touch
};

/// Takes another solver with the sub-steps and sweeps that it brings, and joints as it takes them: what was set for the
/// old one is forgotten. An oracle brings a residual and double as well and wants cones; it keeps the sub-steps of
/// sweeps of Gauss-Seidel, whose steps it makes exact. To choose a solver in the first place, assign `settings.solver`.
void replace_solver(Settings& settings, Solver solver);

[[deprecated("assign settings.solver; replace_solver() also forgets what was set for another solver")]]  //
inline void
use_solver(Settings& settings, Solver solver) {
  replace_solver(settings, solver);
}

}  // namespace lockstep
