#include "host/backends/first_contacts.hpp"

#include <algorithm>
#include <tuple>

#include "cpu_reference/reference.hpp"

namespace lockstep {

namespace {

template <class real>
Vector3 rotated(const Vec4<real>& q, const real (&v)[3]) {
  return exact::rotate({double(q.x), double(q.y), double(q.z), double(q.w)},
                       {double(v[0]), double(v[1]), double(v[2])});
}

template <class real>
Vector3 anchor_world(const Buffers<real>& b, u32 body, const real (&anchor)[3]) {
  const Vec4<real>& x = b.positions[body];
  return exact::add({double(x.x), double(x.y), double(x.z)}, rotated(b.orientations[body], anchor));
}

template <class real>
FirstContact measured(const Buffers<real>& b, u32 i) {
  const Contact& contact = b.contacts[i];
  const ContactPoint<real>& point = b.contact_points[i];
  const real n[3] = {point.normal[0], point.normal[1], point.normal[2]};
  Vector3 normal = {double(n[0]), double(n[1]), double(n[2])};
  if (contact.normal == NORMAL_OF_A) normal = rotated(b.orientations[contact.body_a], n);
  if (contact.normal == NORMAL_OF_B) normal = rotated(b.orientations[contact.body_b], n);
  const Vector3 offset =
      exact::subtract(anchor_world(b, contact.body_a, point.anchor_a), anchor_world(b, contact.body_b, point.anchor_b));
  const double gap = exact::dot(normal, offset) - double(point.radius_a) - double(point.radius_b);
  return {contact.body_a, contact.body_b, contact.shape_a, contact.shape_b, gap, normal};
}

// Lends the constants of a state, which may be large, to buffers whose lists have other lengths.
template <class real>
class Loan {
 public:
  explicit Loan(InitialState<real>& state) : state_(state) {
    swap_constants();
#define BUFFER(name, ...) \
  if (info(Buffer::name).lifetime == Lifetime::persistent) buffers.name = state.buffers.name;
#include "host/buffers.def"
#undef BUFFER
  }
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;
  ~Loan() { swap_constants(); }

  Buffers<real> buffers;

 private:
  void swap_constants() {
#define BUFFER(name, ...) \
  if (info(Buffer::name).lifetime == Lifetime::constant) std::swap(buffers.name, state_.buffers.name);
#include "host/buffers.def"
#undef BUFFER
  }

  InitialState<real>& state_;
};

// Runs the stages that find contacts, with lists as long as they need to be.
template <class real>
void collide(Buffers<real>& b, const InitialState<real>& state) {
  Sizes sizes = state.sizes;
  sizes.contacts = 4 * sizes.top_level() + PACK;
  sizes.blocks = sizes.rows = 1;
  sizes.coupled_tiles = 0;
  StepParams<real> params = state.params;
  for (;;) {
    params.pair_capacity = sizes.pairs;
    params.contact_capacity = sizes.contacts;
    resize(b, sizes, state.features);
    for (u32 s = 0; s <= static_cast<u32>(Stage::collide); ++s) {
      const Stage stage = static_cast<Stage>(s);
      if (runs(stage, state.features)) reference::run_stage(stage, b, params);
    }
    const u32 status = b.counters[COUNTER_STATUS];
    if ((status & STATUS_OUT_OF_GRID) != 0) b.counters[COUNTER_CONTACTS] = 0;  // the first step says so
    if ((status & STATUS_OUT_OF_GRID) != 0 || (status & (STATUS_PAIRS_FULL | STATUS_CONTACTS_FULL)) == 0) return;
    if ((status & STATUS_PAIRS_FULL) != 0) sizes.pairs = b.counters[COUNTER_PAIRS_NEEDED];
    if ((status & STATUS_CONTACTS_FULL) != 0) sizes.contacts = b.counters[COUNTER_CONTACTS_NEEDED];
  }
}

template <class real>
std::vector<FirstContact> contacts_of(InitialState<real>& state) {
  if (!has(state.features, Feature::contacts)) return {};
  Loan<real> loan(state);
  Buffers<real>& b = loan.buffers;
  collide(b, state);
  std::vector<u32> first_shapes(state.sizes.bodies);
  for (u32 shape = state.sizes.shapes; shape-- > 0;) first_shapes[b.shape_infos[shape].body] = shape;
  std::vector<FirstContact> contacts;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    FirstContact& contact = contacts.emplace_back(measured(b, i));
    contact.shape_a -= first_shapes[contact.body_a];
    contact.shape_b -= first_shapes[contact.body_b];
  }
  std::ranges::sort(contacts, {}, [](const FirstContact& c) { return std::tuple(c.body_a, c.body_b, c.gap); });
  const auto same = [](const FirstContact& c, const FirstContact& d) {
    return c.body_a == d.body_a && c.body_b == d.body_b;
  };
  contacts.erase(std::unique(contacts.begin(), contacts.end(), same), contacts.end());
  return contacts;
}

// Its first bodies, and what is between them.
Scene beginning_of(const Scene& scene) {
  Scene beginning;
  beginning.name = scene.name;
  beginning.source = scene.source;
  beginning.gravity = scene.gravity;
  beginning.settings = scene.settings;
  beginning.materials = scene.materials;
  beginning.material_pairs = scene.material_pairs;
  beginning.categories = scene.categories;
  beginning.particles = scene.particles;
  const std::size_t count = std::min<std::size_t>(scene.bodies.size(), most_bodies_looked_at);
  beginning.bodies.assign(scene.bodies.begin(), scene.bodies.begin() + static_cast<std::ptrdiff_t>(count));
  const auto is_there = [count](u32 body) { return body == NONE || body < count; };
  for (const JointDescription& joint : scene.joints)
    if (is_there(joint.body_a) && is_there(joint.body_b)) beginning.joints.push_back(joint);
  for (const auto& pair : scene.passing)
    if (is_there(pair[0]) && is_there(pair[1])) beginning.passing.push_back(pair);
  return beginning;
}

}  // namespace

template <class real>
std::vector<FirstContact> first_contacts(const Scene& scene, InitialState<real>& state) {
  if (scene.particles) return {};
  if (state.sizes.bodies <= most_bodies_looked_at && state.sizes.worlds == 1) return contacts_of(state);
  InitialState<real> beginning = compile<real>(beginning_of(scene));
  return contacts_of(beginning);
}

std::vector<FirstContact> first_contacts(const Scene& scene) {
  if (scene.particles) return {};
  const Scene beginning = beginning_of(scene);
  if (precision_of(scene.settings) == "double") {
    InitialState<double> state = compile<double>(beginning);
    return contacts_of(state);
  }
  InitialState<float> state = compile<float>(beginning);
  return contacts_of(state);
}

template std::vector<FirstContact> first_contacts<float>(const Scene&, InitialState<float>&);
template std::vector<FirstContact> first_contacts<double>(const Scene&, InitialState<double>&);

}  // namespace lockstep
