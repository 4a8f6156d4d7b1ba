#include "host/render/instances.hpp"

#include <algorithm>
#include <cstddef>

namespace lockstep {

namespace {

// Radii in pixels from which on a round thing is drawn in the next finer mesh.
constexpr double finer_from[] = {5, 22, 80};

void attribute(const Gl& gl, GLuint index, GLint size, std::size_t stride, std::size_t offset, GLuint divisor) {
  gl.EnableVertexAttribArray(index);
  gl.VertexAttribPointer(index, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                         reinterpret_cast<const void*>(offset));
  gl.VertexAttribDivisor(index, divisor);
}

}  // namespace

Instances::Instances(const Gl& gl) : gl_(gl) {
  batches_.push_back(make_batch(box_mesh()));
  for (u32 level = 0; level < levels; ++level) {
    const u32 segments = 12u << level;
    batches_.push_back(make_batch(sphere_mesh(level + 1)));
    batches_.push_back(make_batch(cylinder_mesh(segments, true)));
    batches_.push_back(make_batch(cylinder_mesh(segments, false)));
    batches_.push_back(make_batch(hemisphere_mesh(segments)));
  }
}

u32 Instances::add_hull(const Mesh& mesh) {
  batches_.push_back(make_batch(mesh));
  return static_cast<u32>(batches_.size() - 1);
}

Instances::Batch Instances::make_batch(const Mesh& mesh) const {
  static_assert(sizeof(Vertex) == 6 * sizeof(float));
  Batch batch;
  GLuint buffers[3] = {};
  gl_.GenVertexArrays(1, &batch.array);
  gl_.BindVertexArray(batch.array);
  gl_.GenBuffers(3, buffers);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Vertex)), mesh.vertices.data(),
                 GL_STATIC_DRAW);
  attribute(gl_, 0, 3, sizeof(Vertex), offsetof(Vertex, position), 0);
  attribute(gl_, 1, 3, sizeof(Vertex), offsetof(Vertex, normal), 0);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(u32)),
                 mesh.indices.data(), GL_STATIC_DRAW);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers[2]);
  for (GLuint i = 0; i < 4; ++i) attribute(gl_, 2 + i, 4, sizeof(Copy), i * 4 * sizeof(float), 1);
  gl_.BindVertexArray(0);
  batch.copies_buffer = buffers[2];
  batch.indices = static_cast<GLsizei>(mesh.indices.size());
  return batch;
}

std::size_t Instances::batch_of(const Solid& solid, u32 level) const {
  switch (solid.form) {
    case Form::box: return 0;
    case Form::hull: return solid.hull;
    case Form::sphere: return 1 + 4 * level;
    case Form::cylinder: return 2 + 4 * level;
    case Form::tube: return 3 + 4 * level;
    case Form::hemisphere: return 4 + 4 * level;
  }
  return 0;
}

void Instances::set(std::span<const Solid> solids, const Camera& camera, u32 height) {
  for (Batch& batch : batches_) batch.copies.clear();
  const double pixels = 0.5 * height / camera.half_height();
  for (const Solid& s : solids) {
    // of a long one its thickness counts
    const double radius = double(s.form == Form::sphere ? s.scale.maxCoeff() : s.scale.x());
    const double distance = (s.position.cast<double>() - camera.position).norm();
    const double size = radius * pixels / std::max(distance, 1e-9);
    const u32 level = static_cast<u32>(
        std::count_if(std::begin(finer_from), std::end(finer_from), [&](double from) { return size >= from; }));
    batches_[batch_of(s, level)].copies.push_back(
        {{s.position.x(), s.position.y(), s.position.z(), static_cast<float>(s.pattern)},
         {s.rotation.x(), s.rotation.y(), s.rotation.z(), s.rotation.w()},
         {s.scale.x(), s.scale.y(), s.scale.z(), 0},
         {s.color[0], s.color[1], s.color[2], s.alpha}});
  }
  for (const Batch& batch : batches_) {
    if (batch.copies.empty()) continue;
    gl_.BindBuffer(GL_ARRAY_BUFFER, batch.copies_buffer);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(batch.copies.size() * sizeof(Copy)), batch.copies.data(),
                   GL_STREAM_DRAW);
  }
}

void Instances::draw() const {
  for (const Batch& batch : batches_) {
    if (batch.copies.empty()) continue;
    gl_.BindVertexArray(batch.array);
    gl_.DrawElementsInstanced(GL_TRIANGLES, batch.indices, GL_UNSIGNED_INT, nullptr,
                              static_cast<GLsizei>(batch.copies.size()));
  }
  gl_.BindVertexArray(0);
}

}  // namespace lockstep
