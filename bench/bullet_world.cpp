#include "bench/bullet_world.hpp"

#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "host/error.hpp"

namespace lockstep::bench {

namespace {

btVector3 vector(const Vector3& v) { return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])}; }
btQuaternion quaternion(const Quaternion& q) {
  return {btScalar(q[0]), btScalar(q[1]), btScalar(q[2]), btScalar(q[3])};
}

std::unique_ptr<btCollisionShape> make_shape(const Scene& scene, const ShapeDescription& shape) {
  if (shape.offset != Vector3{0, 0, 0} && shape.kind != SHAPE_PLANE) {
    throw Error(Failure::input, scene.source, "this scene has shapes off the centre of mass: no Bullet twin");
  }
  if (shape.kind == SHAPE_BOX) return std::make_unique<btBoxShape>(vector(shape.half_extents));
  if (shape.kind == SHAPE_SPHERE) return std::make_unique<btSphereShape>(btScalar(shape.radius));
  if (shape.kind != SHAPE_PLANE)
    throw Error(Failure::input, scene.source, "only spheres, boxes and planes have a Bullet twin");
  const btVector3 normal = quatRotate(quaternion(shape.rotation), btVector3(0, 0, 1));
  return std::make_unique<btStaticPlaneShape>(normal, normal.dot(vector(shape.offset)));
}

}  // namespace

struct BulletWorld::Impl {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<btRigidBody*> first_of_body;  // a scene body with several planes is several Bullet bodies
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  btScalar dt = 0;
};

BulletWorld::BulletWorld(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  Impl& p = *impl_;
  p.world.setGravity(vector(scene.gravity));
  p.dt = btScalar(scene.settings.dt);
  for (const BodyDescription& body : scene.bodies) {
    if (body.kind == BODY_KINEMATIC || body.pivoted || (body.kind == BODY_DYNAMIC && body.shapes.size() != 1)) {
      throw Error(Failure::input, scene.source,
                  "only dynamic bodies of one shape and static bodies have a Bullet twin");
    }
    for (const ShapeDescription& shape : body.shapes) {
      p.shapes.push_back(make_shape(scene, shape));
      btRigidBody::btRigidBodyConstructionInfo info(btScalar(body.mass), nullptr, p.shapes.back().get(),
                                                    vector(body.inertia));
      info.m_startWorldTransform = btTransform(quaternion(body.orientation), vector(body.position));
      // Bullet multiplies the two coefficients: the root makes a pair of equal materials as rough as it should be
      info.m_friction = btScalar(std::sqrt(scene.materials[shape.material].friction));
      info.m_restitution = btScalar(std::sqrt(scene.materials[shape.material].restitution));
      auto rigid = std::make_unique<btRigidBody>(info);
      rigid->setActivationState(DISABLE_DEACTIVATION);
      rigid->setLinearVelocity(vector(body.velocity));
      rigid->setAngularVelocity(vector(body.angular_velocity));
      if (shape.mask == 0)
        p.world.addRigidBody(rigid.get(), 1, 0);
      else
        p.world.addRigidBody(rigid.get());
      if (&shape == &body.shapes.front()) p.first_of_body.push_back(rigid.get());
      p.bodies.push_back(std::move(rigid));
    }
  }
  for (const JointDescription& joint : scene.joints) {
    if (joint.kind != JOINT_BALL || joint.body_b == NONE)
      throw Error(Failure::input, scene.source, "only ball joints have a Bullet twin");
    btRigidBody& b = *p.first_of_body[joint.body_b];
    const btVector3 anchor_b = b.getCenterOfMassTransform().invXform(vector(joint.anchor_b));
    if (joint.body_a == NONE) {
      p.joints.push_back(std::make_unique<btPoint2PointConstraint>(b, anchor_b));
    } else {
      btRigidBody& a = *p.first_of_body[joint.body_a];
      const btVector3 anchor_a = a.getCenterOfMassTransform().invXform(vector(joint.anchor_a));
      p.joints.push_back(std::make_unique<btPoint2PointConstraint>(a, b, anchor_a, anchor_b));
    }
    p.world.addConstraint(p.joints.back().get(), !joint.collide);
  }
}

BulletWorld::~BulletWorld() {
  for (auto& joint : impl_->joints) impl_->world.removeConstraint(joint.get());
  for (auto& body : impl_->bodies) impl_->world.removeRigidBody(body.get());
}

void BulletWorld::step() { impl_->world.stepSimulation(impl_->dt, 0); }

std::vector<BodyPose> BulletWorld::poses() const {
  std::vector<BodyPose> poses;
  for (const btRigidBody* body : impl_->first_of_body) {
    const btVector3& x = body->getCenterOfMassPosition();
    const btQuaternion q = body->getOrientation();
    poses.push_back({{x.x(), x.y(), x.z()}, {q.x(), q.y(), q.z(), q.w()}});
  }
  return poses;
}

}  // namespace lockstep::bench
