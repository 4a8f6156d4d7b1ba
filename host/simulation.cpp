#include "host/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/contact_geometry.hpp"
#include "host/energy_budget.hpp"
#include "host/item_error.hpp"
#include "host/sleepers.hpp"
#include "host/step.hpp"
#include "host/stop_request.hpp"

namespace lockstep {

namespace {

// How many times the sweeps of later steps the first step of a run gets: later ones start from the impulses of the step
// before, the first from none. Not with springs, which it lets push harder than relaxing sweeps take back.
constexpr u32 cold_start_sweeps = 10;

// A list that was too short gets a quarter more than it needed, in whole blocks.
u32 roomier(u32 capacity, u32 needed) {
  const std::uint64_t least = std::max(std::uint64_t{needed}, std::uint64_t{capacity} + 1);
  const std::uint64_t wanted = (least + least / 4 + PACK - 1) / PACK * PACK;
  return static_cast<u32>(std::min<std::uint64_t>(wanted, NONE - PACK));
}

struct Trouble {
  StatusBit bit;
  Stage stage;
  const char* what;
  const char* acts = nullptr;  // what made the velocity, where the trouble is one
};

static_assert(DENSE_CONTACTS == 4096, "say the new limit below");

// In the order of the stages: the first one of a step is the cause of the others.
constexpr Trouble troubles[] = {
    {STATUS_OUT_OF_GRID, Stage::sort_cells, "a shape is too far out for the collision grid, its cell has no number"},
    {STATUS_TOO_DENSE, Stage::couple_contacts,
     "its world has more than 4096 contacts, the most that dense_gauss_seidel takes; take gauss_seidel"},
    {STATUS_BAD_FORCES, Stage::integrate_velocities,
     "the forces make its velocity infinite, not a number or faster than the speed limit; try a shorter time step",
     "the forces"},
    {STATUS_BAD_CONTACTS, Stage::integrate_positions,
     "contacts or joints make its velocity infinite, not a number or faster than the speed limit; try a shorter time "
     "step",
     "contacts or joints"},
    {STATUS_BAD_POSE, Stage::count, "its pose is infinite or not a number; try a shorter time step"},
    {STATUS_BAD_FLIGHT, Stage::integrate_free_flight,
     "its velocity is infinite, not a number or faster than the speed limit; try a shorter time step", "the forces"},
};

// The first body whose state is no number, or the one that is farthest out: what has no cell in the grid.
template <class real>
u32 body_out_of_grid(Backend<real>& backend) {
  const Buffer wanted[] = {Buffer::positions, Buffer::orientations, Buffer::motions};
  const Buffers<real>& current = backend.download(wanted);
  u32 farthest = NONE;
  real most = -1;
  for (u32 i = 0; i < current.positions.size(); ++i) {
    const Vec4<real>&x = current.positions[i], &q = current.orientations[i];
    const Motion<real>& m = current.motions[i];
    const real sum = x.x + x.y + x.z + q.x + q.y + q.z + q.w + m.v[0] + m.v[1] + m.v[2] + m.w[0] + m.w[1] + m.w[2];
    if (!std::isfinite(sum)) return i;
    const real far = std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)});
    if (far > most) farthest = i;
    most = std::max(most, far);
  }
  return farthest;
}

// What is wrong with the velocity of a body: the step ends with it, unless contacts have changed it since.
template <class real>
std::string cause_of(const Trouble& trouble, const BodyInfo& info, const Motion<real>& motion, double limit) {
  const real(&v)[3] = motion.v;
  const real(&w)[3] = motion.w;
  const double speed = std::hypot(double(v[0]), double(v[1]), double(v[2]));
  if (!std::isfinite(speed) || !std::isfinite(double(w[0]) + double(w[1]) + double(w[2])))
    return std::string(trouble.acts) + " make its velocity infinite or not a number; try a shorter time step";
  if (!(speed > limit))
    return fmt::format(
        "{} make it faster, within the step, than the setting \"speed_limit\" of {:.3g} m/s; try a shorter time step "
        "or a "
        "lower velocity, or raise the limit",
        trouble.acts, limit);
  const std::string over = fmt::format("{:.3g} m/s, above the setting \"speed_limit\" of {:.3g} m/s; ", speed, limit);
  if (info.kind == BODY_KINEMATIC)
    return "was told to move at " + over + "give it a lower velocity, or raise the limit";
  return std::string(trouble.acts) + " leave it at " + over +
         "try a shorter time step or a lower velocity, or raise the limit";
}

