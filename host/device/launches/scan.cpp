#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Up to here one work-group is faster than three launches.
constexpr u32 small_scan = 16 * CHUNK;

u32 chunks_of(u32 count) { return (count + CHUNK - 1) / CHUNK; }

}  // namespace

void Launcher::run_chunks(std::string_view kernel, u32 chunks, std::initializer_list<Argument> arguments) {
  if (plan().lanes > 1)
    run(kernel, chunks, arguments);
  else
    run_groups(kernel, chunks, arguments);
}

void Launcher::scan(std::string_view array, u32 count) { scan(array, count, NONE, count); }

void Launcher::scan(std::string_view array, u32 count, u32 counter, u32 expected) {
  if (expected <= small_scan) {
    run_group("scan_group", {{"values", array}, {"count", count}, {"counter", counter}, {"width", 1u}});
    return;
  }
  const u32 expected_chunks = chunks_of(expected);
  scratch("scan_sums", chunks_of(count));
  run_chunks("scan_sum", expected_chunks, {{"values", array}, {"count", count}, {"counter", counter}});
  run_group("scan_group", {{"values", "scan_sums"}, {"count", count}, {"counter", counter}, {"width", CHUNK}});
  run_chunks("scan_apply", expected_chunks, {{"values", array}, {"count", count}, {"counter", counter}});
}

}  // namespace lockstep
