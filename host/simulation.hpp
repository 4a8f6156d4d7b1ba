// Steps a scene on a backend: redoes a step that ran out of room, stops at one that went bad.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/event_groups.hpp"

namespace lockstep {

/// A question: what does a ray meet first? SI units, world frame.
struct RayQuery {
  Vector3 origin = {0, 0, 0}, direction = {1, 0, 0};  // the direction need not be unit
  double length = 1e6;                                // how far to look, m
  u32 mask = 0xffffffffu;                             // of categories
  u32 world = 0;
};

/// The answer. Ids are local to the world, as in the scene; `hit` is false where nothing was met.
struct RayHit {
  bool hit = false;
  u32 body = NONE, shape = NONE;
  double distance = 0;  // from the origin, m
  Vector3 point = {0, 0, 0}, normal = {0, 0, 0};
};

/// A question: which shapes overlap a sphere or a box?
struct VolumeQuery {
  ShapeKind kind = SHAPE_SPHERE;  // or SHAPE_BOX
  Vector3 center = {0, 0, 0};
  Quaternion rotation = {0, 0, 0, 1};  // of a box
  double radius = 0;                   // of a sphere, m
  Vector3 half_extents = {0, 0, 0};    // of a box, m
  u32 mask = 0xffffffffu;
  u32 world = 0;
};

/// What inputs change, though no step does.
inline constexpr Buffer driven_buffers[] = {Buffer::loads, Buffer::joints, Buffer::gravities};

/// What a simulation was, for Simulation::restore().
struct SavedSimulation {
  std::unique_ptr<SavedBuffers> buffers;
  Counters counters = {};
  u32 steps_done = 0, redone = 0, wakings = 0;
  Unsolved unsolved, of_backend;
  bool stepped = false, untouched = false, starts_cold = false;
};

/// One of the answers; they are in order of the questions and of the shapes.
struct Overlap {
  u32 volume;  // index of the question
  u32 body, shape;
};

/// Those of the step after so many: the first of a run, and what starts cold, has no impulses of its own to start from,
/// and gets ten times the sweeps.
template <class real>
StepParams<real> params_of_step(StepParams<real> params, u32 steps_done, bool starts_cold = false);

template <class real>
class Simulation {
 public:
  /// `params` are those of the state that the backend was made from, `steps_done` the steps that are behind it.
  Simulation(std::unique_ptr<Backend<real>> backend, const StepParams<real>& params, u32 steps_done = 0);

  /// One time step. A list that was too short is made longer and the step redone, with the same bits as if it had been
  /// long enough; a step in which bodies wake is redone with them awake. Where everything sleeps, the step only counts.
  /// Throws Error naming body, stage and step when a velocity or a pose goes bad, and whatever computing it throws. The
  /// step that failed is none of those done, and counts once as unsolved (bad). No other follows it: what the backend
  /// holds is the state in which it was cut short, and step() throws Error (comparison).
  void step();

  /// What has been left unsolved so far: by an oracle, by sweeps that a tolerance did not end, by a step that failed.
  Unsolved unsolved() const { return has_failed_ ? unsolved_ : unsolved_in_steps(); }
  /// Throws Error (comparison) where a step has failed.
  void expect_not_failed() const;

  /// All that the steps to come depend on, and the contacts and events of the last one, where the state is. Throws
  /// Error (comparison) where a step has failed.
  SavedSimulation save();
  /// Goes back, or forth, to what it was: the same steps give the same bits. A step that failed since is forgotten.
  void restore(SavedSimulation& saved);

  /// Hashes of the persistent state and of the poses of each world, computed where the state is.
  std::vector<WorldHash> world_hashes();

  /// Who began and who ceased to touch in the last step (kernels/types.h says in which order); nothing in a scene that
  /// does not ask for events (docs/reference/events.md).
  std::vector<Event> events();
  /// The same of the shapes or bodies of the scene, as its setting `event_pairs` says: the triangles of a surface are
  /// shapes to the step. Behind them come impacts, where the setting `impact_speed` asks for them.
  std::vector<PairEvent> events(const EventGroups& groups);
  /// The pairs of shapes that touch since the last step, in order.
  std::vector<Pair> touching();

  /// What each ray meets first: solid shapes only, from outside. Bit for bit the same everywhere; the kernels are built
  /// at the first question. Throws Error (input) for a ray that makes no sense, and in a scene whose shapes cannot
  /// touch: they are not kept (docs/reference/events.md).
  std::vector<RayHit> cast_rays(std::span<const RayQuery> rays);

  /// Which solid shapes overlap each volume. The same applies.
  std::vector<Overlap> find_overlaps(std::span<const VolumeQuery> volumes);

  /// The next step gets the sweeps of a first one, for what acts has changed.
  void start_cold() { starts_cold_ = true; }

  Backend<real>& backend() { return *backend_; }
  const StepParams<real>& params() const { return params_; }
  const Counters& counters() const { return counters_; }  // of the last step
  /// The same for who looks at all that the last step left; nothing once restore() has put back a part of it.
  Counters measured_counters() const { return is_restored_ ? Counters{} : counters_; }
  u32 steps_done() const { return steps_done_; }
  bool has_stepped() const { return stepped_; }  // else of its last step only what lives on is known
  u32 redone() const { return redone_; }         // times that a step was redone for want of room
  u32 wakings() const { return wakings_; }       // and because bodies woke in it

 private:
  void make_step();
  Unsolved unsolved_in_steps() const;
  std::vector<ContactImpact> impacts(double faster_than);
  void make_room(Sizes wanted);
  void make_longer(u32 status);
  bool is_at_rest() const;

  std::unique_ptr<Backend<real>> backend_;
  std::vector<ShapeInfo> shape_infos_;  // for queries
  std::vector<BodyInfo> body_infos_;
  StepParams<real> params_;
  Counters counters_ = {};
  u32 steps_done_, redone_ = 0, wakings_ = 0;
  Unsolved unsolved_;  // by sweeps; once a step has failed, all
  bool has_failed_ = false;
  bool is_restored_ = false;  // since the last step
  bool starts_cold_ = false;  // the next one
  bool stepped_ = false;      // the counters are those of a step that this simulation did
  u32 uploads_at_end_ = 0;    // of the backend, when the last step had been done
};

}  // namespace lockstep