template <class real>
[[noreturn]] void refuse(Backend<real>& backend, const Counters& counters, const Trouble& trouble,
                         const std::string& where, const StepParams<real>& params) {
  const u32 body = counters[COUNTER_BAD_BODY] != 0 ? NONE - counters[COUNTER_BAD_BODY] : body_out_of_grid(backend);
  if (body >= backend.sizes().bodies)
    throw Error(Failure::comparison, where, std::string("some body: ") + trouble.what);
  const Buffer wanted[] = {Buffer::body_infos, Buffer::motions};
  const Buffers<real>& current = backend.download(wanted);
  const BodyInfo& info = current.body_infos[body];
  const std::string cause = trouble.acts && body < current.motions.size()
                                ? cause_of(trouble, info, current.motions[body], double(params.speed_limit))
                                : trouble.what;
  throw ItemError(Failure::comparison, where, Item::body, info.world, info.id, cause);
}

template <class real>
void refuse_trouble(Backend<real>& backend, const Counters& counters, const StepParams<real>& params, u32 step) {
  for (const Trouble& trouble : troubles) {
    if (!(counters[COUNTER_STATUS] & trouble.bit)) continue;
    // a pose goes bad in the stage that moves it, and particles have a grid of their own
    const bool flies = has(backend.features(), Feature::runge_kutta);
    const bool pushed = has(backend.features(), Feature::particles);
    const Stage stage = trouble.bit == STATUS_OUT_OF_GRID && pushed ? Stage::sort_particles
                        : trouble.stage != Stage::count             ? trouble.stage
                        : flies                                     ? Stage::integrate_free_flight
                                                                    : Stage::integrate_positions;
    refuse(backend, counters, trouble, fmt::format("step {}, {}", step, info(stage).name), params);
  }
}

}  // namespace

template <class real>
StepParams<real> params_of_step(StepParams<real> params, u32 steps_done, bool starts_cold) {
  if ((steps_done == 0 || starts_cold) && !(params.softness > 0)) params.iterations *= cold_start_sweeps;
  return params;
}

template <class real>
Simulation<real>::Simulation(std::unique_ptr<Backend<real>> backend, const StepParams<real>& params, u32 steps_done)
    : backend_(std::move(backend)), params_(params), steps_done_(steps_done) {
  const Features features = backend_->features();
  params_.units_per_joule = units_per_joule(backend_->download(energy_buffers(features)), params_);
}

// Lists that were too short.
template <class real>
void Simulation<real>::make_longer(u32 status) {
  Sizes sizes = backend_->sizes();
  if (status & STATUS_PAIRS_FULL) sizes.pairs = roomier(sizes.pairs, counters_[COUNTER_PAIRS_NEEDED]);
  if (status & STATUS_CONTACTS_FULL) sizes.contacts = roomier(sizes.contacts, counters_[COUNTER_CONTACTS_NEEDED]);
  if (status & STATUS_BLOCKS_FULL) sizes.blocks = roomier(sizes.blocks, counters_[COUNTER_BLOCKS_NEEDED]);
  if (status & STATUS_ROWS_FULL) sizes.rows = roomier(sizes.rows, counters_[COUNTER_ROWS_NEEDED]);
  if (status & STATUS_COUPLED_TILES_FULL)
    sizes.coupled_tiles = roomier(sizes.coupled_tiles, counters_[COUNTER_COUPLED_TILES_NEEDED]);
  backend_->grow(sizes);
  params_.pair_capacity = sizes.pairs;
  params_.contact_capacity = sizes.contacts;
  params_.block_capacity = sizes.blocks;
  params_.row_capacity = sizes.rows;
  ++redone_;
}

