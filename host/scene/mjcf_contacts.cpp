#include "host/scene/mjcf_contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace lockstep {

FurtherFriction MjcfContacts::Surface::further() const {
  FurtherFriction more;
  if (condim >= 4 && friction[0] > 0) more.torsional_friction = friction[1];
  if (condim >= 6) more.rolling_friction = friction[2];
  return more;
}

u32 MjcfContacts::surface_of(const MjcfElement& geom) {
  Surface surface;
  surface.condim = geom.number("condim", 3);
  surface.priority = geom.number("priority", 0);
  if (geom.has("friction")) {
    const std::vector<double> given = geom.holder("friction").numbers("friction", 1, 3);
    std::ranges::copy(given, surface.friction.begin());
    if (!std::ranges::all_of(given, [](double mu) { return mu >= 0; }))
      geom.holder("friction").fail("friction", "must be >= 0");
  }
  const auto found = std::ranges::find(surfaces_, surface);
  if (found != surfaces_.end()) return static_cast<u32>(found - surfaces_.begin());
  surfaces_.push_back(surface);
  return static_cast<u32>(surfaces_.size()) - 1;
}

bool MjcfContacts::set(const MjcfElement& geom, ShapeDescription& shape) {
  const auto bits = [&](const char* attribute) {
    const double value = geom.number(attribute, 1);
    if (!(value >= 0 && value <= 4294967295.0) || value != std::floor(value))
      geom.holder(attribute).fail(attribute, fmt::format("must be an integer of 32 bits, is {}", value));
    return static_cast<u32>(value);
  };
  const Filter filter = {bits("contype"), bits("conaffinity")};
  shape.category = 1;
  if (filter.contype == 0 && filter.conaffinity == 0) return false;
  const auto found = std::ranges::find(filters_, filter);
  shape.category = 1u << (found - filters_.begin());
  if (found == filters_.end()) {
    if (filters_.size() == 32)
      geom.node().fail("is the 33rd pair of contype and conaffinity; a robot can have 32, (1, 1) among them");
    filters_.push_back(filter);
  }
  shape.material = surface_of(geom);
  return true;
}

RobotContacts MjcfContacts::contacts(std::vector<RobotLink>& links) const {
  RobotContacts contacts;
  contacts.classes = static_cast<u32>(filters_.size());
  for (const Surface& surface : surfaces_) {
    Material material = {fmt::format("surface {}", contacts.materials.size()), surface.sliding(), 0};
    material.further = surface.further();
    contacts.materials.push_back(material);
  }
  if (contacts.materials.empty()) contacts.materials.push_back({"surface 0", 1, 0});
  for (u32 a = 0; a < surfaces_.size(); ++a) {
    for (u32 b = a + 1; b < surfaces_.size(); ++b) {
      const Surface &x = surfaces_[a], &y = surfaces_[b];
      const Surface& higher = x.priority > y.priority ? x : y;
      Surface both = higher;
      if (x.priority == y.priority) {
        for (std::size_t i = 0; i < both.friction.size(); ++i)
          both.friction[i] = std::max(x.friction[i], y.friction[i]);
        both.condim = std::max(x.condim, y.condim);
      }
      MaterialPairRule rule = {a, b, both.sliding(), 0};
      rule.further = both.further();
      contacts.pairs.push_back(rule);
    }
  }
  std::vector<u32> masks(filters_.size(), 0);
  for (u32 a = 0; a < filters_.size(); ++a) {
    for (u32 b = 0; b < filters_.size(); ++b) {
      const Filter &x = filters_[a], &y = filters_[b];
      if ((x.contype & y.conaffinity) != 0 || (y.contype & x.conaffinity) != 0) masks[a] |= 1u << b;
    }
  }
  for (RobotLink& link : links)
    for (ShapeDescription& shape : link.shapes) shape.mask = masks[static_cast<u32>(std::countr_zero(shape.category))];
  return contacts;
}

}  // namespace lockstep
