#include "host/scene/compile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/error.hpp"
#include "host/scene/broad_phase.hpp"
#include "host/scene/compile_gradient.hpp"
#include "host/scene/compile_joints.hpp"
#include "host/scene/compile_loads.hpp"
#include "host/scene/compile_oracle.hpp"
#include "host/scene/compile_particles.hpp"
#include "host/scene/compile_partitions.hpp"
#include "host/scene/compile_seams.hpp"
#include "host/scene/compile_shape_trees.hpp"
#include "host/scene/compile_sleeping.hpp"
#include "host/scene/contact_features.hpp"
#include "host/scene/expect_fits.hpp"
#include "host/scene/friction_pairs.hpp"
#include "host/scene/hull.hpp"
#include "host/scene/hull_tables.hpp"
#include "host/scene/impact_laws.hpp"
#include "host/scene/rounding.hpp"
#include "host/scene/shape_kinds.hpp"
#include "host/scene/shape_size.hpp"
#include "host/scene/shape_tolerances.hpp"
#include "host/scene/step_params.hpp"
#include "host/scene/surface.hpp"
#include "host/scene/touching.hpp"

namespace lockstep {

namespace {

// Lists are indexed by 32 bits, and are several times as long.
constexpr std::size_t most_in_batch = std::size_t{1} << 27;

bool is_isotropic(const Vector3& inertia) { return inertia[0] == inertia[1] && inertia[1] == inertia[2]; }

// Principal moments that the motion sees: about the centre of mass, or about the pivot by the theorem of parallel axes:
// I + m (l.l E - l l^T), diagonal because the offset lies along a principal axis.
Vector3 moments(const BodyDescription& body) {
  if (!body.pivoted) return body.inertia;
  const double square = body.mass * exact::dot(body.com_offset, body.com_offset);
  Vector3 about_pivot = body.inertia;
  for (unsigned i = 0; i < 3; ++i) {
    if (body.com_offset[i] == 0) about_pivot[i] += square;
  }
  return about_pivot;
}

// R diag(1/I) R^T, world frame: xx, yy, zz, xy, xz, yz. An isotropic one stays exactly so.
std::array<double, 6> inverse_inertia_world(const Vector3& inertia, const Quaternion& orientation) {
  if (is_isotropic(inertia)) return {1 / inertia[0], 1 / inertia[0], 1 / inertia[0], 0, 0, 0};
  const Vector3 x = exact::rotate(orientation, {1, 0, 0});
  const Vector3 y = exact::rotate(orientation, {0, 1, 0});
  const Vector3 z = exact::rotate(orientation, {0, 0, 1});
  const auto entry = [&](unsigned i, unsigned j) {
    return x[i] * x[j] / inertia[0] + y[i] * y[j] / inertia[1] + z[i] * z[j] / inertia[2];
  };
  return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
}

template <class real>
class Compiler {
 public:
  explicit Compiler(std::span<const Scene> worlds) : worlds_(worlds) {}

  InitialState<real> run() {
    expect_oracle_takes(worlds_, sizeof(real) == sizeof(double));
    if (const Settings& settings = worlds_[0].settings; is_oracle(settings.solver))
      state_.oracle = {name_of(settings.solver), settings.directions};
    add_worlds();
    buffers().motions.push_back({});  // the null body behind the last one
    set_features();
    set_sizes();
    if (worlds_[0].settings.sleeping) compile_sleeping(worlds_[0], state_);
    compile_joints(worlds_, state_);
    if (has(state_.features, Feature::gradient))
      compile_gradient(worlds_[0].settings.solver == Solver::accelerated_gradient, state_);
    if (has(state_.features, Feature::particles)) compile_particles(worlds_, state_);
    if (has(state_.features, Feature::partitions)) compile_partitions(worlds_, state_);
    resize(state_.buffers, state_.sizes, state_.features);
    support_weights(worlds_, state_.buffers);
    state_.params = make_params<real>(worlds_[0], state_.sizes, state_.features);
    return std::move(state_);
  }

  Buffers<real> shapes() {
    add_worlds();
    return std::move(state_.buffers);
  }

  void add_alone(const BodyDescription& body) {
    const Origin origin = {worlds_[0]};
    add_body(body, 0, 0, origin);
    for (const ShapeDescription& shape : body.shapes) add_shape(bounding_cube(shape), body.continuous, 0, 0, origin);
  }

 private:
  Buffers<real>& buffers() { return state_.buffers; }

