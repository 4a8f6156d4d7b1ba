#include "host/stages.hpp"

namespace lockstep {

namespace {

using enum Buffer;

#define READS(...) \
  { __VA_ARGS__ }
#define WRITES(...) \
  { __VA_ARGS__ }

// The braces hold a list of buffers; an initializer_list gives each row arrays of its own length.
struct Row {
  std::string_view name;
  Domain domain;
  Feature feature;
  std::vector<Buffer> reads, writes;
};

const std::vector<Row>& rows() {
  static const std::vector<Row> table = {
#define STAGE(name, domain, feature, ...) Row{#name, Domain::domain, Feature::feature, __VA_ARGS__},
#include "host/stages.def"
#undef STAGE
  };
  return table;
}

std::vector<StageInfo> make_infos() {
  std::vector<StageInfo> infos;
  for (const Row& row : rows()) infos.push_back({row.name, row.domain, row.feature, row.reads, row.writes});
  return infos;
}

}  // namespace

const StageInfo& info(Stage stage) {
  static const std::vector<StageInfo> infos = make_infos();
  return infos[static_cast<u32>(stage)];
}

}  // namespace lockstep
