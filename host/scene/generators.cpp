#include "host/scene/generators.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lockstep {

namespace {

// A random shift of each copy: amplitude times numbers in [-1, 1), drawn axis by axis from a sequence of its own.
struct Jitter {
  Vector3 amplitude = {0, 0, 0};
  std::array<unsigned, 3> order = {0, 1, 2};  // axes in the order in which they draw
  u32 seed = 0;

  Vector3 at(u32 index) const {
    exact::LcgByIndex random(seed + index);
    Vector3 shift;
    for (const unsigned axis : order) shift[axis] = amplitude[axis] * random.next_symmetric();
    return shift;
  }
};

enum class Randoms { lcg_by_index };

Jitter read_jitter(const JsonNode& node, Names& names) {
  node.expect_object({"generator", "seed", "amplitude", "order"});
  Jitter jitter;
  node.at("generator").choice<Randoms>("generator", {{"lcg_by_index", Randoms::lcg_by_index}});
  jitter.amplitude = node.at("amplitude").vector();
  if (node.has("seed")) jitter.seed = node.at("seed").integer(0, NONE);
  jitter.seed += names.seed * seed_stride;
  names.seeded = true;
  if (node.has("order")) {
    const std::string order = node.at("order").text();
    std::string sorted = order;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != "xyz") node.at("order").must_be("an order of the axes such as \"xyz\"");
    for (unsigned i = 0; i < 3; ++i) jitter.order[i] = static_cast<unsigned>(order[i] - 'x');
  }
  return jitter;
}

// A lattice: copy (i, j, k) stands at origin + (index - start) * spacing + jitter; i runs fastest.
struct Lattice {
  std::array<u32, 3> counts = {1, 1, 1};
  std::array<Vector3, 3> steps = {};  // one step along i, j, k
  Vector3 start = {0, 0, 0};          // of the index, for centred axes
  Vector3 origin = {0, 0, 0};
  u32 taper = 0;  // by so many copies along i each layer along k is shorter than the one below

  u32 count_i(u32 k) const { return counts[0] - taper * k; }
};

constexpr u32 most_rows = 10000;  // of a pyramid

u32 read_count(const JsonNode& node) { return node.integer(1, most_bodies); }

Lattice read_grid(const JsonNode& node) {
  Lattice lattice;
  const std::vector<JsonNode> counts = node.at("counts").elements();
  if (counts.size() != 3) node.at("counts").must_be("an array of 3 integers");
  const Vector3 spacing = node.at("spacing").vector();
  for (unsigned axis = 0; axis < 3; ++axis) {
    lattice.counts[axis] = read_count(counts[axis]);
    lattice.steps[axis][axis] = spacing[axis];
  }
  if (!node.has("centered")) return lattice;
  const std::vector<JsonNode> centered = node.at("centered").elements();
  if (centered.size() != 3) node.at("centered").must_be("an array of 3 booleans");
  for (unsigned axis = 0; axis < 3; ++axis) {
    if (centered[axis].boolean()) lattice.start[axis] = (lattice.counts[axis] - 1) * 0.5;
  }
  return lattice;
}

Lattice read_line(const JsonNode& node) {
  Lattice lattice;
  lattice.counts[0] = read_count(node.at("count"));
  lattice.steps[0] = node.at("step").vector();
  return lattice;
}

Lattice read_pyramid(const JsonNode& node) {
  Lattice lattice;
  const u32 rows = node.at("rows").integer(1, most_rows);
  const Vector3 spacing = node.at("spacing").vector();
  lattice.counts = {rows, 1, rows};
  for (unsigned axis = 0; axis < 3; ++axis) lattice.steps[axis][axis] = spacing[axis];
  lattice.taper = 1;
  return lattice;
}

// Off the axes of a grid the steps are zero and add nothing, so that each coordinate is
// (origin + (index - start) * spacing) + jitter, to the bit.
Vector3 lattice_point(const Lattice& lattice, const Jitter& jitter, const std::array<u32, 3>& index, u32 number) {
  Vector3 start = lattice.start, position = lattice.origin;
  if (lattice.taper > 0) start[0] = (lattice.count_i(index[2]) - 1) * 0.5;
  for (unsigned axis = 0; axis < 3; ++axis) {
    position = exact::add(position, exact::scale(index[axis] - start[axis], lattice.steps[axis]));
  }
  return exact::add(position, jitter.at(number));
}

BodyList read_templates(const JsonNode& node, Names& names) {
  BodyList templates = read_bodies(node.at("bodies"), names);
  if (templates.bodies.empty()) node.at("bodies").fail("is empty; a generator needs a body to copy");
  return templates;
}

