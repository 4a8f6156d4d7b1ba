#include "host/steppers/told_contacts.hpp"

#include <tuple>

#include "host/contact_geometry.hpp"

namespace lockstep {

namespace {

Vector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

// Both lists are in order, and a contact whose bodies fell asleep in this step is in both.
template <class real>
std::vector<ToldContact> told_contacts(Backend<real>& backend, const Counters& counters,
                                       std::span<const ShapeInfo> shapes, const DescribedShapes& described) {
  if (!has(backend.features(), Feature::contacts)) return {};
  const bool sleeping = has(backend.features(), Feature::sleeping);
  std::vector<Buffer> wanted = {Buffer::positions, Buffer::orientations, Buffer::contacts, Buffer::contact_points,
                                Buffer::cached_impulses};
  if (sleeping)
    wanted.insert(wanted.end(),
                  {Buffer::slept_count, Buffer::slept_keys, Buffer::slept_impulses, Buffer::slept_points});
  const Buffers<real>& b = backend.download(wanted);
  std::vector<ToldContact> contacts;
  const auto add = [&](const auto& contact, const ContactPoint<real>& point, const ContactImpulse<real>& impulse) {
    const u32 body_a = shapes[contact.shape_a].body, body_b = shapes[contact.shape_b].body;
    const ContactGeometry geometry = contact_geometry(b, body_a, body_b, contact.normal, point);
    const u32 world = described.world_of(described.description_of(contact.shape_a));
    contacts.push_back({world, described[contact.shape_a], described[contact.shape_b], vector(geometry.point()),
                        vector(geometry.normal), vector(contact_impulse(impulse, geometry)), geometry.gap()});
  };
  const auto key_of = [](const auto& contact) { return std::tuple(contact.shape_a, contact.shape_b, contact.feature); };
  const u32 count = counters[COUNTER_CONTACTS], slept = sleeping ? b.slept_count[0] : 0;
  u32 k = 0;
  for (u32 i = 0; i < count; ++i) {
    for (; k < slept && key_of(b.slept_keys[k]) < key_of(b.contacts[i]); ++k)
      add(b.slept_keys[k], b.slept_points[k], b.slept_impulses[k]);
    if (k < slept && key_of(b.slept_keys[k]) == key_of(b.contacts[i])) ++k;
    add(b.contacts[i], b.contact_points[i], b.cached_impulses[i]);
  }
  for (; k < slept; ++k) add(b.slept_keys[k], b.slept_points[k], b.slept_impulses[k]);
  return contacts;
}

template std::vector<ToldContact> told_contacts(Backend<float>&, const Counters&, std::span<const ShapeInfo>,
                                                const DescribedShapes&);
template std::vector<ToldContact> told_contacts(Backend<double>&, const Counters&, std::span<const ShapeInfo>,
                                                const DescribedShapes&);

}  // namespace lockstep
