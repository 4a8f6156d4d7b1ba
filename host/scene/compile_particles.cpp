#include "host/scene/compile_particles.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/particle_law.hpp"
#include "host/scene/sample_particles.hpp"

namespace lockstep {

namespace {

[[noreturn]] void refuse(const Scene& scene, const char* location, const std::string& what) {
  throw Error(Failure::input, scene.source + ": " + location, what);
}

// What shapes can do and particles cannot.
void expect_plain(const Scene& scene) {
  if (scene.settings.events)
    refuse(scene, "/settings/events", "are of shapes that touch; the particle model penalty has none, leave them out");
  if (scene.settings.integrator != Integrator::semi_implicit_euler)
    refuse(scene, "/settings/integrator", "of the particle model penalty must be semi_implicit_euler");
  for (const BodyDescription& body : scene.bodies) {
    const Origin origin = {scene, &body};
    if (body.continuous)
      origin.fail("is continuous, which the particle model penalty knows nothing of; leave it out, or use constraints");
    for (const ShapeDescription& shape : body.shapes) {
      if (shape.trigger) origin.fail("has a trigger, and the particle model penalty has none; use constraints");
      if (shape.category != 1 || shape.mask != 0xffffffffu)
        origin.fail("has a collision filter, and the particle model penalty has none; use constraints");
    }
  }
}

void expect_stable(const Scene& scene, const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles,
                   double damping) {
  const double longest = longest_stable_step(body, particles, *scene.particles, damping);
  const double step = scene.settings.dt / substeps_of(scene.settings);
  if (step <= longest) return;
  const Origin origin = {scene, &body};
  const double enough = 0.999 * longest;  // also when said in four digits
  origin.fail(fmt::format(
      "its particles of the stiffness {} N/m need sub-steps of at most {:.4g} s, dt / substeps is {:.4g} s; set dt to "
      "{:.4g} or substeps to {:.0f}",
      std::max(scene.particles->stiffness, scene.particles->shear_stiffness), longest, step,
      enough * substeps_of(scene.settings), std::ceil(scene.settings.dt / enough)));
}

const std::vector<std::vector<Vector3>>& particles_of(ParticleSampler& sampler, const Origin& origin) {
  std::string refusal;
  const auto& particles = sampler.of(*origin.body, refusal);
  if (!refusal.empty()) origin.fail(refusal);
  return particles;
}

template <class real>
void add_plane(const ShapeDescription& shape, u32 body, const Origin& origin, Buffers<real>& buffers) {
  const Vec4<real> point = rounded<real>(shape.offset, "offset", origin);
  const Vec4<real> normal = rounded<real>(exact::rotate(shape.rotation, {0, 0, 1}), "normal", origin);
  buffers.particle_planes.push_back({{point.x, point.y, point.z}, 0, {normal.x, normal.y, normal.z}, 0});
  buffers.plane_bodies.push_back(body);
}

}  // namespace

template <class real>
void compile_particles(std::span<const Scene> worlds, InitialState<real>& state) {
  Buffers<real>& buffers = state.buffers;
  u32 index = 0;
  for (const Scene& scene : worlds) {
    if (!is_penalty(scene))
      refuse(scene, "/particles", "must be of the model penalty in all worlds of a batch or in none");
    expect_plain(scene);
    buffers.particle_laws.push_back(particle_law<real>(*scene.particles, {scene}));
    const double damping = damping_ratio(scene.particles->restitution);
    ParticleSampler sampler(*scene.particles);
    for (const BodyDescription& body : scene.bodies) {
      const Origin origin = {scene, &body};
      const auto& particles = particles_of(sampler, origin);
      expect_stable(scene, body, particles, damping);
      const double flat = most_side_by_side(body, particles, scene.particles->radius);
      buffers.particle_shares.push_back(static_cast<real>(body.kind == BODY_DYNAMIC ? flat / body.mass : 0));
      buffers.body_particles.push_back(static_cast<u32>(buffers.particle_bodies.size()));
      for (const auto& points : particles) {
        for (const Vector3& p : points) {
          buffers.particle_bodies.push_back(index);
          buffers.particle_offsets.push_back(rounded<real>(p, "a particle", origin));
        }
      }
      for (const ShapeDescription& shape : body.shapes)
        if (shape.kind == SHAPE_PLANE) add_plane(shape, index, origin, buffers);
      if (buffers.particle_bodies.size() > most_particles)
        origin.fail(fmt::format("brings the particles to more than {}; make them larger", most_particles));
      ++index;
    }
  }
  buffers.body_particles.push_back(static_cast<u32>(buffers.particle_bodies.size()));
  state.sizes.particles = static_cast<u32>(buffers.particle_bodies.size());
  state.sizes.particle_planes = static_cast<u32>(buffers.particle_planes.size());
  set_first_capacities(state.sizes, state.features);
}

Scene with_particles_as_shapes(const Scene& scene, bool keep) {
  Scene result = scene;
  ParticleSampler sampler(*scene.particles);
  for (BodyDescription& body : result.bodies) {
    const auto& particles = particles_of(sampler, {result, &body});
    std::vector<ShapeDescription> shapes;
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      ShapeDescription sphere = body.shapes[i];  // its material and its filter
      if (keep || sphere.kind == SHAPE_PLANE) shapes.push_back(sphere);
      if (keep && sphere.kind != SHAPE_PLANE) shapes.back().trigger = true;
      sphere.kind = SHAPE_SPHERE;
      sphere.rotation = {0, 0, 0, 1};
      sphere.radius = scene.particles->radius;
      sphere.points.clear();
      sphere.mesh = nullptr;
      for (const Vector3& p : particles[i]) {
        sphere.offset = p;
        shapes.push_back(sphere);
      }
    }
    body.shapes = std::move(shapes);
  }
  return result;
}

std::vector<u32> particle_shape_counts(const Scene& scene) {
  std::vector<u32> counts;
  ParticleSampler sampler(*scene.particles);
  for (const BodyDescription& body : scene.bodies) {
    const auto& particles = particles_of(sampler, {scene, &body});
    for (std::size_t i = 0; i < body.shapes.size(); ++i)
      counts.push_back(static_cast<u32>(particles[i].size()) + (body.shapes[i].kind == SHAPE_PLANE ? 1 : 0));
  }
  return counts;
}

template void compile_particles<float>(std::span<const Scene>, InitialState<float>&);
template void compile_particles<double>(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
