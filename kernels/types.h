// Layouts and constants shared by the kernels (OpenCL C 1.2) and the C++ twins. No arithmetic lives here.
// `real` is float or double: a macro argument of the OpenCL build (-DREAL=float), a template parameter in C++.
// SI units, right-handed, z up; quaternions are stored x y z w and rotate body into world coordinates.
#ifndef LOCKSTEP_TYPES_H
#define LOCKSTEP_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <include/lockstep/types.hpp>
#define RECORD(Name)    \
  template <class real> \
  struct Name
#define INDEX_RECORD(Name) struct Name
#define LINE_RECORD(Name) RECORD(Name)
#define LINE_INDEX_RECORD(Name) INDEX_RECORD(Name)
namespace lockstep {
using u32 = std::uint32_t;
using i32 = std::int32_t;
#else
#define RECORD(Name)        \
  typedef struct Name Name; \
  struct Name
#define INDEX_RECORD(Name) RECORD(Name)
// Records whose size is a multiple of 16 bytes, in float too, begin at one: a GPU reads four words of them at once.
#define LINE_RECORD(Name)   \
  typedef struct Name Name; \
  struct __attribute__((aligned(16))) Name
#define LINE_INDEX_RECORD(Name) LINE_RECORD(Name)
typedef uint u32;
typedef int i32;
typedef REAL real;
#endif

// One constant width of every packed block, a multiple of every lane count (1, 8, 16).
#define PACK 16u
// Colours that pairs in contact can share; one that finds none goes to the overflow blocks, solved one after another.
#define MAX_COLORS 64u
// The colour of a contact that is not the first of its pair: the pair has that of the first.
#define COLOR_OF_FIRST (MAX_COLORS + 1u)
// The colour of a pair that has its slot in the schedule of a cell (feature partitions).
#define COLOR_OF_CELL (MAX_COLORS + 2u)
// Cells whose coordinates are odd along the same axes are one phase of a sweep (feature partitions).
#define CELL_PHASES 8u
// Batches of PACK pairs in the schedule of a cell.
#define CELL_BATCHES 64u
// Bodies of a world for each of its slots for cells, in a phase.
#define CELL_BODIES 32u
// Points at which two shapes can touch.
#define MANIFOLD_POINTS 4u
// Contacts of a world that the dense solver takes, a multiple of 32 PACK.
#define DENSE_CONTACTS 4096u
// Blocks from which on a colour is worth a launch of its own.
#define LARGE_COLOR 32u
// Items that one work-item counts, scans or scatters in the list primitives.
#define CHUNK 256u
// Words in which the sort counts the digits of a chunk of keys.
#define SORT_DIGITS 512u
// Values that a node of the tree adds which sums over the bodies of a world are made by.
#define SUM_WIDTH 32u
// By how much a descent lengthens its step after each that was good.
#define DESCENT_GROWTH 1.125f
// "No such body, contact or slot".
#ifndef __cplusplus
#define NONE 0xffffffffu
#endif

// ---- values of the integer fields --------------------------------------------------------------------------------

#ifndef __cplusplus  // C++ has these from include/lockstep/types.hpp
enum BodyKind { BODY_STATIC = 0, BODY_KINEMATIC = 1, BODY_DYNAMIC = 2 };
enum ShapeKind {
#define SHAPE_KIND(name, NAME, needs, may, features, meaning) SHAPE_##NAME,
#include "shape_kinds.def"
  SHAPE_KINDS,  // that are simulated; then those of scenes alone
  SHAPE_LAST_KIND = SHAPE_KINDS - 1,
#define SCENE_SHAPE_KIND(name, NAME, needs, may, features, meaning) SHAPE_##NAME,
#include "shape_kinds.def"
};
enum EventKind {
  EVENT_CONTACT_BEGIN = 0,
  EVENT_CONTACT_END = 1,
  EVENT_TRIGGER_ENTER = 2,
  EVENT_TRIGGER_LEAVE = 3,
  EVENT_IMPACT = 4,  // made by the host alone
  EVENT_KINDS = 5
};
// What an impact obeys (cpu_reference/impact.hpp).
enum ImpactLaw {
  IMPACT_NEWTON = 0,
  IMPACT_POISSON = 1,
  IMPACT_STRONGE = 2,
  IMPACT_CHATTERJEE_RUINA = 3,
  IMPACT_LAWS = 4
};
#endif
// What the normal of a contact turns with while the bodies move through the sub-steps of a step.
enum NormalFrame {
  NORMAL_FIXED = 0,      // the world: two edges that cross, at a point that goes with a
  NORMAL_OF_A = 1,       // a face of shape a
  NORMAL_OF_B = 2,       // a face of shape b
  NORMAL_BETWEEN = 3,    // points from anchor b to anchor a: round shapes
  NORMAL_OF_IMPACT = 4,  // the world, and each side keeps its own arm: they will meet later in the step
  NORMAL_FIXED_ON_B = 5  // the world, at a point that goes with b
};
// The feature of a contact that keeps the middle of a body from passing where its corner is hit.
#define CORE_FEATURE 0xfffffffeu
enum ShapeFlag {
  SHAPE_IS_CENTRAL = 1,     // a sphere at the centre of mass
  SHAPE_IS_TRIGGER = 2,     // what overlaps it is told, nothing is pushed
  SHAPE_IS_CONTINUOUS = 4,  // of a body whose impacts are looked for within the step
  SHAPE_IS_IN_TREE = 8,     // of a ShapeTree: the broad phase leaves it to the middle phase
  SHAPE_HAS_SEAMS = 16      // others that do not move against it cover edges of it
};
// Central: every movable body of the contact has an isotropic inertia and its arm is parallel to the normal, so that
// the Delassus block is diagonal and the cone problem has a closed form. Padding lanes have inverse masses of zero.
enum BlockKind { BLOCK_PADDING = 0, BLOCK_CENTRAL = 1, BLOCK_GENERAL = 2 };

// Words of the `counters` buffer, zeroed by begin_step.
enum Counter {
  COUNTER_STATUS = 0,        // StatusBit, or-ed
  COUNTER_PAIRS = 1,         // candidate pairs, at most the capacity
  COUNTER_CONTACTS = 2,      // contacts, at most the capacity
  COUNTER_BLOCKS = 3,        // packed blocks of all colours, at most the capacity
  COUNTER_COLORS = 4,        // colours in use (0 .. MAX_COLORS), overflow not counted
  COUNTER_OVERFLOW = 5,      // pairs in contact that no colour could hold
  COUNTER_PAIRS_NEEDED = 6,  // what the three lists would have needed
  COUNTER_CONTACTS_NEEDED = 7,
  COUNTER_BLOCKS_NEEDED = 8,
  COUNTER_MAX_EXTENT = 9,     // bits of the largest float bound of a finite shape, m
  COUNTER_LARGE_COLORS = 10,  // one more than the last colour of at least LARGE_COLOR blocks, for the next launch plan
  COUNTER_BAD_BODY = 11,      // NONE - (smallest index of a body whose state went bad); 0 where none did
  COUNTER_TOUCHES = 12,       // pairs of shapes that touch, triggers and what is in them among them
  COUNTER_EVENTS = 13,        // pairs that touch and did not, or the other way round
  COUNTER_ROWS = 14,          // rows of PACK points in the blocks, at most the capacity
  COUNTER_ROWS_NEEDED = 15,
  COUNTER_SWEEPS = 16,        // sweeps of all sub-steps so far, where a tolerance ends them
  COUNTER_SWEEP_CHANGE = 17,  // bits of a float: the largest change of the sweep that runs, m/s; 0 between sub-steps
  COUNTER_SETTLED = 18,       // 1 once a sweep of the sub-step changed less than the tolerance; 0 between sub-steps
  COUNTER_SLEEP_CANDIDATES = 19,      // 1 where some body has been at rest for long enough to fall asleep
  COUNTER_CHANGED = 20,               // 1 where bodies woke or fell asleep in the step
  COUNTER_ASLEEP = 21,                // bodies asleep at the end of the step
  COUNTER_ISLANDS = 22,               // islands asleep at the end of the step
  COUNTER_MOVING = 23,                // bodies awake at the end of the step, and kinematic ones that move
  COUNTER_COUPLED_TILES_NEEDED = 24,  // pairs of tiles of contacts that share a movable body
  COUNTER_UNSOLVED = 25,              // sub-steps whose sweeps all changed more than the tolerance
  // what the state was like that the step started from (kernels/measure.h): maxima as bits of floats
  COUNTER_MAX_SPEED = 26,                   // of the centre of mass of a dynamic body, m/s
  COUNTER_MAX_OVERLAP = 27,                 // of two shapes, m
  COUNTER_MAX_OVERLAP_RATIO = 28,           // over the smaller of their inner radii
  COUNTER_MAX_JOINT_SEPARATION = 29,        // of the anchors of a joint, m
  COUNTER_MAX_JOINT_SEPARATION_RATIO = 30,  // over the size of the smaller body
  COUNTER_MAX_JOINT_ANGLE = 31,             // by which what a joint keeps parallel is off, rad
  // signed numbers of two words, the low one first, in units of 1 / StepParams::units_per_joule
  COUNTER_ENERGY = 32,   // of the dynamic bodies, and of the springs of joints
  COUNTER_KINETIC = 34,  // of it, that of motion
  COUNTER_COUNT = 36
};

enum StatusBit {
  STATUS_PAIRS_FULL = 1,
  STATUS_CONTACTS_FULL = 2,
  STATUS_BLOCKS_FULL = 4,
  STATUS_OUT_OF_GRID = 8,    // update_bounds, sort_cells: a shape is not finite, or so far out that it has no cell
  STATUS_BAD_FORCES = 16,    // integrate_velocities: a velocity is not finite or above the speed limit after the forces
  STATUS_BAD_CONTACTS = 32,  // integrate_positions: the same, after the contacts were solved
  STATUS_BAD_POSE = 64,      // integrate_positions or integrate_free_flight: a pose is not finite
  STATUS_BAD_FLIGHT = 128,   // integrate_free_flight: the same as STATUS_BAD_FORCES
  STATUS_ROWS_FULL = 256,
  STATUS_WOKEN = 512,  // wake_islands: what sleeps has been touched
  STATUS_COUPLED_TILES_FULL = 1024,
  STATUS_TOO_DENSE = 2048,  // couple_contacts: a world has more than DENSE_CONTACTS
  STATUS_STALLED = 4096     // work-groups that wait for each other were not all there (kernels/team.h)
};
// Any of these is found before a stage writes persistent state; the stages that do leave it alone, and the step is
// redone with larger buffers.
#define STATUS_FULL \
  (STATUS_PAIRS_FULL | STATUS_CONTACTS_FULL | STATUS_BLOCKS_FULL | STATUS_ROWS_FULL | STATUS_COUPLED_TILES_FULL)
// And so is a step in which bodies wake, with them awake. One that is too dense ends the run.
#define STATUS_ABORTED (STATUS_FULL | STATUS_WOKEN | STATUS_TOO_DENSE | STATUS_STALLED)

// ---- constant data of a scene ------------------------------------------------------------------------------------

LINE_INDEX_RECORD(WorldRange) {
  u32 first_body, body_count;
  u32 first_shape, shape_count;
  u32 first_plane, plane_count;             // into `planes`: the unbounded shapes of this world
  u32 first_material_pair, material_count;  // pair (m, n) is at first_material_pair + m * material_count + n
};

// Beside it, where some bodies have trees of shapes (feature shape_trees): ranges of `top_level_shapes` and
// `shape_trees`.
INDEX_RECORD(WorldTrees) { u32 first_top_level, top_level_count, first_tree, tree_count; };

LINE_INDEX_RECORD(BodyInfo) {
  u32 world;
  u32 id;         // stable and local to the world: the only name of a body that keys and priorities may use
  u32 kind;       // BodyKind
  u32 isotropic;  // 1 where the three principal moments are equal
};

LINE_INDEX_RECORD(ShapeInfo) {
  u32 body;      // index into the body buffers
  u32 id;        // stable and local to the world
  u32 kind;      // ShapeKind
  u32 material;  // local to the world
  u32 category;  // a and b collide if (a.category & b.mask) != 0 and (b.category & a.mask) != 0
  u32 mask;
  u32 flags;  // ShapeFlag, or-ed
  u32 hull;   // of a convex hull: index into `hulls`, or into `facets` with HULL_IS_FACET
};

LINE_RECORD(Vec4) { real x, y, z, w; };

// Principal moments; of a pivoted body: about the pivot.
LINE_RECORD(Mass) {
  real mass, inverse_mass;              // kg, 1/kg; inverse 0 for static and kinematic bodies
  real inertia[3], inverse_inertia[3];  // kg m^2, body frame
};

// A body that turns about a point fixed in the world (feature pivots). `com_offset_body` is the vector from the pivot
// to the centre of mass.
LINE_RECORD(Pivot) {
  real point_world[3];
  real pivoted;  // 1 or 0
  real com_offset_body[3];
  real pad;
};

// Frame of the shape in its body: origin `offset` from the centre of mass, axes turned by `rotation`. Within a distance
// of `range` from the origin lies the whole shape (0 for planes). `size` by kind:
//   sphere             radius
//   capsule, cylinder  radius, half the length of the (core) segment along z
//   box                half extents
//   hull               half extents of the box along the axes, about the origin, that holds its vertices
//   plane              nothing: through the origin, normal z
// The last of `size` is the inner radius: how deep a point can be inside of the shape, or 0 of what has no inside.
LINE_RECORD(Shape) {
  real offset[3];
  real bounding_radius;
  real rotation[4];
  real size[4];
};

// The shapes of a body that nothing pushes as a tree of boxes in the frame of the body (feature shape_trees): laid out
// as the tree of bounds is (cpu_reference/tree.hpp), from boxes of single shapes up.
RECORD(ShapeTree) {
  u32 body;
  u32 first_item, item_count;  // into shape_tree_items: indices of shapes, in the order of the boxes
  u32 first_block;             // into shape_tree_blocks
  real radius;                 // no point of a shape is farther from the centre of mass, m
  real largest;                // nor from the origin of its shape
  real pad[2];
};

// A convex hull in the frame of its shape. Ranges of the tables hull_vertices, hull_planes and hull_faces (an entry a
// face), hull_edges, hull_corners.
INDEX_RECORD(Hull) {
  u32 first_vertex, vertex_count;
  u32 first_face, face_count;
  u32 first_edge, edge_count;
};

// The corners of a face, counter-clockwise seen from outside: hull_corners[first_corner ...], each an index of a vertex
// within its hull.
INDEX_RECORD(HullFace) { u32 first_corner, corner_count; };

// From vertex a to vertex b; the face on the left and on the right seen from outside. Indices within the hull.
INDEX_RECORD(HullEdge) { u32 vertex_a, vertex_b, face_left, face_right; };

RECORD(MaterialPair) { real friction, restitution; };

// Beside it, where some pair has a law of impact of its own (feature impact_laws).
RECORD(ImpactPair) {
  real tangential_restitution;
  u32 law, pad;  // ImpactLaw
};

// What acts on a body during a step, world frame: N through the centre of mass, and N m about it. All zeros but in
// worlds whose users load bodies (feature loads).
LINE_RECORD(Load) {
  real force[3], pad_f;
  real torque[3], pad_t;
};

// How the particles of a world push (feature particles; cpu_reference/particle.hpp).
RECORD(ParticleLaw) {
  real radius;         // m
  real stiffness;      // N/m
  real damping;        // 2 zeta sqrt(stiffness): times the root of the effective mass it is in N s/m
  real shear_damping;  // as the damping
  real friction;
  real shear_stiffness;  // N/m; 0: nothing remembers how far it was sheared
  real pad[2];
};

// Of a body, which is still below both speeds alone (feature sleeping). The radius is about its centre of mass.
RECORD(SleepLaw) { real speed, angular_speed, radius, pad; };  // m/s, rad/s, m

// A plane that particles rest on, in the frame of its body.
RECORD(ParticlePlane) {
  real point[3], pad_p;
  real normal[3], pad_n;  // unit, out of the solid
};

// What a particle of a dynamic body may push: another particle, or a plane, `particles` + its index. Springs are kept
// in this order.
INDEX_RECORD(SpringKey) { u32 particle, partner; };

// ---- state -------------------------------------------------------------------------------------------------------

// One line a body (64 bytes in float): all that a local solve needs. The first half is all a central contact
// needs.
LINE_RECORD(Motion) {
  real v[3];          // velocity of the centre of mass, world frame, m/s
  real inverse_mass;  // 0 for static and kinematic bodies, and for the null body behind the last one
  real w[3];          // angular velocity, world frame, rad/s
  real inertia_xx;    // inverse inertia, world frame; zero for immovable bodies
  real inertia_yy, inertia_zz, inertia_xy, inertia_xz, inertia_yz;
  real pad[3];
};

// How long a dynamic body has been still, and what it sleeps with (feature sleeping; cpu_reference/sleep.hpp).
INDEX_RECORD(Sleeper) {
  u32 still;   // steps in a row; 0 of one that sleeps
  u32 island;  // the smallest index of a body of its island; NONE of a body that is awake, and ISLAND_WAKES of one that
               // has been woken since the last step
};
#define ISLAND_WAKES 0xfffffffeu

// What a body was like at the end of the first of the steps that Sleeper::still counts, or when it was last found at
// rest.
LINE_RECORD(StillStart) {
  real position[3];
  real farthest2;  // m^2, square of the largest distance from there since then
  real orientation[4];
  real v[3];
  real largest_angle2;  // rad^2, square of the largest angle from there since then
  real w[3], pad;
};

LINE_RECORD(Velocity) {
  real v[3], pad_v;
  real w[3], damped;  // of previous_velocities, 1: add_geometric_stiffness has damped the body since
};

// How an anisotropic body rotates in a sub-step in which no impulse acts on it (feature gyroscopic).
LINE_RECORD(FreeRotation) {
  real rotation[4];  // x y z w, world frame, not of unit length
  real w[3];         // angular velocity after it, rad/s, as seen from the orientation before it
  real slack;  // square of the change of w up to which no impulse has acted, rad^2/s^2; -1: w is what was solved for
};

// ---- collision ---------------------------------------------------------------------------------------------------

// The sphere and the box of a bounded shape. Planes, and what has no finite position, have extent 0.
LINE_RECORD(Bound) {
  real center[3];
  real extent;           // of the sphere about the centre that holds the shape for the whole step
  real box[3];           // half extents of the shape where it is now, along the axes of the world
  real bounding_radius;  // Shape::bounding_radius
};

INDEX_RECORD(Cell) {
  i32 x, y, z;
  u32 bucket;
};

// The box of the centres of a world's bounded shapes, as words in the order of the floats (kernels/tree.h).
INDEX_RECORD(WorldBox) { u32 low[3], high[3]; };

// Boxes of PACK neighbours of the tree of bounds; those that are missing are empty (low > high).
RECORD(BoxBlock) {
  real low_x[PACK], low_y[PACK], low_z[PACK];
  real high_x[PACK], high_y[PACK], high_z[PACK];
};

// shape_a has the smaller index, but a plane is always shape_b.
INDEX_RECORD(Pair) { u32 shape_a, shape_b; };

// Ordered by (shape_a, shape_b, feature). The normal points from b to a.
LINE_INDEX_RECORD(Contact) {
  u32 shape_a, shape_b, feature;
  u32 body_a, body_b;
  u32 world;
  u32 rank;    // index of the contact within its world
  u32 normal;  // NormalFrame
};

// Where the two shapes of a contact are closest, in the frames of their bodies, so that each sub-step can tell how
// close they are by then. The surface of a round shape is a radius away from its anchor, along the normal.
LINE_RECORD(ContactPoint) {
  real anchor_a[3], radius_a;  // from the centre of mass of a, body frame
  real anchor_b[3], radius_b;
  real normal[4];  // from b to a, in the frame that Contact::normal tells
};

INDEX_RECORD(ContactKey) {
  u32 shape_a, shape_b, feature;
  u32 normal;  // of a sleeper's contact, NormalFrame; else 0
};

// An impulse at rest in the world frame, N s: the normal part, and the tangential part as a vector, so that it survives
// a turned tangent frame.
RECORD(ContactImpulse) { real normal, tangent_x, tangent_y, tangent_z; };

// Two shapes began or ceased to touch; ids are local to the world. Ordered by world and by (shape_a, shape_b) as pairs
// are, but for the sides of a trigger's event: a is the trigger.
INDEX_RECORD(Event) {
  u32 kind;  // EventKind
  u32 step;  // steps done before this one
  u32 world;
  u32 body_a, shape_a;
  u32 body_b, shape_b;
  u32 pad;
};

// Which shapes a query asks about: those of a world that belong to one of the categories.
INDEX_RECORD(QueryFilter) {
  u32 kind;  // ShapeKind of a volume
  u32 world;
  u32 mask;  // of categories
  u32 pad;
};

// From the origin as far as `range` along the unit vector `direction`, world frame, m.
RECORD(Ray) {
  real origin[3], range;
  real direction[3], pad;
};

// Where a ray meets a surface: the distance from its origin, and the outward normal. Zero where it meets none.
RECORD(RayPoint) { real normal[3], distance; };

// Two 64-bit hashes of a world, each the wrapping sum of a mix of every record: of all persistent state, and of the
// poses.
INDEX_RECORD(WorldHash) { u32 state_low, state_high, pose_low, pose_high; };

// What a record of the hash describes, so that equal words in different buffers do not look alike.
enum HashedRecord {
  HASHED_STEP = 1,
  HASHED_POSITION = 2,
  HASHED_ORIENTATION = 3,
  HASHED_MOTION = 4,
  HASHED_CONTACT = 5,
  HASHED_TOUCH = 6,
  HASHED_JOINT = 7,
  HASHED_SPRING = 8,
  HASHED_SLEEPER = 9,
  HASHED_SLEPT = 10,
  HASHED_SLEPT_POINT = 11,
  HASHED_COUPLING = 12
};

#include "facet_types.h"
#include "friction_types.h"
#include "seam_types.h"
#include "stream_types.h"

// ---- joints --------------------------------------------------------------------------------------------------------

#include "articulation_types.h"
#include "joint_types.h"

// ---- parameters of a step, passed by value -------------------------------------------------------------------------

RECORD(StepParams) {
#define STEP_DERIVED(step_type, name, meaning) step_type name;
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) real name;
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) u32 name;
#include "step_settings.def"
  // of the scene as it is compiled, and of the step that runs
  u32 bodies, shapes, worlds;
  u32 tree_shapes;  // of the shapes, those in trees of their bodies; the others are top-level
  u32 buckets;      // of the grid, a power of two
  u32 pair_capacity, contact_capacity, block_capacity;
  u32 substep;  // index of the running sub-step
  u32 queries;  // rays or volumes of the query, outside of a step
  u32 overlap_capacity;
  u32 row_capacity;
  u32 joint_blocks;
  real units_per_joule;  // in which energy is counted, a power of two; 0: it is not
};

#ifdef __cplusplus
}  // namespace lockstep
#endif
#endif
