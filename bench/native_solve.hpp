// The local solve of 16 central contacts, written for one machine, with the compiler's vector extension: what the
// OpenCL kernel on a CPU device is held against. The same arithmetic in the same order (kernels/solve_contact.h), so
// that the bits can be compared as well.
#pragma once

#include <cmath>

#include "kernels/types.h"

namespace lockstep::bench {

using Lane = float __attribute__((vector_size(4 * PACK)));
using HalfLine = float __attribute__((vector_size(32)));

struct Lane3 {
  Lane x, y, z;
};

inline Lane3 add(const Lane3& a, const Lane3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Lane3 subtract(const Lane3& a, const Lane3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Lane3 scale(const Lane& s, const Lane3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Lane dot(const Lane3& a, const Lane3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lane3 cross(const Lane3& a, const Lane3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Lane square_root(Lane a) {
  for (u32 k = 0; k < PACK; ++k) a[k] = std::sqrt(a[k]);
  return a;
}

// The first halves of sixteen body lines: v, inverse mass, w, inverse inertia.
struct Bodies {
  Lane rows[8];
};

// First the elements of even, then those of odd place.
inline Bodies unzip(const Bodies& in) {
  Bodies out;
  for (u32 k = 0; k < 4; ++k) {
    const Lane &a = in.rows[2 * k], &b = in.rows[2 * k + 1];
    out.rows[k] = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    out.rows[k + 4] = __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
  }
  return out;
}

inline const HalfLine& half_line(const Motion<float>& motion) { return reinterpret_cast<const HalfLine&>(motion); }

inline Bodies gather(const Motion<float>* motions, const u32* indices) {
  Bodies in;
  for (u32 k = 0; k < 8; ++k) {
    const HalfLine a = half_line(motions[indices[2 * k]]), b = half_line(motions[indices[2 * k + 1]]);
    in.rows[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  }
  return unzip(unzip(unzip(in)));
}

inline void scatter(const Bodies& bodies, Motion<float>* motions, const u32* indices) {
  const Bodies out = unzip(unzip(unzip(unzip(bodies))));
  for (u32 k = 0; k < 8; ++k) {
    const Lane& r = out.rows[k];
    if (r[3] > 0)
      reinterpret_cast<HalfLine&>(motions[indices[2 * k]]) = __builtin_shufflevector(r, r, 0, 1, 2, 3, 4, 5, 6, 7);
    if (r[11] > 0)
      reinterpret_cast<HalfLine&>(motions[indices[2 * k + 1]]) =
          __builtin_shufflevector(r, r, 8, 9, 10, 11, 12, 13, 14, 15);
  }
}

inline void push(Bodies& body, const Lane3& impulse, const Lane3& arm) {
  Lane* c = body.rows;
  const Lane3 v = scale(c[3], impulse), w = scale(c[7], cross(arm, impulse));
  c[0] += v.x, c[1] += v.y, c[2] += v.z;
  c[4] += w.x, c[5] += w.y, c[6] += w.z;
}
inline void pull(Bodies& body, const Lane3& impulse, const Lane3& arm) {
  Lane* c = body.rows;
  const Lane3 v = scale(c[3], impulse), w = scale(c[7], cross(arm, impulse));
  c[0] -= v.x, c[1] -= v.y, c[2] -= v.z;
  c[4] -= w.x, c[5] -= w.y, c[6] -= w.z;
}

inline void solve_contacts(const BlockBodies& bodies, const ContactBlock<float>& block, ImpulseBlock<float>& impulses,
                           Motion<float>* motions) {
  const auto load = [](const float* p) { return *reinterpret_cast<const Lane*>(p); };
  const auto store = [](float* p, const Lane& x) { *reinterpret_cast<Lane*>(p) = x; };
  const Lane zero = {};
  const Lane3 n = {load(block.normal_x), load(block.normal_y), load(block.normal_z)};
  const Lane3 arm_a = {load(block.arm_a_x), load(block.arm_a_y), load(block.arm_a_z)};
  const Lane3 arm_b = {load(block.arm_b_x), load(block.arm_b_y), load(block.arm_b_z)};
  const Lane sign = n.z < 0.0f ? zero - 1.0f : zero + 1.0f;
  const Lane k = -1.0f / (sign + n.z);
  const Lane xy = n.x * n.y * k;
  const Lane3 t1 = {1.0f + sign * n.x * n.x * k, sign * xy, -sign * n.x};
  const Lane3 t2 = {xy, sign + n.y * n.y * k, -n.y};

  Bodies a = gather(motions, bodies.body_a), b = gather(motions, bodies.body_b);
  const Lane old_n = load(impulses.normal), old_1 = load(impulses.tangent_1), old_2 = load(impulses.tangent_2);
  const Lane w_nn = load(block.w_nn), w_11 = load(block.w_11), friction = load(block.friction);
  const auto at = [](const Bodies& body, u32 first) {
    return Lane3{body.rows[first], body.rows[first + 1], body.rows[first + 2]};
  };
  const Lane3 u = subtract(add(at(a, 0), cross(at(a, 4), arm_a)), add(at(b, 0), cross(at(b, 4), arm_b)));
  const Lane q_n = dot(n, u) + load(block.bias) - w_nn * old_n;
  const Lane q_1 = dot(t1, u) - w_11 * old_1, q_2 = dot(t2, u) - w_11 * old_2;

  const Lane r_n = -q_n / w_nn, s_1 = -q_1 / w_11, s_2 = -q_2 / w_11;
  const Lane length = square_root(s_1 * s_1 + s_2 * s_2), limit = friction * r_n;
  const Lane factor = length > limit ? limit / length : zero + 1.0f;
  const Lane new_n = q_n < 0.0f ? r_n : zero;
  const Lane new_1 = q_n < 0.0f ? factor * s_1 : zero, new_2 = q_n < 0.0f ? factor * s_2 : zero;
  store(impulses.normal, new_n);
  store(impulses.tangent_1, new_1);
  store(impulses.tangent_2, new_2);

  const Lane3 impulse = add(add(scale(new_n - old_n, n), scale(new_1 - old_1, t1)), scale(new_2 - old_2, t2));
  push(a, impulse, arm_a);
  pull(b, impulse, arm_b);
  scatter(a, motions, bodies.body_a);
  scatter(b, motions, bodies.body_b);
}

}  // namespace lockstep::bench
