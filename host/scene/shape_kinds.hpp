// The table of kinds of shapes (kernels/shape_kinds.def) for the host.
#pragma once

#include <utility>

#include "host/features.hpp"
#include "kernels/types.h"

namespace lockstep {

/// Keys of a scene file that not all kinds have.
enum ShapeKey : u32 {
  SHAPE_HAS_RADIUS = 1,
  SHAPE_HAS_LENGTH = 2,
  SHAPE_HAS_SIZE = 4,
  SHAPE_HAS_POINTS = 8,
  SHAPE_HAS_MESH = 16,
  SHAPE_HAS_SCALE = 32,
  SHAPE_HAS_HEIGHTS = 64,
  SHAPE_HAS_SPACING = 128,
  SHAPE_HAS_NORMAL = 256,
  SHAPE_HAS_ROTATION = 512
};
inline constexpr std::pair<const char*, ShapeKey> shape_keys[] = {
    {"radius", SHAPE_HAS_RADIUS},    {"length", SHAPE_HAS_LENGTH},   {"size", SHAPE_HAS_SIZE},
    {"points", SHAPE_HAS_POINTS},    {"mesh", SHAPE_HAS_MESH},       {"scale", SHAPE_HAS_SCALE},
    {"heights", SHAPE_HAS_HEIGHTS},  {"spacing", SHAPE_HAS_SPACING}, {"normal", SHAPE_HAS_NORMAL},
    {"rotation", SHAPE_HAS_ROTATION}};

/// A row of the table.
struct ShapeKindInfo {
  const char* name;
  u32 needs, may;  // ShapeKey, or-ed
  Features features;
  const char* meaning;
};
inline constexpr ShapeKindInfo shape_kind_infos[] = {
#define SHAPE_KIND(name, NAME, needs, may, features, meaning) {#name, needs, may, features, meaning},
#define SCENE_SHAPE_KIND(name, NAME, needs, may, features, meaning) {#name, needs, may, features, meaning},
#include "kernels/shape_kinds.def"
};
constexpr const ShapeKindInfo& info(ShapeKind kind) { return shape_kind_infos[kind]; }

inline constexpr std::pair<const char*, ShapeKind> shape_names[] = {
#define SHAPE_KIND(name, NAME, needs, may, features, meaning) {#name, SHAPE_##NAME},
#define SCENE_SHAPE_KIND(name, NAME, needs, may, features, meaning) {#name, SHAPE_##NAME},
#include "kernels/shape_kinds.def"
};

}  // namespace lockstep
