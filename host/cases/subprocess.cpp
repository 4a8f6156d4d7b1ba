#include "host/cases/subprocess.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/error.hpp"
#include "host/stop_request.hpp"

namespace lockstep {

namespace {

using nlohmann::json;

constexpr int between_looks = 200;  // ms

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

json failed(Failure failure, const char* what) { return {{"failure", static_cast<int>(failure)}, {"what", what}}; }

// {"value": ...} of work that was done, {"failure": ..., "what": ...} of work that was not.
json outcome_of(const std::function<json()>& work) {
  try {
    return {{"value", work()}};
  } catch (const Error& error) {
    return failed(error.failure(), error.what());
  } catch (const std::exception& error) {
    return failed(Failure::device, error.what());
  }
}

[[noreturn]] void work_and_end(const std::function<json()>& work, File file) {
  const std::vector<std::uint8_t> bytes = json::to_cbor(outcome_of(work));  // which keeps each bit of a double
  std::fwrite(bytes.data(), 1, bytes.size(), file.get());
  file.reset();
  std::fflush(nullptr);
  _exit(0);
}

// What the child writes, to its end. A request to end is one to the child too.
std::vector<std::uint8_t> read_to_end(int from, pid_t child) {
  std::vector<std::uint8_t> bytes, chunk(1 << 16);
  for (;;) {
    pollfd ready = {from, POLLIN, 0};
    if (stop_asked()) kill(child, SIGKILL);
    if (poll(&ready, 1, between_looks) <= 0) continue;
    const ssize_t count = read(from, chunk.data(), chunk.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return bytes;
    bytes.insert(bytes.end(), chunk.begin(), chunk.begin() + count);
  }
}

}  // namespace

json run_in_subprocess(const std::function<json()>& work, double* peak_memory) {
  int ends[2];
  if (pipe(ends) != 0) throw Error(Failure::device, "", "there is no pipe to be had for a process");
  std::fflush(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) throw Error(Failure::device, "", "there is no process to be had");
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // what nobody waits for ends
    if (getppid() != parent) _exit(1);
    close(ends[0]);
    work_and_end(work, File(fdopen(ends[1], "wb")));
  }
  close(ends[1]);
  const std::vector<std::uint8_t> bytes = read_to_end(ends[0], child);
  close(ends[0]);
  int status = 0;
  rusage usage = {};
  wait4(child, &status, 0, &usage);
  if (peak_memory) *peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);
  if (stop_asked()) throw Stopped();
  if (WIFSIGNALED(status))
    throw Error(Failure::device, "", "its process was ended by signal " + std::to_string(WTERMSIG(status)));
  const json outcome = json::from_cbor(bytes, true, false);
  if (outcome.is_discarded()) throw Error(Failure::device, "", "its process ended before its work");
  if (outcome.contains("what")) throw Error(Failure(outcome["failure"].get<int>()), "", outcome["what"]);
  return outcome["value"];
}

}  // namespace lockstep
