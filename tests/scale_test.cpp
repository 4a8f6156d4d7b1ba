// A scene whose lengths and masses are all multiplied by powers of two moves in the same way to the last bit: where a
// scene gives no length or speed, what is used follows its shapes, and no constant hides in the code.
#include <gtest/gtest.h>

#include <cfenv>
#include <optional>
#include <vector>

#include "host/backends/reference_backend.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "host/step.hpp"

namespace lockstep::scale_test {
namespace {

struct Scale {
  double length, mass;

  void operator()(double& x) const { x *= length; }
  void operator()(Vector3& x) const {
    for (double& component : x) component *= length;
  }
  template <class T>
  void operator()(std::optional<T>& x) const {
    if (x) (*this)(*x);
  }
  template <class T>
  void operator()(std::vector<T>& all) const {
    for (T& x : all) (*this)(x);
  }

  void operator()(FurtherFriction& further) const {
    (*this)(further.stick_speed);
    (*this)(further.torsional_friction);
    (*this)(further.rolling_friction);
  }
  void operator()(Material& material) const { (*this)(material.further); }
  void operator()(MaterialPairRule& rule) const { (*this)(rule.further); }

  void operator()(ShapeDescription& shape) const {
    (*this)(shape.offset);
    (*this)(shape.radius);
    (*this)(shape.half_length);
    (*this)(shape.half_extents);
    (*this)(shape.points);
  }

  void operator()(BodyDescription& body) const {
    body.mass *= mass;
    for (double& moment : body.inertia) moment *= mass * length * length;
    (*this)(body.position);
    (*this)(body.velocity);
    (*this)(body.com_offset);
    (*this)(body.shapes);
  }

  void operator()(JointDescription& joint) const {
    (*this)(joint.anchor_a);
    (*this)(joint.anchor_b);
    (*this)(joint.pitch);
    (*this)(joint.radius);
    if (joint.reference_poses) {
      (*this)(joint.reference_poses->position_a);
      (*this)(joint.reference_poses->position_b);
    }
  }

  void operator()(Scene& scene) const {
    Settings& s = scene.settings;
    for (std::optional<double>* given : {&s.slop, &s.margin, &s.correction_limit, &s.cell_size, &s.tolerance})
      (*this)(*given);
    (*this)(s.restitution_threshold);
    (*this)(s.speed_limit);
    if (s.sleeping) (*this)(s.sleeping->speed);
    (*this)(scene.gravity);
    (*this)(scene.materials);
    (*this)(scene.material_pairs);
    (*this)(scene.bodies);
    (*this)(scene.joints);
  }
};

// Surfaces and meshes are shared between shapes, particles have stiffnesses, and what drives or holds a joint is a
// force or a torque: their scenes are left to others.
bool is_of_lengths_and_masses(const Scene& scene) {
  if (scene.particles) return false;
  for (const BodyDescription& body : scene.bodies)
    for (const ShapeDescription& shape : body.shapes)
      if (shape.surface || shape.mesh) return false;
  for (const JointDescription& joint : scene.joints) {
    if (joint.motor_force != 0 || joint.friction != 0 || joint.spring || joint.limited) return false;
  }
  return true;
}

// Whether nothing underflowed, which is not rounded as other numbers are.
template <class real>
bool expect_same_motion(const Scene& scene, const Scale& scale, u32 steps) {
  Scene scaled = scene;
  scale(scaled);
  const InitialState<real> one = compile<real>(scene), other = compile<real>(scaled);
  ReferenceBackend<real> a(one), b(other);
  std::feclearexcept(FE_UNDERFLOW);
  for (u32 i = 0; i < steps; ++i) {
    step(a, one.params);
    step(b, other.params);
  }
  if (std::fetestexcept(FE_UNDERFLOW) != 0) return false;
  u32 different = 0;
  for (u32 i = 0; i < one.sizes.bodies; ++i) {
    const Vec4<real> x = a.buffers().positions[i], y = b.buffers().positions[i];
    const Vec4<real> q = a.buffers().orientations[i], p = b.buffers().orientations[i];
    const real* v = a.buffers().motions[i].v;
    const real* u = b.buffers().motions[i].v;
    const real l = real(scale.length);
    different += l * x.x != y.x || l * x.y != y.y || l * x.z != y.z || q.x != p.x || q.y != p.y || q.z != p.z ||
                 q.w != p.w || l * v[0] != u[0] || l * v[1] != u[1] || l * v[2] != u[2];
  }
  EXPECT_EQ(different, 0u) << scene.name << " of " << one.sizes.bodies << " bodies, after " << steps << " steps";
  return true;
}

TEST(Scale, ChangesNoMotionOfBuiltInScenes) {
  u32 scenes = 0;
  for (const SceneListing& listing : built_in_scenes()) {
    const Scene scene = read_scene(listing.name);
    if (!is_of_lengths_and_masses(scene) || scene.bodies.size() > 2000 || is_oracle(scene.settings.solver)) continue;
    scenes += expect_same_motion<float>(scene, {0x1p4, 0x1p8}, 12);
    scenes += expect_same_motion<double>(scene, {0x1p-7, 0x1p-10}, 12);
  }
  EXPECT_GT(scenes, 100u);
}

}  // namespace
}  // namespace lockstep::scale_test
