#include "host/scene/suspicions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "host/scene/below_ground.hpp"
#include "host/scene/compile_articulations.hpp"
#include "host/scene/hull.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/mass_properties.hpp"
#include "host/scene/rounding.hpp"
#include "host/scene/surface.hpp"
#include "host/scene/touching.hpp"

namespace lockstep {

namespace {

constexpr std::size_t most_named = 3;

// Sizes of this many metres are fallen through in seconds: in millimetres they are those of a hand.
constexpr double large_body = 50;                           // m
constexpr double least_gravity = 9, most_gravity = 10.7;    // m/s^2, of the Earth
constexpr double least_density = 1e-3, most_density = 1e6;  // kg/m^3: air has 1.2, osmium 22,600
constexpr double deep = 0.05;                               // of the smaller one's smallest dimension
constexpr double great_ratio = 1e5;                         // of masses
constexpr double long_step = 0.05;                          // s, of a sub-step
constexpr double long_fall = 0.05;                          // of a body's smallest dimension, in a sub-step

// Lines of one kind: the first ones, and how many others there are.
class Lines {
 public:
  explicit Lines(std::vector<std::string>& all) : all_(all) {}
  ~Lines() {
    if (count_ > most_named) all_.back() += fmt::format(" (and {} more)", count_ - most_named);
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  template <class Words>
  void add(Words&& words) {
    if (count_++ < most_named) all_.push_back(words());
  }

 private:
  std::vector<std::string>& all_;
  std::size_t count_ = 0;
};

std::string name_of(const char* what, std::size_t index, const std::string& name) {
  return fmt::format("{} {}", what, index) + (name.empty() ? "" : fmt::format(" ({})", quote(name)));
}

bool is_dynamic(const BodyDescription& body) { return body.kind == BODY_DYNAMIC; }

// Edges of the box around a shape, in its frame; none of a plane.
std::optional<Vector3> extents_of(const ShapeDescription& shape) {
  switch (shape.kind) {
    case SHAPE_SPHERE: return Vector3{2 * shape.radius, 2 * shape.radius, 2 * shape.radius};
    case SHAPE_CAPSULE: return Vector3{2 * shape.radius, 2 * shape.radius, 2 * (shape.radius + shape.half_length)};
    case SHAPE_CYLINDER: return Vector3{2 * shape.radius, 2 * shape.radius, 2 * shape.half_length};
    case SHAPE_BOX: return exact::scale(2, shape.half_extents);
    case SHAPE_HULL: return exact::scale(2, half_extents_of(shape.points));
    case SHAPE_MESH: return exact::scale(2, half_extents_of(shape.mesh->vertices));
    default: return std::nullopt;
  }
}

double smallest(const Vector3& v) { return std::min({v[0], v[1], v[2]}); }
double largest(const Vector3& v) { return std::max({v[0], v[1], v[2]}); }

double infinite() { return std::numeric_limits<double>::infinity(); }

// The thickness of a shape: infinite where it is ground without end, or a triangle of it.
double thickness_of(const ShapeDescription& shape) {
  const std::optional<Vector3> extents = extents_of(shape);
  return extents ? smallest(*extents) : infinite();
}

// Of the widest of its solid shapes; 0 where it has none.
double size_of(const BodyDescription& body) {
  double size = 0;
  for (const ShapeDescription& shape : body.shapes)
    if (const auto extents = extents_of(shape); extents && !shape.trigger) size = std::max(size, largest(*extents));
  return size;
}

double thickness_of(const BodyDescription& body) {
  double thickness = infinite();
  for (const ShapeDescription& shape : body.shapes)
    if (!shape.trigger) thickness = std::min(thickness, thickness_of(shape));
  return thickness;
}

std::optional<double> median(std::vector<double> numbers) {
  if (numbers.empty()) return std::nullopt;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

// "0.12 m"
std::string metres(double length) { return fmt::format("{:.3g} m", length); }

class Suspicions {
 public:
  Suspicions(const Scene& scene, std::span<const FirstContact> contacts) : scene_(scene), contacts_(contacts) {}

  std::vector<std::string> run() {
    if (!look_at_sizes()) look_at_densities();
    look_at_gravity();
    look_at_quaternions();
    look_at_step();
    look_at_overlaps();
    look_at_surfaces();
    look_at_masses();
    return std::move(lines_);
  }

 private:
  std::string body(std::size_t index) const { return name_of("body", index, scene_.bodies[index].name); }
  std::vector<u32> joints_of_bodies() const {
    std::vector<u32> counts(scene_.bodies.size());
    for (const JointDescription& joint : scene_.joints)
      for (const u32 end : {joint.body_a, joint.body_b})
        if (end != NONE) ++counts[end];
    return counts;
  }
  double gravity() const { return exact::length(scene_.gravity); }

  // Bodies of tens of metres beside the gravity of the Earth. Without it they may be of any size, and ground may
  // anyway.
  bool look_at_sizes() {
    if (gravity() < least_gravity || gravity() > most_gravity) return false;
    std::vector<double> sizes;
    for (const BodyDescription& body : scene_.bodies)
      if (is_dynamic(body) && size_of(body) > 0) sizes.push_back(size_of(body));
    const std::optional<double> typical = median(std::move(sizes));
    if (!typical || *typical < large_body) return false;
    lines_.push_back(fmt::format(
        "bodies of about {} fall slowly beside a gravity of {:.3g} m/s^2: if they are given in millimetres, "
        "divide lengths by 1000, or multiply gravity by that",
        metres(*typical), gravity()));
    return true;
  }

  // Of bodies of their own: the shapes of a robot's link may be a small share of it.
  // Where things fall faster than on Earth lengths are in other units, and densities with them.
  void look_at_densities() {
    if (gravity() > most_gravity) return;
    const std::vector<u32> joints = joints_of_bodies();
    std::vector<double> densities;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const BodyDescription& body = scene_.bodies[i];
      if (!is_dynamic(body) || joints[i] > 0 || size_of(body) == 0) continue;
      double volume = 0;
      for (const ShapeDescription& shape : body.shapes)
        if (!shape.trigger) volume += mass_properties(shape, 1).mass;
      if (volume > 0) densities.push_back(body.mass / volume);
    }
    const std::optional<double> typical = median(std::move(densities));
    if (!typical || (*typical >= least_density && *typical <= most_density)) return;
    lines_.push_back(fmt::format(
        "bodies have a density of about {:.2g} kg/m^3 (water has 1000): give lengths in metres and masses in "
        "kilograms",
        *typical));
  }

  // Which axis the ground is along: the normals of static planes and the areas of surfaces that nothing pushes, and
  // whether any of it can carry what falls.
  void look_at_gravity() {
    if (gravity() == 0 || std::ranges::none_of(scene_.bodies, is_dynamic)) return;
    const Vector3 up = exact::scale(-1 / gravity(), scene_.gravity);
    bool carries = false, lies_along_z = false;
    for (const BodyDescription& body : scene_.bodies) {
      if (is_dynamic(body)) continue;
      Vector3 area = {0, 0, 0};
      for (const ShapeDescription& shape : body.shapes) {
        const auto world = [&](const Vector3& v) {
          return exact::rotate(body.orientation, exact::rotate(shape.rotation, v));
        };
        if (shape.kind == SHAPE_PLANE) {
          const Vector3 normal = world({0, 0, 1});
          carries = carries || exact::dot(normal, up) > 0.5;
          lies_along_z = lies_along_z || normal[2] > 0.99;
        } else if (shape.kind == SHAPE_FACET) {
          for (u32 t = 0; t < shape.surface->facets.size(); ++t) {
            const std::array<Vector3, 3> c = corners_of_facet(*shape.surface, t);
            area = exact::add(area, world(exact::cross(exact::subtract(c[1], c[0]), exact::subtract(c[2], c[0]))));
          }
        } else if (const auto extents = extents_of(shape)) {
          // a slab, which is ground or a wall; what is as thick as it is wide can carry on any side
          const bool is_slab = shape.kind == SHAPE_BOX &&
                               4 * smallest(*extents) <= median({(*extents)[0], (*extents)[1], (*extents)[2]});
          Vector3 thin = {0, 0, 0};
          for (unsigned k = 0; k < 3 && is_slab; ++k)
            if ((*extents)[k] == smallest(*extents)) thin[k] = 1;
          const Vector3 normal = world(thin);
          carries = carries || !is_slab || std::abs(exact::dot(normal, up)) > 0.5;
          lies_along_z = lies_along_z || std::abs(normal[2]) > 0.99;
        }
      }
      const double all = exact::length(area);
      carries = carries || (all > 0 && exact::dot(area, up) > 0.5 * all);
      lies_along_z = lies_along_z || (all > 0 && area[2] > 0.9 * all);
    }
    if (carries || !lies_along_z) return;
    const Vector3& g = scene_.gravity;
    const bool upwards = g[2] > 0.9 * gravity();
    const bool sideways = std::max(std::abs(g[0]), std::abs(g[1])) > 0.9 * gravity();
    if (!upwards && !sideways) return;
    lines_.push_back(
        fmt::format("gravity of [{:.4g}, {:.4g}, {:.4g}] points {}, and nothing lies there: z is up, so that it is "
                    "[0, 0, {:.4g}] where the ground is below",
                    g[0], g[1], g[2], upwards ? "up" : "along the ground", -gravity()));
  }

  // Half a rotation about x, of what looks the same after it: written on purpose by nobody, and the identity where w is
  // taken to come first.
  void look_at_quaternions() {
    constexpr Quaternion w_first = {1, 0, 0, 0};
    const auto looks_the_same = [&](const ShapeDescription& shape) {
      const bool symmetric = shape.kind == SHAPE_SPHERE || shape.kind == SHAPE_CAPSULE || shape.kind == SHAPE_BOX ||
                             shape.kind == SHAPE_CYLINDER;
      return symmetric && shape.offset[1] == 0 && shape.offset[2] == 0 &&
             (shape.rotation == Quaternion{0, 0, 0, 1} || shape.rotation == w_first);
    };
    const std::vector<u32> joints = joints_of_bodies();
    Lines lines(lines_);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const BodyDescription& b = scene_.bodies[i];
      if (b.orientation != w_first || b.pivoted || joints[i] > 0 || b.shapes.empty() ||
          !std::ranges::all_of(b.shapes, looks_the_same))
        continue;
      lines.add([&] {
        return body(i) +
               " has the orientation [1, 0, 0, 0], half a rotation about x, which changes nothing of its shapes: w "
               "comes "
               "last, and no rotation is [0, 0, 0, 1]";
      });
    }
  }