  void add_worlds() {
    make_room();
    for (u32 world = 0; world < worlds_.size(); ++world) add_world(world);
  }
  void make_room();
  void add_world(u32 world);
  void add_body(const BodyDescription& body, u32 world, u32 id, const Origin& origin);
  void add_shape(const ShapeDescription& shape, bool continuous, u32 body, u32 id, const Origin& origin);
  void add_surface(const ShapeDescription& whole, bool continuous, u32 body, u32 first_id, const Origin& origin);
  void add_material_pairs(const Scene& scene);
  void set_features();
  void set_sizes();

  std::span<const Scene> worlds_;
  InitialState<real> state_;
  HullIndex hulls_;
  bool other_laws_ = false;           // of impact than Newton's
  bool angular_friction_ = false;     // some materials have angular friction, or are anisotropic
  bool anisotropic_ = false;          // some are anisotropic
  bool has_static_friction_ = false;  // some have static friction above the sliding one
};

template <class real>
void Compiler<real>::make_room() {
  std::size_t bodies = 0, shapes = 0;
  for (const Scene& scene : worlds_) {
    bodies += scene.bodies.size();
    for (const BodyDescription& body : scene.bodies) shapes += simulated_shapes(body);
  }
  if (std::max(bodies, shapes) > most_in_batch)
    throw Error(Failure::input, worlds_[0].source,
                fmt::format("a batch can have {} bodies and shapes, has {} and {}; run fewer worlds at once",
                            most_in_batch, bodies, shapes));
  buffers().shape_infos.reserve(shapes);
  buffers().shapes.reserve(shapes);
}

template <class real>
void Compiler<real>::add_world(u32 world) {
  const Scene& scene = worlds_[world];
  const auto count = [](const auto& elements) { return static_cast<u32>(elements.size()); };
  WorldRange range = {};
  range.first_body = count(buffers().body_infos);
  range.first_shape = count(buffers().shape_infos);
  range.first_plane = count(buffers().planes);
  range.first_material_pair = count(buffers().material_pairs);
  range.material_count = std::max(count(scene.materials), 1u);

  for (const BodyDescription& body : scene.bodies) {
    const Origin origin = {scene, &body};
    const u32 index = count(buffers().body_infos);
    add_body(body, world, index - range.first_body, origin);
    for (const ShapeDescription& shape : body.shapes) {
      if (shape.material >= range.material_count) origin.fail("a shape has a material that the scene lacks");
      const u32 id = count(buffers().shape_infos) - range.first_shape;
      if (shape.kind == SHAPE_FACET)
        add_surface(shape, body.continuous, index, id, origin);
      else
        add_shape(shape, body.continuous, index, id, origin);
    }
  }
  add_material_pairs(scene);
  range.body_count = count(buffers().body_infos) - range.first_body;
  range.shape_count = count(buffers().shape_infos) - range.first_shape;
  range.plane_count = count(buffers().planes) - range.first_plane;
  buffers().world_ranges.push_back(range);
  buffers().gravities.push_back(rounded<real>(scene.gravity, "gravity", {scene}));
}

template <class real>
void Compiler<real>::add_body(const BodyDescription& body, u32 world, u32 id, const Origin& origin) {
  const bool dynamic = body.kind == BODY_DYNAMIC;
  const Vector3 inertia = moments(body);
  // about the pivot or the centre of mass: what the equations of motion see
  buffers().body_infos.push_back({world, id, static_cast<u32>(body.kind), !dynamic || is_isotropic(inertia)});

  Mass<real> mass = {};
  if (dynamic) {
    mass.mass = rounded_positive<real>(body.mass, "mass", origin);
    mass.inverse_mass = static_cast<real>(1 / body.mass);
    for (unsigned i = 0; i < 3; ++i) {
      mass.inertia[i] = rounded_positive<real>(inertia[i], "inertia", origin);
      mass.inverse_inertia[i] = static_cast<real>(1 / inertia[i]);
    }
  }
  buffers().masses.push_back(mass);

  const Vector3 arm = exact::rotate(body.orientation, body.com_offset);
  Pivot<real> pivot = {};
  if (body.pivoted) {
    const Vec4<real> point = rounded<real>(exact::subtract(body.position, arm), "pivot", origin);
    const Vec4<real> com_offset = rounded<real>(body.com_offset, "com_offset", origin);
    pivot = {{point.x, point.y, point.z}, 1, {com_offset.x, com_offset.y, com_offset.z}, 0};
  }
  buffers().pivots.push_back(pivot);
  buffers().positions.push_back(rounded<real>(body.position, "position", origin));
  buffers().orientations.push_back(rounded<real>(body.orientation));

  Motion<real> motion = {};
  if (body.kind != BODY_STATIC) {
    // the centre of mass of a pivoted body circles about the pivot
    const Vector3 velocity = body.pivoted ? exact::cross(body.angular_velocity, arm) : body.velocity;
    const Vec4<real> v = rounded<real>(velocity, "velocity", origin);
    const Vec4<real> w = rounded<real>(body.angular_velocity, "angular velocity", origin);
    motion.v[0] = v.x, motion.v[1] = v.y, motion.v[2] = v.z;
    motion.w[0] = w.x, motion.w[1] = w.y, motion.w[2] = w.z;
  }
  if (dynamic) {
    motion.inverse_mass = mass.inverse_mass;
    const std::array<double, 6> inverse = inverse_inertia_world(inertia, body.orientation);
    motion.inertia_xx = static_cast<real>(inverse[0]);
    motion.inertia_yy = static_cast<real>(inverse[1]);
    motion.inertia_zz = static_cast<real>(inverse[2]);
    motion.inertia_xy = static_cast<real>(inverse[3]);
    motion.inertia_xz = static_cast<real>(inverse[4]);
    motion.inertia_yz = static_cast<real>(inverse[5]);
  }
  buffers().motions.push_back(motion);
}

template <class real>
void Compiler<real>::add_shape(const ShapeDescription& shape, bool continuous, u32 body, u32 id, const Origin& origin) {
  if (shape.kind == SHAPE_PLANE) buffers().planes.push_back(static_cast<u32>(buffers().shape_infos.size()));
  const bool central = shape.kind == SHAPE_SPHERE && shape.offset == Vector3{0, 0, 0};
  const u32 flags = (central ? SHAPE_IS_CENTRAL : 0) | (shape.trigger ? SHAPE_IS_TRIGGER : 0) |
                    (continuous ? SHAPE_IS_CONTINUOUS : 0);
  buffers().shape_infos.push_back(
      {body, id, static_cast<u32>(shape.kind), shape.material, shape.category, shape.mask, flags, 0});
  const Vec4<real> offset = rounded<real>(shape.offset, "offset", origin);
  const Vec4<real> rotation = rounded<real>(shape.rotation);
  Shape<real> record = {{offset.x, offset.y, offset.z}, 0, {rotation.x, rotation.y, rotation.z, rotation.w}, {}};
  const u32 needs = info(shape.kind).needs;
  if ((needs & SHAPE_HAS_RADIUS) != 0) record.size[0] = rounded_positive<real>(shape.radius, "radius", origin);
  if ((needs & SHAPE_HAS_LENGTH) != 0)
    record.size[1] = rounded_positive<real>(shape.half_length, "half the length", origin);
  if ((needs & SHAPE_HAS_SIZE) != 0) {
    for (unsigned i = 0; i < 3; ++i)
      record.size[i] = rounded_positive<real>(shape.half_extents[i], "half the size", origin);
  }
  switch (shape.kind) {
    case SHAPE_HULL: {
      const Vector3 half = half_extents_of(shape.points);
      for (unsigned i = 0; i < 3; ++i) record.size[i] = rounded_positive<real>(half[i], "half the size", origin);
      std::string refusal;
      buffers().shape_infos.back().hull = hulls_.find_or_add(shape.points, buffers(), refusal);
      if (!refusal.empty()) origin.fail(refusal);
      break;
    }
    case SHAPE_MESH: {
      const Vector3 half = half_extents_of(shape.mesh->vertices);
      for (unsigned i = 0; i < 3; ++i) record.size[i] = rounded<real>(half[i], "half the size", origin);
      buffers().shape_infos.back().kind = SHAPE_HULL;
      buffers().shape_infos.back().hull = hulls_.find_or_add(shape.mesh, buffers());
      break;
    }
    default: break;
  }
  record.bounding_radius = shape_bounding_radius<real>(shape.kind, record.size);
  record.size[3] = inner_radius(shape.kind, record.size);
  buffers().shapes.push_back(record);
}

// Its facets, each a shape.
template <class real>
void Compiler<real>::add_surface(const ShapeDescription& whole, bool continuous, u32 body, u32 first_id,
                                 const Origin& origin) {
  const u32 first = hulls_.find_or_add(whole.surface, buffers()), flags = continuous ? SHAPE_IS_CONTINUOUS : 0;
  const Vec4<real> rotation = rounded<real>(whole.rotation);
  for (u32 t = 0; t < whole.surface->facets.size(); ++t) {
    buffers().shape_infos.push_back({body, first_id + t, SHAPE_HULL, whole.material, whole.category, whole.mask, flags,
                                     HULL_IS_FACET | (first + t)});
    const Vec4<real> offset = rounded<real>(offset_of_facet(whole, t), "offset", origin);
    const Vector3 half = half_extents_of(corners_of_facet(*whole.surface, t));
    Shape<real> record = {{offset.x, offset.y, offset.z}, 0, {rotation.x, rotation.y, rotation.z, rotation.w}, {}};
    for (unsigned i = 0; i < 3; ++i) record.size[i] = rounded<real>(half[i], "half the size", origin);
    record.bounding_radius = shape_bounding_radius<real>(SHAPE_FACET, record.size);
    record.size[3] = inner_radius(SHAPE_FACET, record.size);
    buffers().shapes.push_back(record);
  }
}

// Friction combines by the geometric mean, restitution by the larger; rules of the scene override both.
template <class real>
void Compiler<real>::add_material_pairs(const Scene& scene) {
  std::vector<Material> materials = scene.materials;
  if (materials.empty()) materials.emplace_back();
  const std::size_t first = buffers().material_pairs.size();
  const Origin origin = {scene};
  for (const PairFriction& pair : friction_pairs_of(scene)) {
    buffers().material_pairs.push_back({rounded<real>(pair.sliding, "friction", origin), 0});
    buffers().angular_friction_pairs.push_back({rounded<real>(pair.torsion_radius, "torsional friction", origin),
                                                rounded<real>(pair.rolling_coefficient, "rolling friction", origin)});
    buffers().static_friction_pairs.push_back({rounded<real>(pair.static_friction, "static friction", origin),
                                               rounded<real>(pair.stick_speed.value_or(0), "stick speed", origin),
                                               pair.stick_speed ? real(0) : real(stick_speed_share)});
    buffers().anisotropy_pairs.push_back({rounded<real>(pair.across, "friction across", origin),
                                          pair.axis_of_b ? 1u : 0u, pair.perpendicular ? 1u : 0u});
    angular_friction_ = angular_friction_ || pair.has_further_friction();
    anisotropic_ = anisotropic_ || pair.is_anisotropic();
    has_static_friction_ = has_static_friction_ || pair.has_static_friction();
  }
  const auto restitution = [&](std::size_t a, std::size_t b) -> real& {
    return buffers().material_pairs[first + a * materials.size() + b].restitution;
  };
  for (std::size_t a = 0; a < materials.size(); ++a) {
    for (std::size_t b = 0; b < materials.size(); ++b)
      restitution(a, b) =
          rounded<real>(std::max(materials[a].restitution, materials[b].restitution), "restitution", origin);
  }
  for (const MaterialPairRule& rule : scene.material_pairs)
    restitution(rule.material_a, rule.material_b) = restitution(rule.material_b, rule.material_a) =
        rounded<real>(rule.restitution, "restitution", origin);
  for (const PairLaw& pair : impact_laws_of(scene)) {
    const real e = rounded<real>(pair.tangential_restitution, "tangential restitution", origin);
    buffers().impact_pairs.push_back({e, static_cast<u32>(pair.law), 0});
    other_laws_ = other_laws_ || pair.law != IMPACT_NEWTON;
  }
}

Features shape_features(const BodyDescription& body) {
  Features features = 0;
  for (const ShapeDescription& shape : body.shapes) {
    if (info(shape.kind).features != 0) features = with(features | info(shape.kind).features, Feature::manifolds);
  }
  for (const ShapeDescription& shape : body.shapes) {
    if (body.continuous) features = with(features, Feature::continuous);
    if (shape.trigger) features = with(with(features, Feature::triggers), Feature::events);
  }
  return features;
}

template <class real>
void Compiler<real>::set_features() {
  const Settings& settings = worlds_[0].settings;
  Features& features = state_.features;
  const bool runge_kutta = settings.integrator == Integrator::runge_kutta;
  features = with(features, runge_kutta ? Feature::runge_kutta : Feature::time_stepping);
  if (has_loads(worlds_)) features = with(features, Feature::loads);
  for (const Scene& scene : worlds_) {
    const bool pushing = is_penalty(scene);  // by particles instead of shapes
    if (pushing) features = with(features, Feature::particles);
    if (pushing && scene.particles->shear_stiffness > 0) features = with(features, Feature::shear_springs);
    const bool touching = !pushing && (scene.settings.keeps_shapes || shapes_can_touch(scene));
    const bool impacts = settings.impact_speed.has_value();
    if (touching && (scene.settings.events || impacts)) features = with(features, Feature::events);
    if (touching && impacts) features = with(features, Feature::impacts);
    if (touching) features = with(features, Feature::contacts);
    if (touching && runge_kutta) {
      throw Error(Failure::input, scene.source + ": /settings/integrator",
                  "runge_kutta is for bodies that cannot touch, and shapes of this scene can; use trapezoidal");
    }
    for (const BodyDescription& body : scene.bodies) {
      if (touching) features |= shape_features(body);
      if (body.kind != BODY_DYNAMIC) continue;
      const bool isotropic = is_isotropic(moments(body));
      const bool off_center = std::any_of(body.shapes.begin(), body.shapes.end(), [](const ShapeDescription& shape) {
        return !shape.trigger && (shape.kind != SHAPE_SPHERE || shape.offset != Vector3{0, 0, 0});
      });
      if (body.pivoted) features = with(features, Feature::pivots);
      if (touching && !body.shapes.empty() && (off_center || !isotropic)) {
        features = with(features, Feature::general_contacts);
      }
      if (!isotropic && settings.gyroscopic != Gyroscopic::none) features = with(features, Feature::gyroscopic);
    }
  }
  if (has(features, Feature::contacts)) {
    compile_shape_trees(state_);
    compile_seams(worlds_, state_);
    features = with(features, broad_phase_of(settings, worlds_.size(), state_.buffers));
  }
  if (has(features, Feature::contacts) && other_laws_) {
    if (settings.friction_model == FrictionModel::patches)
      throw Error(Failure::input, worlds_[0].source + ": /settings/friction_model",
                  "patches know Newton's law of impact alone, and materials of this scene have another; use cones");
    features = with(features, Feature::impact_laws);
  }
  if (has(features, Feature::contacts) && (angular_friction_ || has_static_friction_)) {
    if (settings.friction_model == FrictionModel::patches)
      throw Error(
          Failure::input, worlds_[0].source + ": /settings/friction_model",
          "patches have a twist of their own and one friction, and materials of this scene have static, torsional or "
          "rolling or anisotropic friction; use cones");
    if (angular_friction_) features = with(features, Feature::angular_friction);
    if (has_static_friction_) features = with(features, Feature::static_friction);
    if (anisotropic_ && other_laws_)
      throw Error(Failure::input, worlds_[0].source + ": /materials",
                  "laws of impact know one mu in all directions, and materials of this scene have friction_across too");
    if (anisotropic_) features = with(features, Feature::elliptic_friction);
  }
  if (has(features, Feature::contacts) && settings.friction_model == FrictionModel::patches)
    features = with(with(features, Feature::patches), Feature::general_contacts);
  if (has(features, Feature::contacts) && settings.solver == Solver::jacobi) features = with(features, Feature::jacobi);
  if (has(features, Feature::contacts) && settings.solver == Solver::cell_gauss_seidel)
    features = with(features, Feature::partitions);
  const bool jointed = std::ranges::any_of(worlds_, [](const Scene& scene) { return !scene.joints.empty(); });
  const bool constrained = has(features, Feature::contacts) || jointed;
  if (constrained && wants_step_forces(worlds_[0])) features = with(features, Feature::summed_impulses);
  if (constrained && is_gradient(settings.solver)) {
    if (has(features, Feature::patches))
      throw Error(Failure::input, worlds_[0].source + ": /settings/friction_model",
                  "solvers along a gradient have a cone for each contact; leave patches out, or take gauss_seidel");
    if (has(features, Feature::angular_friction))
      throw Error(Failure::input, worlds_[0].source + ": /settings/solver",
                  "solvers along a gradient know round cones of slip alone, and materials of this "
                  "scene have torsional, rolling or anisotropic friction; take gauss_seidel");
    features = with(features, Feature::gradient);
    if (has(features, Feature::contacts)) features = with(features, Feature::jacobi);
  }
  if (has(features, Feature::contacts) && settings.solver == Solver::dense_gauss_seidel) {
    if (has(features, Feature::patches))
      throw Error(Failure::input, worlds_[0].source + ": /settings/friction_model",
                  "dense_gauss_seidel has a cone for each contact; leave patches out, or take gauss_seidel");
    if (has(features, Feature::angular_friction))
      throw Error(Failure::input, worlds_[0].source + ": /settings/solver",
                  "dense_gauss_seidel knows round cones of slip alone, and materials of this "
                  "scene have torsional, rolling or anisotropic friction; take gauss_seidel");
    features = with(with(features, Feature::dense), Feature::general_contacts);
  }
  if (couples_normals(settings, features)) features = with(features, Feature::coupled_normals);
  if (separates_contacts(settings, features)) features = with(features, Feature::separated_contacts);
  if (constrained && tolerance_of(settings) > 0) {
    if (worlds_.size() > 1 && !has(features, Feature::gradient))
      throw Error(Failure::input, worlds_[0].source + ": /settings/tolerance",
                  "ends the sweeps of all worlds at once, so that one would change the bits of another; leave out the "
                  "tolerance or --worlds, or take gradient, whose worlds end each by itself");
    features = with(features, Feature::tolerance);
  }
  if (constrained && settings.solver == Solver::small_steps) {
    if (has(features, Feature::contacts)) features = with(features, Feature::soft_contacts);
    if (settings.integrator != Integrator::semi_implicit_euler) {
      throw Error(Failure::input, worlds_[0].source + ": /settings/solver",
                  "small_steps goes with the integrator semi_implicit_euler only; leave one of the two out");
    }
  }
}

template <class real>
void Compiler<real>::set_sizes() {
  Sizes& sizes = state_.sizes;
  sizes.worlds = static_cast<u32>(worlds_.size());
  sizes.bodies = static_cast<u32>(buffers().body_infos.size());
  if (has(state_.features, Feature::contacts)) {  // shapes that never touch are not simulated
    sizes.shapes = static_cast<u32>(buffers().shapes.size());
    sizes.planes = static_cast<u32>(buffers().planes.size());
    sizes.material_pairs = static_cast<u32>(buffers().material_pairs.size());
    sizes.hulls = static_cast<u32>(buffers().hulls.size());
    sizes.hull_vertices = static_cast<u32>(buffers().hull_vertices.size());
    sizes.hull_faces = static_cast<u32>(buffers().hull_faces.size());
    sizes.hull_edges = static_cast<u32>(buffers().hull_edges.size());
    sizes.hull_corners = static_cast<u32>(buffers().hull_corners.size());
    sizes.facets = static_cast<u32>(buffers().facets.size());
    sizes.facet_edges = static_cast<u32>(buffers().facet_edges.size());
  }
  set_first_capacities(sizes, state_.features);
}

}  // namespace

template <class real>
InitialState<real> compile(std::span<const Scene> worlds) {
  if (worlds.empty()) throw Error(Failure::input, "", "a batch needs at least one world");
  const auto constrained = [](const Scene& scene) { return scene.particles && !is_penalty(scene); };
  if (std::none_of(worlds.begin(), worlds.end(), constrained)) return Compiler<real>(worlds).run();
  std::vector<Scene> spheres;
  for (const Scene& scene : worlds)
    spheres.push_back(constrained(scene) ? with_particles_as_shapes(scene, false) : scene);
  return Compiler<real>(spheres).run();
}

template <class real>
void expect_fits(const BodyDescription& body, const std::string& where) {
  Scene scene;
  scene.source = where;
  Compiler<real>(std::span<const Scene>(&scene, 1)).add_alone(body);
}

template <class real>
Buffers<real> compile_shapes(const Scene& scene, Shown shown) {
  if (!scene.particles || shown == Shown::shapes) return Compiler<real>(std::span<const Scene>(&scene, 1)).shapes();
  const Scene spheres = with_particles_as_shapes(scene, shown == Shown::both);
  return Compiler<real>(std::span<const Scene>(&spheres, 1)).shapes();
}

template void expect_fits<float>(const BodyDescription&, const std::string&);
template void expect_fits<double>(const BodyDescription&, const std::string&);
template Buffers<float> compile_shapes<float>(const Scene&, Shown);
template Buffers<double> compile_shapes<double>(const Scene&, Shown);
template InitialState<float> compile<float>(std::span<const Scene>);
template InitialState<double> compile<double>(std::span<const Scene>);

}  // namespace lockstep