// Nothing moved at the end of the last step, nothing was in contact with anything that did, and nobody has touched the
// state since: a step would change no more than the number of steps (tests/sleeping_test.cpp compares the bits).
template <class real>
bool Simulation<real>::is_at_rest() const {
  return has(backend_->features(), Feature::sleeping) && stepped_ && uploads_at_end_ == backend_->uploads() &&
         counters_[COUNTER_MOVING] == 0 && counters_[COUNTER_CONTACTS] == 0;
}

template <class real>
void Simulation<real>::expect_not_failed() const {
  if (has_failed_)
    throw Error(Failure::comparison, "step " + std::to_string(steps_done_),
                "failed before, and no step follows one that was cut short; go on from a state before it");
}

template <class real>
Unsolved Simulation<real>::unsolved_in_steps() const {
  Unsolved all = unsolved_;
  all.add(backend_->unsolved());
  return all;
}

template <class real>
void Simulation<real>::step() {
  expect_not_failed();
  Unsolved before = unsolved_in_steps();
  try {
    make_step();
  } catch (const Stopped&) {  // the state is that before it
    throw;
  } catch (...) {
    before.add(Unsolved::of(1, steps_done_, Stop::bad, std::numeric_limits<double>::quiet_NaN(), params_.tolerance));
    unsolved_ = before;
    has_failed_ = true;
    throw;
  }
}

template <class real>
void Simulation<real>::make_step() {
  if (is_at_rest()) {
    backend_->run(Stage::end_step, params_);
    counters_ = backend_->counters();
    counters_[COUNTER_EVENTS] = 0;
    is_restored_ = false;
    starts_cold_ = false;
    ++steps_done_;
    return;
  }
  for (;;) {
    lockstep::step(*backend_, params_of_step(params_, steps_done_, starts_cold_));
    counters_ = backend_->counters();
    const u32 status = counters_[COUNTER_STATUS];
    // out of the grid, neighbours cannot be told apart and no list is long enough
    if (!(status & STATUS_ABORTED) || (status & (STATUS_OUT_OF_GRID | STATUS_TOO_DENSE))) break;
    if (status & STATUS_FULL) make_longer(status);
    if (status & STATUS_WOKEN) ++wakings_;
  }
  refuse_trouble(*backend_, counters_, params_, steps_done_);
  if (has(backend_->features(), Feature::sleeping)) expect_color_ranks_for(counters_[COUNTER_CONTACTS], steps_done_);
  if (const u32 unsolved = counters_[COUNTER_UNSOLVED]; unsolved > 0) {
    Unsolved sweeps = Unsolved::of(unsolved, steps_done_, Stop::limit, 0, double(params_.tolerance));
    sweeps.of_changes = true;
    unsolved_.add(sweeps);
  }
  ++steps_done_;
  is_restored_ = false;
  starts_cold_ = false;
  stepped_ = true;
  uploads_at_end_ = backend_->uploads();
}

template <class real>
SavedSimulation Simulation<real>::save() {
  expect_not_failed();
  // what contacts, joints and events of the last step are told from
  constexpr Buffer last_step[] = {Buffer::counters,     Buffer::contacts,      Buffer::contact_points,
                                  Buffer::events,       Buffer::impact_speeds, Buffer::contact_slots,
                                  Buffer::impulse_sums, Buffer::joint_sums};
  std::vector<Buffer> wanted;
  for (u32 i = 0; i < buffer_count; ++i) {
    const auto buffer = static_cast<Buffer>(i);
    const bool counts = info(buffer).lifetime == Lifetime::persistent ||
                        std::ranges::find(driven_buffers, buffer) != std::end(driven_buffers) ||
                        std::ranges::find(last_step, buffer) != std::end(last_step);
    if (counts && has(backend_->features(), info(buffer).feature)) wanted.push_back(buffer);
  }
  return {backend_->save(wanted),
          counters_,
          steps_done_,
          redone_,
          wakings_,
          unsolved_,
          backend_->unsolved(),
          stepped_,
          uploads_at_end_ == backend_->uploads(),
          starts_cold_};
}

