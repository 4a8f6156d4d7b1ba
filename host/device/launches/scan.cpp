#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Up to here one work-group is faster than three launches.
constexpr u32 small_scan = 16 * CHUNK;

}  // namespace

void Launcher::scan(std::string_view array, u32 count) { scan(array, count, NONE, count); }

void Launcher::scan(std::string_view array, u32 count, u32 counter, u32 expected) {
  if (expected <= small_scan) {
    run_group("scan_group", {{"values", array}, {"count", count}, {"counter", counter}, {"width", 1u}});
    return;
  }
  const u32 chunks = (count + CHUNK - 1) / CHUNK;
  scratch("scan_sums", chunks);
  run("scan_sum", chunks, {{"values", array}, {"count", count}, {"counter", counter}});
  run_group("scan_group", {{"values", "scan_sums"}, {"count", count}, {"counter", counter}, {"width", CHUNK}});
  run("scan_apply", chunks, {{"values", array}, {"count", count}, {"counter", counter}});
}

}  // namespace lockstep
