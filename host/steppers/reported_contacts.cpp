#include "host/steppers/reported_contacts.hpp"

#include <tuple>

namespace lockstep {

namespace {

Vector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

// Both lists are in order, and a contact whose bodies fell asleep in this step is in both.
template <class real>
std::vector<StepContact> step_contacts(Backend<real>& backend, const StepParams<real>& params, const Counters& counters,
                                       std::span<const ShapeInfo> shapes) {
  if (!has(backend.features(), Feature::contacts)) return {};
  const bool sleeping = has(backend.features(), Feature::sleeping);
  std::vector<Buffer> wanted;
  add_contact_impulse_buffers(backend.features(), wanted);
  if (sleeping)
    wanted.insert(wanted.end(),
                  {Buffer::slept_count, Buffer::slept_keys, Buffer::slept_impulses, Buffer::slept_points});
  const Buffers<real>& b = backend.download(wanted);
  std::vector<StepContact> contacts;
  const auto add = [&](const auto& contact, const ContactGeometry& geometry, const Eigen::Vector3d& impulse) {
    contacts.push_back({shapes[contact.shape_a].body, shapes[contact.shape_b].body, contact.shape_a, contact.shape_b,
                        geometry, impulse});
  };
  // what sleeps is at rest: in each sub-step of a step it would carry the same
  const double times = impulse_time(params, backend.features()) / double(params.dt);
  const auto add_slept = [&](u32 k) {
    const ContactKey& key = b.slept_keys[k];
    const ContactGeometry geometry =
        contact_geometry(b, shapes[key.shape_a].body, shapes[key.shape_b].body, key.normal, b.slept_points[k]);
    add(key, geometry, times * contact_impulse(b.slept_impulses[k], geometry));
  };
  const auto key_of = [](const auto& contact) { return std::tuple(contact.shape_a, contact.shape_b, contact.feature); };
  const u32 count = counters[COUNTER_CONTACTS], slept = sleeping ? b.slept_count[0] : 0;
  u32 k = 0;
  for (u32 i = 0; i < count; ++i) {
    for (; k < slept && key_of(b.slept_keys[k]) < key_of(b.contacts[i]); ++k) add_slept(k);
    if (k < slept && key_of(b.slept_keys[k]) == key_of(b.contacts[i])) ++k;
    const ContactGeometry geometry = contact_geometry(b, i);
    add(b.contacts[i], geometry, contact_impulse(b, i, geometry));
  }
  for (; k < slept; ++k) add_slept(k);
  return contacts;
}

template <class real>
std::vector<ReportedContact> reported_contacts(Backend<real>& backend, const StepParams<real>& params,
                                               const Counters& counters, std::span<const ShapeInfo> shapes,
                                               const DescribedShapes& described) {
  std::vector<ReportedContact> contacts;
  for (const StepContact& contact : step_contacts(backend, params, counters, shapes)) {
    const u32 world = described.world_of(described.description_of(contact.shape_a));
    const ContactGeometry& geometry = contact.geometry;
    contacts.push_back({world, described[contact.shape_a], described[contact.shape_b], vector(geometry.point()),
                        vector(geometry.normal), vector(contact.impulse), geometry.gap()});
  }
  return contacts;
}

#define INSTANTIATE(real)                                                                                           \
  template std::vector<StepContact> step_contacts(Backend<real>&, const StepParams<real>&, const Counters&,         \
                                                  std::span<const ShapeInfo>);                                      \
  template std::vector<ReportedContact> reported_contacts(Backend<real>&, const StepParams<real>&, const Counters&, \
                                                          std::span<const ShapeInfo>, const DescribedShapes&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
