// Worlds as they were.
#include <tuple>

#include "host/world/impl.hpp"

namespace lockstep {

struct Snapshot::Data {
  std::shared_ptr<const int> world;
  u32 steps_done = 0;
  double time = 0;

  std::shared_ptr<const Population> population;
  // motors, springs and controls, where any were set while the world ran
  std::vector<JointDescription> driven;
  std::vector<ActuatorDescription> actuators;
  std::shared_ptr<Engine> engine;
  std::unique_ptr<SavedEngine> state;
  IndexMap index_map;
  bool changed = false;
  Verdict verdict;
  std::vector<BodyHandle> stepped, made_of;
  std::vector<BodyEvent> ended, ended_in_step;

  std::map<u32, std::function<Wrench(double)>> loads;
  std::map<u32, Wrench> forces;
  std::map<u32, Pose> targets;
  std::set<u32> arrived;
  bool drives_set = false, gravity_set = false;
  Vector3 gravity;

  std::vector<BodyContact> contacts;
  std::vector<BodyEvent> events;
  bool kept = true;
};

std::shared_ptr<Snapshot::Data> World::Impl::save() {
  if (!scene.bodies.empty()) ready();
  if (engine) {
    engine->expect_not_failed();
    if (!changed) begin_recording();
    hand_over_velocities();
  }
  if (!population) population = std::make_shared<const Population>(Population{scene, bodies, joints});
  auto saved = std::make_shared<Snapshot::Data>();
  saved->world = self;
  saved->population = population;
  if (drives_were_set) saved->driven = scene.joints, saved->actuators = scene.actuators;
  saved->engine = engine;
  if (engine) {
    saved->state = engine->save();
    saved->steps_done = engine->steps_done();
  }
  saved->time = saved->steps_done * scene.settings.dt;
  saved->index_map = index_map;
  saved->changed = changed;
  saved->verdict = verdict;
  saved->stepped = stepped;
  saved->made_of = made_of;
  saved->ended = ended;
  saved->ended_in_step = ended_in_step;
  saved->loads = loads;
  saved->forces = forces;
  saved->targets = targets;
  saved->arrived = arrived;
  saved->drives_set = drives_set;
  saved->gravity_set = gravity_set;
  saved->gravity = scene.gravity;
  saved->contacts = contacts;
  saved->events = events;
  saved->kept = kept;
  return saved;
}

void World::Impl::restore(const Snapshot::Data& saved) {
  if (engine != saved.engine) {
    if (engine) engine->end_recording();
    engine = saved.engine;
  }
  const bool noted = engine && engine->restore(*saved.state);
  if (!noted) recording_due = !recording.empty();  // another file begins with this state
  if (population != saved.population) {
    scene = saved.population->scene;
    bodies.go_back(saved.population->bodies);
    joints.go_back(saved.population->joints);
    population = saved.population;
  } else if (drives_were_set) {
    scene.joints = saved.population->scene.joints;
    scene.actuators = saved.population->scene.actuators;
  }
  if (!saved.driven.empty()) scene.joints = saved.driven, scene.actuators = saved.actuators;
  index_map = saved.index_map;
  changed = saved.changed;
  verdict = saved.verdict;
  stepped = saved.stepped;
  made_of = saved.made_of;
  ended = saved.ended;
  loads = saved.loads;
  forces = saved.forces;
  targets = saved.targets;
  arrived = saved.arrived;
  drives_set = saved.drives_set;
  gravity_set = saved.gravity_set;
  scene.gravity = saved.gravity;
  forget_state();
  new_velocities.clear();
  ended_in_step = saved.ended_in_step;
  contacts = saved.contacts;
  events = saved.events;
  kept = saved.kept;
}

u32 Snapshot::steps_done() const { return data_ ? data_->steps_done : 0; }
double Snapshot::time() const { return data_ ? data_->time : 0; }

const std::map<u32, std::function<Wrench(double)>>& Snapshot::loads() const {
  static const std::map<u32, std::function<Wrench(double)>> none;
  return data_ ? data_->loads : none;
}

Snapshot World::save() {
  Snapshot snapshot;
  snapshot.data_ = impl_->save();
  return snapshot;
}

void World::restore(const Snapshot& snapshot) {
  if (!snapshot) throw Error(Failure::input, "snapshot", "is of nothing; save() makes one");
  if (snapshot.data_->world != impl_->self)
    throw Error(Failure::input, "snapshot", "is of another world; only the one that made it goes back to it");
  impl_->restore(*snapshot.data_);
}

}  // namespace lockstep