  // How far a body falls in a sub-step that started at rest, beside how thick it is.
  void look_at_step() {
    const double h = scene_.settings.dt / substeps_of(scene_.settings);
    if (h < long_step || (scene_.joints.empty() && !shapes_can_touch(scene_))) return;
    std::vector<double> thick;
    for (const BodyDescription& body : scene_.bodies)
      if (const double thickness = thickness_of(body); is_dynamic(body) && std::isfinite(thickness))
        thick.push_back(thickness);
    const std::optional<double> typical = median(std::move(thick));
    const double fall = gravity() * h * h;
    if (!typical || fall < long_fall * *typical) return;
    lines_.push_back(fmt::format(
        "in a step of {:.3g} s a body falls {}, and bodies are about {} thick: contacts and joints are coarse, "
        "and what is fast is not met; take a \"dt\" of 1/60 or less, or more \"substeps\"",
        h, metres(fall), metres(*typical)));
  }

  const ShapeDescription& shape_a(const FirstContact& c) const {
    return description_of(scene_.bodies[c.body_a], c.shape_a);
  }
  const ShapeDescription& shape_b(const FirstContact& c) const {
    return description_of(scene_.bodies[c.body_b], c.shape_b);
  }

  void look_at_overlaps() {
    Lines lines(lines_);
    for (const FirstContact& c : contacts_) {
      const double depth = -c.gap, size = std::min(thickness_of(shape_a(c)), thickness_of(shape_b(c)));
      if (depth <= scene_.settings.slop.value_or(0) || depth <= deep * size) continue;
      const bool a_moves = is_dynamic(scene_.bodies[c.body_a]);
      const u32 mover = a_moves ? c.body_a : c.body_b, other = a_moves ? c.body_b : c.body_a;
      const bool below = (a_moves ? shape_b(c) : shape_a(c)).kind == SHAPE_PLANE;
      lines.add([&] {
        return fmt::format(
            "{} starts {} {} {}, {:.0f} % of the thinner one, and is pushed out: move it{}, or let the two "
            "pass through each other (\"category\" and \"collides_with\")",
            body(mover), metres(depth), below ? "below" : "inside", body(other), 100 * depth / size,
            below ? " up" : "");
      });
    }
  }

