#include "host/record/whole_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/error.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

}  // namespace

// mkstemp gives a file to its owner alone; others are made as the user's mask says
int make_beside(const std::string& path, std::string& name) {
  name = path + ".XXXXXX";
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) return descriptor;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  struct stat there;
  const bool replaces = ::stat(path.c_str(), &there) == 0 && S_ISREG(there.st_mode);
  if (::fchmod(descriptor, replaces ? there.st_mode & 0777 : 0666 & ~mask) == 0) return descriptor;
  ::close(descriptor);
  ::unlink(name.c_str());
  return -1;
}

bool can_be_made(const std::string& path) {
  std::string name;
  const int descriptor = make_beside(path, name);
  if (descriptor < 0) return false;
  ::close(descriptor);
  ::unlink(name.c_str());
  return true;
}

NewFile::NewFile(const std::string& path) : path_(path), descriptor_(make_beside(path, name_)) {
  if (descriptor_ < 0) fail();
}

NewFile::~NewFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!name_.empty()) ::unlink(name_.c_str());
}

void NewFile::write(std::span<const unsigned char> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void NewFile::write_at(std::uint64_t offset, std::span<const unsigned char> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
}

void NewFile::publish() {
  if (::fsync(descriptor_) != 0) fail();
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0 || std::rename(name_.c_str(), path_.c_str()) != 0) fail();
  name_.clear();
}

void NewFile::fail() const {
  throw Error(Failure::device, path_, std::string("cannot be written: ") + std::strerror(errno));
}

void expect_writable(const std::string& path, const std::string& what, std::string_view signature, std::size_t offset) {
  if (path.empty()) return;
  const auto refuse = [&](const std::string& why) { throw Error(Failure::input, path, why); };
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const bool is_new = status.type() == fs::file_type::not_found;
  if (!is_new && status.type() != fs::file_type::regular) refuse(what + " cannot be written: it is no file");
  errno = 0;
  if (!(is_new ? can_be_made(path) : static_cast<bool>(std::ofstream(path, std::ios::app))))
    refuse(what + " cannot be written: " + std::strerror(errno));
  if (is_new) return;
  std::string start(signature.size(), '\0');
  std::ifstream(path, std::ios::binary)
      .seekg(static_cast<std::streamoff>(offset))
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  if (fs::file_size(path, error) > 0 && start != signature)
    refuse("is there already and is something else; " + what + " does not overwrite it");
}

void replace_file(const std::string& path, std::span<const unsigned char> bytes) {
  NewFile file(path);
  file.write(bytes);
  file.publish();
}

std::vector<unsigned char> read_whole_file(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw Error(Failure::input, path, "no such file");
  if (status.type() == fs::file_type::directory) throw Error(Failure::input, path, "is a directory, must be a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Failure::input, path, "cannot be opened for reading; check its permissions");
  std::vector<unsigned char> bytes;
  std::vector<char> piece(1u << 20);
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())), file.gcount() > 0)
    bytes.insert(bytes.end(), piece.begin(), piece.begin() + file.gcount());
  if (file.bad()) throw Error(Failure::input, path, "cannot be read to its end");
  return bytes;
}

}  // namespace lockstep
