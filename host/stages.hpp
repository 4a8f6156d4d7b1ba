// The stage table: what each line of the pipeline loops over, reads and writes, and which scenes need it.
#pragma once

#include <span>
#include <string_view>

#include "host/buffers.hpp"

namespace lockstep {

enum class Stage : u32 {
#define STAGE(name, ...) name,
#include "host/stages.def"
#undef STAGE
  count
};

constexpr u32 stage_count = static_cast<u32>(Stage::count);

struct StageInfo {
  std::string_view name;
  Domain domain;
  Feature feature;
  std::span<const Buffer> reads, writes;
};

const StageInfo& info(Stage stage);

/// Whether a scene with these features runs the stage: it has the stage's, or one of them where they are several.
/// Jacobi's method needs no colours.
inline bool runs(Stage stage, Features features) {
  if (stage == Stage::color_contacts && has(features, Feature::jacobi)) return false;
  return info(stage).feature == Feature::always || (features & static_cast<Features>(info(stage).feature)) != 0;
}

}  // namespace lockstep
