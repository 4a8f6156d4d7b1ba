// Questions about the shapes where they are.
#include "host/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "host/error.hpp"

namespace lockstep {

namespace {

template <std::size_t n>
bool finite(const std::array<double, n>& v) {
  return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
}

void expect(bool good, const std::string& kind, std::size_t index, const char* rule) {
  if (!good) throw Error(Failure::input, kind + " " + std::to_string(index), rule);
}

template <class real>
void store(const Vector3& in, real* out) {
  for (unsigned k = 0; k < 3; ++k) out[k] = static_cast<real>(in[k]);
}

template <class real>
Ray<real> compiled(const RayQuery& query) {
  Ray<real> ray = {};
  const double length = exact::length(query.direction);
  store(query.origin, ray.origin);
  for (unsigned k = 0; k < 3; ++k) ray.direction[k] = static_cast<real>(query.direction[k] / length);
  ray.range = static_cast<real>(query.length);
  return ray;
}

template <class real>
Shape<real> compiled(const VolumeQuery& query) {
  Shape<real> volume = {};
  store(query.center, volume.offset);
  for (unsigned k = 0; k < 4; ++k) volume.rotation[k] = static_cast<real>(query.rotation[k]);
  if (query.kind == SHAPE_SPHERE) {
    volume.size[0] = volume.bounding_radius = static_cast<real>(query.radius);
  } else {
    store(query.half_extents, volume.size);
    volume.bounding_radius = static_cast<real>(exact::length(query.half_extents) * 1.000001);
  }
  return volume;
}

void validate(const RayQuery& ray, std::size_t i, u32 worlds) {
  expect(finite(ray.origin) && finite(ray.direction), "ray", i, "must have a finite origin and direction");
  expect(exact::length(ray.direction) > 0, "ray", i, "must not have the direction zero");
  expect(std::isfinite(ray.length) && ray.length >= 0, "ray", i, "must have a finite length >= 0");
  expect(ray.world < worlds, "ray", i, "names a world that there is not");
}

void validate(const VolumeQuery& volume, std::size_t i, u32 worlds) {
  const bool sphere = volume.kind == SHAPE_SPHERE;
  expect(sphere || volume.kind == SHAPE_BOX, "volume", i, "must be a sphere or a box");
  expect(finite(volume.center) && finite(volume.rotation), "volume", i, "must have a finite position");
  const double norm = exact::length(volume.rotation);
  expect(norm > 1 - 1e-6 && norm < 1 + 1e-6, "volume", i, "must be turned by a unit quaternion");
  const Vector3& half = volume.half_extents;
  expect(sphere ? std::isfinite(volume.radius) && volume.radius > 0
                : finite(half) && half[0] > 0 && half[1] > 0 && half[2] > 0,
         "volume", i, "must have a size > 0");
  expect(volume.world < worlds, "volume", i, "names a world that there is not");
}

}  // namespace

// Builds the kernels at the first question; buffers grow, and never shrink.
template <class real>
void Simulation<real>::make_room(Sizes wanted) {
  if (!has(backend_->features(), Feature::contacts))
    throw Error(Failure::input, "query",
                "this scene keeps no shapes: no two can touch, or their particles do in their place");
  const bool first = !has(backend_->features(), Feature::queries);
  if (first) backend_->enable(Feature::queries);
  if (first || wanted != backend_->sizes()) backend_->grow(wanted);
  params_.overlap_capacity = backend_->sizes().overlaps;
  if (!shape_infos_.empty()) return;
  const Buffer names[] = {Buffer::shape_infos, Buffer::body_infos};
  const Buffers<real>& buffers = backend_->download(names);
  shape_infos_ = buffers.shape_infos;
  body_infos_ = buffers.body_infos;
}

template <class real>
std::vector<RayHit> Simulation<real>::cast_rays(std::span<const RayQuery> rays) {
  if (rays.empty()) return {};
  for (std::size_t i = 0; i < rays.size(); ++i) validate(rays[i], i, params_.worlds);
  Sizes sizes = backend_->sizes();
  sizes.rays = std::max(sizes.rays, static_cast<u32>(rays.size()));
  make_room(sizes);

  Buffers<real> question;
  for (const RayQuery& ray : rays) {
    question.rays.push_back(compiled<real>(ray));
    question.ray_filters.push_back({0, ray.world, ray.mask, 0});
  }
  question.rays.resize(sizes.rays);
  question.ray_filters.resize(sizes.rays);
  backend_->upload(Buffer::rays, question);
  backend_->upload(Buffer::ray_filters, question);
  StepParams<real> params = params_;
  params.queries = static_cast<u32>(rays.size());
  backend_->run(Stage::cast_rays, params);

  const Buffer wanted[] = {Buffer::ray_shapes, Buffer::ray_points};
  const Buffers<real>& answer = backend_->download(wanted);
  std::vector<RayHit> hits(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (answer.ray_shapes[i] == NONE) continue;
    const ShapeInfo& shape = shape_infos_[answer.ray_shapes[i]];
    const RayPoint<real>& point = answer.ray_points[i];
    RayHit& hit = hits[i];
    hit = {true, body_infos_[shape.body].id, shape.id, static_cast<double>(point.distance), {}, {}};
    for (unsigned k = 0; k < 3; ++k) {
      hit.point[k] = static_cast<double>(question.rays[i].origin[k]) +
                     hit.distance * static_cast<double>(question.rays[i].direction[k]);
      hit.normal[k] = static_cast<double>(point.normal[k]);
    }
  }
  return hits;
}

template <class real>
std::vector<Overlap> Simulation<real>::find_overlaps(std::span<const VolumeQuery> volumes) {
  if (volumes.empty()) return {};
  for (std::size_t i = 0; i < volumes.size(); ++i) validate(volumes[i], i, params_.worlds);
  Sizes sizes = backend_->sizes();
  sizes.volumes = std::max(sizes.volumes, static_cast<u32>(volumes.size()));
  sizes.overlaps = std::max(sizes.overlaps, 8 * sizes.volumes);
  make_room(sizes);

  Buffers<real> question;
  for (const VolumeQuery& volume : volumes) {
    question.volumes.push_back(compiled<real>(volume));
    question.volume_filters.push_back({static_cast<u32>(volume.kind), volume.world, volume.mask, 0});
  }
  question.volumes.resize(sizes.volumes);
  question.volume_filters.resize(sizes.volumes);
  backend_->upload(Buffer::volumes, question);
  backend_->upload(Buffer::volume_filters, question);
  const Buffer wanted[] = {Buffer::overlap_starts, Buffer::overlaps};
  for (;;) {
    StepParams<real> params = params_;
    params.queries = static_cast<u32>(volumes.size());
    backend_->run(Stage::find_overlaps, params);
    const u32 needed = backend_->download(wanted).overlap_starts[sizes.volumes];
    if (needed <= sizes.overlaps) break;
    sizes.overlaps = needed + needed / 4;
    make_room(sizes);
  }

  const Buffers<real>& answer = backend_->download(wanted);
  std::vector<Overlap> overlaps;
  for (u32 v = 0; v < volumes.size(); ++v) {
    for (u32 k = answer.overlap_starts[v]; k < answer.overlap_starts[v + 1]; ++k) {
      const ShapeInfo& shape = shape_infos_[answer.overlaps[k]];
      overlaps.push_back({v, body_infos_[shape.body].id, shape.id});
    }
  }
  return overlaps;
}

template std::vector<RayHit> Simulation<float>::cast_rays(std::span<const RayQuery>);
template std::vector<RayHit> Simulation<double>::cast_rays(std::span<const RayQuery>);
template std::vector<Overlap> Simulation<float>::find_overlaps(std::span<const VolumeQuery>);
template std::vector<Overlap> Simulation<double>::find_overlaps(std::span<const VolumeQuery>);

}  // namespace lockstep