// Turned as a whole about a line through the origin of the generator's frame.
BodyDescription rotated(BodyDescription body, const Quaternion& rotation) {
  body.position = exact::rotate(rotation, body.position);
  body.orientation = exact::unit(exact::multiply(rotation, body.orientation));
  body.velocity = exact::rotate(rotation, body.velocity);
  body.angular_velocity = exact::rotate(rotation, body.angular_velocity);
  return body;
}

// Copies on an arc: copy i is turned about the axis by start + i * step, then moved to the origin.
void expand_arc(const JsonNode& node, Names& names, BodyList& list) {
  node.expect_object({"generator", "count", "axis", "start_deg", "step_deg", "origin", "bodies"});
  const u32 count = read_count(node.at("count"));
  const Vector3 axis = read_direction(node.at("axis"));
  const double start = node.has("start_deg") ? node.at("start_deg").number() : 0, step = node.at("step_deg").number();
  const double last = start + (count - 1) * step;
  if (std::max({start, -start, last, -last}) > most_degrees)
    node.fail(
        fmt::format("goes from {1} to {2} degrees; both must be in -{0:.0f} .. {0:.0f}", most_degrees, start, last));
  const Vector3 origin = node.has("origin") ? node.at("origin").vector() : Vector3{0, 0, 0};
  const BodyList templates = read_templates(node, names);
  if (!templates.joints.empty()) node.at("bodies").fail("has joints; an arc does not turn joints");
  list.expect_room(node, count, templates.counts);
  for (u32 number = 0; number < count; ++number) {
    const double half = 0.5 * (start + number * step);
    const Quaternion rotation = exact::rotation(axis, exact::sine_of_degrees(half), exact::cosine_of_degrees(half));
    for (const BodyDescription& original : templates.bodies) {
      BodyDescription body = rotated(original, rotation);
      body.position = exact::add(origin, body.position);
      if (!body.name.empty()) body.name += fmt::format("_{}", number);
      list.add(std::move(body));
    }
  }
}

}  // namespace

void expand_generator(const JsonNode& node, Names& names, BodyList& list) {
  enum class Kind { grid, line, pyramid, arc };
  const auto kind =
      node.at("generator")
          .choice<Kind>("generator",
                        {{"grid", Kind::grid}, {"line", Kind::line}, {"pyramid", Kind::pyramid}, {"arc", Kind::arc}});
  if (kind == Kind::arc) {
    expand_arc(node, names, list);
    return;
  }
  if (kind == Kind::pyramid) {
    node.expect_object({"generator", "rows", "spacing", "origin", "jitter", "bodies", "joints"});
  } else if (kind == Kind::grid) {
    node.expect_object({"generator", "counts", "spacing", "origin", "centered", "jitter", "bodies", "joints"});
  } else {
    node.expect_object({"generator", "count", "step", "origin", "jitter", "bodies", "joints"});
  }
  Lattice lattice = kind == Kind::grid ? read_grid(node) : kind == Kind::line ? read_line(node) : read_pyramid(node);
  if (node.has("origin")) lattice.origin = node.at("origin").vector();
  const Jitter jitter = node.has("jitter") ? read_jitter(node.at("jitter"), names) : Jitter{};

  const BodyList templates = read_templates(node, names);
  std::vector<NamedJoint> joints = templates.joints;
  if (node.has("joints")) {
    for (NamedJoint& joint : read_joints(node.at("joints"), kind == Kind::line)) joints.push_back(std::move(joint));
  }
  double copies = 0;
  for (u32 k = 0; k < lattice.counts[2]; ++k) copies += 1.0 * lattice.count_i(k) * lattice.counts[1];
  list.expect_room(node, copies, templates.counts);

  u32 number = 0;
  for (u32 k = 0; k < lattice.counts[2]; ++k) {
    for (u32 j = 0; j < lattice.counts[1]; ++j) {
      for (u32 i = 0; i < lattice.count_i(k); ++i, ++number) {
        const Vector3 shift = lattice_point(lattice, jitter, {i, j, k}, number);
        for (BodyDescription body : templates.bodies) {
          body.position = exact::add(shift, body.position);
          if (!body.name.empty()) body.name += fmt::format("_{}", number);
          list.add(std::move(body));
        }
        add_copied_joints(joints, templates.bodies, number, static_cast<u32>(copies), shift, list.joints);
      }
    }
  }
}

}  // namespace lockstep