  void look_at_surfaces() {
    Lines lines(lines_);
    for (const BelowGround& below : bodies_below_ground(scene_)) {
      lines.add([&] {
        return fmt::format("{} starts {} below {}, whose triangles have one side, and falls for ever: start above it",
                           body(below.body), metres(below.depth), body(below.ground));
      });
    }
  }

  // Sweeps carry a heavy body on a light one slowly: the error shrinks by a share of about the ratio. That of small
  // steps does by the square of their number (docs/theory/solvers.md), and oracles sweep until it has gone.
  void look_at_masses() {
    const Settings& settings = scene_.settings;
    if (is_oracle(settings.solver)) return;
    const double substeps = settings.solver == Solver::small_steps ? substeps_of(settings) : 1;
    const double great = std::max(great_ratio, substeps * substeps);
    Lines lines(lines_);
    const auto ratio = [&](u32 heavy, u32 light) {
      const BodyDescription &h = scene_.bodies[heavy], &l = scene_.bodies[light];
      return is_dynamic(h) && is_dynamic(l) ? h.mass / l.mass : 0;
    };
    const auto add = [&](u32 heavy, u32 light, const char* how) {
      lines.add([&] {
        return fmt::format(
            "{} of {:.3g} kg {} {} of {:.3g} kg: at such a ratio iterations hardly converge; make the "
            "masses more equal, or take the solver \"small_steps\" with more \"substeps\"",
            body(heavy), scene_.bodies[heavy].mass, how, body(light), scene_.bodies[light].mass);
      });
    };
    for (const FirstContact& c : contacts_) {
      const double up = gravity() > 0 ? -exact::dot(c.normal, scene_.gravity) / gravity() : 0;
      if (up > 0.5 && ratio(c.body_a, c.body_b) >= great) add(c.body_a, c.body_b, "stands on");
      if (up < -0.5 && ratio(c.body_b, c.body_a) >= great) add(c.body_b, c.body_a, "stands on");
    }
    if (takes_trees(settings.solver) && settings.joint_solver != JointSolver::sweeps) return;
    // a light body that only hangs on a heavy one carries nothing
    const std::vector<u32> joints = joints_of_bodies();
    for (const JointDescription& joint : scene_.joints) {
      if (joint.body_a == NONE || joint.body_b == NONE) continue;
      for (const auto& [heavy, light] : {std::pair(joint.body_a, joint.body_b), std::pair(joint.body_b, joint.body_a)})
        if (joints[light] > 1 && ratio(heavy, light) >= great) add(heavy, light, "is carried by a joint to");
    }
  }

  const Scene& scene_;
  const std::span<const FirstContact> contacts_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> suspicions_of(const Scene& scene, std::span<const FirstContact> contacts) {
  return Suspicions(scene, contacts).run();
}

}  // namespace lockstep
