#include "host/scene/regular_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <stdexcept>

namespace lockstep {

std::string read_regular_file(const std::string& path, std::size_t most) {
  // a pipe would be waited for, were it opened otherwise
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) throw std::runtime_error("cannot be opened for reading; check its permissions");
  const std::unique_ptr<const int, void (*)(const int*)> closed(&file, [](const int* of) { close(*of); });
  struct stat status;
  if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) throw std::runtime_error("is no regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > most) throw std::runtime_error("is larger than " + std::to_string(most >> 20) + " MiB");
  std::string bytes(size, '\0');
  for (std::size_t at = 0; at < size;) {
    const ssize_t count = read(file, bytes.data() + at, size - at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw std::runtime_error("cannot be read to its end");
    at += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace lockstep