template <class real>
void Simulation<real>::restore(SavedSimulation& saved) {
  backend_->restore(*saved.buffers);
  backend_->set_unsolved(saved.of_backend);
  if (saved.stepped) backend_->counters();  // it plans the next step by them
  counters_ = saved.counters;
  steps_done_ = saved.steps_done;
  redone_ = saved.redone;
  wakings_ = saved.wakings;
  unsolved_ = saved.unsolved;
  has_failed_ = false;
  stepped_ = saved.stepped;
  starts_cold_ = saved.starts_cold;
  is_restored_ = true;
  uploads_at_end_ = saved.untouched ? backend_->uploads() : backend_->uploads() - 1;
}

template <class real>
std::vector<Event> Simulation<real>::events() {
  const u32 count = counters_[COUNTER_EVENTS];
  if (count == 0) return {};
  const Buffer wanted[] = {Buffer::events};
  const std::vector<Event>& events = backend_->download(wanted).events;
  return std::vector<Event>(events.begin(), events.begin() + count);
}

template <class real>
std::vector<Pair> Simulation<real>::touching() {
  if (!has(backend_->features(), Feature::events)) return {};
  const Buffer wanted[] = {Buffer::touching_count, Buffer::touching};
  const Buffers<real>& current = backend_->download(wanted);
  return {current.touching.begin(), current.touching.begin() + current.touching_count[0]};
}

template <class real>
std::vector<PairEvent> Simulation<real>::events(const EventGroups& groups) {
  const std::vector<Event> all = events();
  std::vector<PairEvent> merged = groups.merge(all, all.empty() || !groups.merges() ? std::vector<Pair>() : touching());
  if (!has(backend_->features(), Feature::impacts)) return merged;
  for (PairEvent& impact : groups.impacts(impacts(groups.impact_speed()), steps_done_ - 1))
    merged.push_back(std::move(impact));
  return merged;
}

// Of all contacts where one is so fast.
template <class real>
std::vector<ContactImpact> Simulation<real>::impacts(double faster_than) {
  const Buffer wanted_speeds[] = {Buffer::impact_speeds};
  const std::vector<real> speeds = backend_->download(wanted_speeds).impact_speeds;
  const u32 count = counters_[COUNTER_CONTACTS];
  if (std::none_of(speeds.begin(), speeds.begin() + count, [&](real speed) { return double(speed) > faster_than; }))
    return {};
  std::vector<Buffer> wanted;
  add_contact_impulse_buffers(backend_->features(), wanted);
  const Buffers<real>& b = backend_->download(wanted);
  const auto vector = [](const Eigen::Vector3d& v) { return Vector3{v.x(), v.y(), v.z()}; };
  std::vector<ContactImpact> impacts;
  for (u32 i = 0; i < count; ++i) {
    const ContactGeometry geometry = contact_geometry(b, i);
    impacts.push_back({b.contacts[i].shape_a,
                       b.contacts[i].shape_b,
                       {double(speeds[i]), vector(geometry.point()), vector(geometry.normal),
                        vector(contact_impulse(b, i, geometry))}});
  }
  return impacts;
}

template <class real>
std::vector<WorldHash> Simulation<real>::world_hashes() {
  backend_->run(Stage::hash_state, params_);
  const Buffer wanted[] = {Buffer::world_hashes};
  return backend_->download(wanted).world_hashes;
}

template StepParams<float> params_of_step(StepParams<float>, u32, bool);
template StepParams<double> params_of_step(StepParams<double>, u32, bool);
template class Simulation<float>;
template class Simulation<double>;

}  // namespace lockstep
