#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "host/error.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/stop_request.hpp"

namespace lockstep {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds longest_reading{10};
constexpr std::size_t memory_of_reading = std::size_t{2} << 30;

// What a file names beside it is not there.
class NoFiles final : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

TriangleMesh triangles_of(const aiScene& scene) {
  TriangleMesh whole;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    const u32 first = static_cast<u32>(whole.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      whole.vertices.push_back({static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];  // points and lines bound nothing
      if (face.mNumIndices == 3)
        whole.triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }
  return whole;
}

TriangleMesh import(const std::string& bytes, const std::string& ending) {
  Assimp::Importer importer;
  importer.SetIOHandler(new NoFiles);                                            // which it owns
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // numbers as the file gives them
  const unsigned steps = aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices | aiProcess_Triangulate;
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), steps, ending.c_str());
  if (scene == nullptr) throw std::runtime_error(importer.GetErrorString());
  return triangles_of(*scene);
}

void write_all(int to, const void* data, std::size_t size) {
  for (const char* at = static_cast<const char*>(data); size > 0;) {
    const ssize_t written = ::write(to, at, size);
    if (written <= 0) _exit(1);
    at += written;
    size -= static_cast<std::size_t>(written);
  }
}

template <class Items>
void write_items(int to, const Items& items) {
  const std::uint64_t count = items.size();
  write_all(to, &count, sizeof(count));
  write_all(to, items.data(), count * sizeof(items[0]));
}

// Bytes of memory that the process has mapped; its limit is on those.
std::size_t mapped_memory() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// In the child: a reason, empty where there is none, then vertices and triangles.
[[noreturn]] void read_and_end(int to, const std::string& bytes, const std::string& ending) {
  const auto limit = [](auto resource, std::size_t most) {
    const rlimit both = {most, most};
    setrlimit(resource, &both);
  };
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, std::size_t(longest_reading.count()) + 1);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, mapped_memory() + memory_of_reading);
#endif
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);
  ::close(STDERR_FILENO);  // of what assertions say
  std::string reason;
  TriangleMesh mesh;
  try {
    mesh = import(bytes, ending);
  } catch (const std::bad_alloc&) {
    reason = "takes more than 2 GiB of memory to read";
  } catch (const std::exception& error) {
    reason = error.what();
    if (reason.empty()) reason = "cannot be read";
  }
  write_items(to, reason);
  write_items(to, mesh.vertices);
  write_items(to, mesh.triangles);
  _exit(0);
}

// What the child writes, to its end; it is given so long.
std::string read_to_end(int from, pid_t child, bool& too_long) {
  std::string bytes(1 << 16, '\0');
  std::size_t size = 0;
  const Clock::time_point last = Clock::now() + longest_reading;
  for (;;) {
    pollfd ready = {from, POLLIN, 0};
    too_long = Clock::now() > last;
    if (too_long || stop_asked()) kill(child, SIGKILL);
    if (poll(&ready, 1, 50) == 0) continue;
    if (bytes.size() - size < (1 << 16)) bytes.resize(2 * bytes.size());
    const ssize_t count = ::read(from, bytes.data() + size, bytes.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    size += static_cast<std::size_t>(count);
  }
  bytes.resize(size);
  return bytes;
}

template <class Items>
bool take_items(std::string_view& bytes, Items& items) {
  std::uint64_t count = 0;
  if (bytes.size() < sizeof(count)) return false;
  std::memcpy(&count, bytes.data(), sizeof(count));
  bytes.remove_prefix(sizeof(count));
  if (count > bytes.size() / sizeof(items[0])) return false;
  items.resize(count);
  std::memcpy(items.data(), bytes.data(), count * sizeof(items[0]));
  bytes.remove_prefix(count * sizeof(items[0]));
  return true;
}

}  // namespace

TriangleMesh read_by_assimp(const std::string& bytes, const std::string& ending) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("there is no pipe to be had for a process that reads it");
  const pid_t parent = getpid(), child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // what nobody waits for ends
    if (getppid() != parent) _exit(1);
    ::close(ends[0]);
    read_and_end(ends[1], bytes, ending);
  }
  ::close(ends[1]);
  bool too_long = false;
  const std::string found = child < 0 ? "" : read_to_end(ends[0], child, too_long);
  ::close(ends[0]);
  if (child < 0) throw std::runtime_error("there is no process to be had that reads it");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (stop_asked()) throw Stopped();
  const std::string cure = "; give the mesh as OBJ, STL, PLY or glTF";
  if (too_long) throw std::runtime_error(fmt::format("takes more than {} s to read{}", longest_reading.count(), cure));
  if (WIFSIGNALED(status))
    throw std::runtime_error(fmt::format("its reader (assimp) was ended by signal {}{}", WTERMSIG(status), cure));
  std::string reason;
  TriangleMesh mesh;
  std::string_view left = found;
  if (!take_items(left, reason) || !take_items(left, mesh.vertices) || !take_items(left, mesh.triangles))
    throw std::runtime_error("its reader (assimp) ended early" + cure);
  if (!reason.empty()) throw std::runtime_error(reason);
  return mesh;
}

}  // namespace lockstep
