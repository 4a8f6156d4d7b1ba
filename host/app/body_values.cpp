#include "host/app/body_values.hpp"

#include <cmath>
#include <limits>

#include "host/contact_geometry.hpp"
#include "host/report/measures.hpp"

namespace lockstep::app {

namespace {

// Keeps the largest number that each body is told.
class Largest {
 public:
  explicit Largest(u32 bodies) : values_(bodies, std::numeric_limits<float>::quiet_NaN()) {}

  void tell(u32 body, double value) {
    if (body >= values_.size()) return;  // the world
    const float number = static_cast<float>(value);
    if (!(values_[body] >= number)) values_[body] = number;
  }

  std::vector<float> values_;
};

template <class real>
std::vector<float> speeds(const Buffers<real>& buffers, u32 bodies) {
  std::vector<float> values(bodies);
  for (u32 i = 0; i < bodies; ++i) {
    const real* v = buffers.motions[i].v;
    values[i] = static_cast<float>(std::hypot(double(v[0]), double(v[1]), double(v[2])));
  }
  return values;
}

std::vector<float> contact_counts(const std::vector<Contact>& contacts, u32 count, u32 bodies) {
  std::vector<float> values(bodies, 0);
  for (u32 i = 0; i < count; ++i) {
    values[contacts[i].body_a] += 1;
    values[contacts[i].body_b] += 1;
  }
  return values;
}

// Contacts that are not the first of their pair follow it, and have its colour.
std::vector<float> last_colors(const std::vector<Contact>& contacts, const std::vector<u32>& colors, u32 count,
                               u32 bodies) {
  Largest last(bodies);
  u32 color = 0;
  for (u32 i = 0; i < count; ++i) {
    if (colors[i] != COLOR_OF_FIRST) color = colors[i];
    last.tell(contacts[i].body_a, color);
    last.tell(contacts[i].body_b, color);
  }
  return last.values_;
}

template <class real>
std::vector<float> penetrations(const Buffers<real>& buffers, u32 count, u32 bodies) {
  Largest deepest(bodies);
  for (u32 i = 0; i < count; ++i) {
    const double depth = std::max(-1000 * contact_geometry(buffers, i).gap(), 0.0);
    deepest.tell(buffers.contacts[i].body_a, depth);
    deepest.tell(buffers.contacts[i].body_b, depth);
  }
  return deepest.values_;
}

template <class real>
std::vector<float> defects(const Buffers<real>& buffers, const Counters& counters, u32 bodies, Features features) {
  const ContactSystem system = contact_system(buffers, counters, features);
  const DefectVelocities each = defect_velocities(system);
  Largest largest(bodies);
  for (std::size_t i = 0; i < system.contacts.size(); ++i) {
    largest.tell(system.contacts[i].body_a, each.contacts[i]);
    largest.tell(system.contacts[i].body_b, each.contacts[i]);
  }
  for (std::size_t i = 0; i < system.joints.size(); ++i) {
    largest.tell(system.joints[i].body_a, each.joints[i]);
    largest.tell(system.joints[i].body_b, each.joints[i]);
  }
  return largest.values_;
}

}  // namespace

std::string title_of(ColorBy by) {
  switch (by) {
    case ColorBy::body: return "bodies";
    case ColorBy::speed: return "speed, m/s";
    case ColorBy::contacts: return "contacts of a body";
    case ColorBy::color: return "last colour that solves a body";
    case ColorBy::penetration: return "deepest penetration, mm";
    case ColorBy::residual: return "largest defect velocity, m/s";
  }
  return "";
}

bool needs_contacts(ColorBy by) { return by != ColorBy::body && by != ColorBy::speed; }

std::vector<Buffer> value_buffers(ColorBy by, Features features) {
  const bool touching = has(features, Feature::contacts);
  switch (by) {
    case ColorBy::body: return {};
    case ColorBy::speed: return {Buffer::motions};
    case ColorBy::contacts: return touching ? std::vector<Buffer>{Buffer::contacts} : std::vector<Buffer>();
    case ColorBy::color:
      return touching ? std::vector<Buffer>{Buffer::contacts, Buffer::contact_colors} : std::vector<Buffer>();
    case ColorBy::penetration:
    case ColorBy::residual: return measured_buffers(features);
  }
  return {};
}

template <class real>
std::vector<float> body_values(ColorBy by, const Buffers<real>& buffers, u32 bodies, Features features,
                               const Counters& counters) {
  const u32 contacts = has(features, Feature::contacts) ? counters[COUNTER_CONTACTS] : 0;
  switch (by) {
    case ColorBy::body: return {};
    case ColorBy::speed: return speeds(buffers, bodies);
    case ColorBy::contacts: return contact_counts(buffers.contacts, contacts, bodies);
    case ColorBy::color: return last_colors(buffers.contacts, buffers.contact_colors, contacts, bodies);
    case ColorBy::penetration: return penetrations(buffers, contacts, bodies);
    case ColorBy::residual: return defects(buffers, counters, bodies, features);
  }
  return {};
}

template std::vector<float> body_values(ColorBy, const Buffers<float>&, u32, Features, const Counters&);
template std::vector<float> body_values(ColorBy, const Buffers<double>&, u32, Features, const Counters&);

}  // namespace lockstep::app
