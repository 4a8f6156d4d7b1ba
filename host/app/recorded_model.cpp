#include "host/app/recorded_model.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/read.hpp"

namespace lockstep::app {

namespace {

// The particles of a scene, and the planes that they may lie on, as its shapes.
template <class real>
Buffers<real> particles_as_shapes(Buffers<real> scene) {
  scene.shapes.clear();
  scene.shape_infos.clear();
  const auto add = [&](u32 body, ShapeKind kind) -> Shape<real>& {
    ShapeInfo& info = scene.shape_infos.emplace_back();
    info.body = body;
    info.kind = kind;
    Shape<real>& shape = scene.shapes.emplace_back();
    shape.rotation[3] = 1;
    return shape;
  };
  for (std::size_t i = 0; i < scene.particle_bodies.size(); ++i) {
    const u32 body = scene.particle_bodies[i];
    Shape<real>& sphere = add(body, SHAPE_SPHERE);
    std::copy_n(&scene.particle_offsets[i].x, 3, sphere.offset);
    sphere.size[0] = scene.particle_laws[scene.body_infos[body].world].radius;
  }
  for (std::size_t k = 0; k < scene.particle_planes.size(); ++k) {
    const ParticlePlane<real>& plane = scene.particle_planes[k];
    Shape<real>& shape = add(scene.plane_bodies[k], SHAPE_PLANE);
    std::copy_n(plane.point, 3, shape.offset);
    const Quaternion q =
        exact::rotation_from_z_to({double(plane.normal[0]), double(plane.normal[1]), double(plane.normal[2])});
    std::copy_n(q.begin(), 4, shape.rotation);
  }
  return scene;
}

}  // namespace

template <class real>
SceneModel recorded_model(const InitialState<real>& start, const RecordingLabel& label, Shown shown) {
  if (!has(start.features, Feature::contacts)) {
    try {
      const Buffers<real> shapes = compile_shapes<real>(parse_scene(label.scene_text, label.source), shown);
      if (shapes.body_infos.size() == start.buffers.body_infos.size()) return SceneModel(shapes);
    } catch (const Error&) {
      // a mesh of the scene may be somewhere else by now, and a world made in code has no text: bodies are drawn by
      // their particles, or by their moments
    }
    if (has(start.features, Feature::particles)) return SceneModel(particles_as_shapes(start.buffers));
  }
  return SceneModel(start.buffers);
}

template SceneModel recorded_model(const InitialState<float>&, const RecordingLabel&, Shown);
template SceneModel recorded_model(const InitialState<double>&, const RecordingLabel&, Shown);

}  // namespace lockstep::app
