#include "host/app/report_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

[[noreturn]] void refuse(const std::string& path) {
  throw Error(Failure::input, path, std::string("the report cannot be written: ") + std::strerror(errno));
}

}  // namespace

ReportFile::ReportFile(std::string path) : path_(std::move(path)) {
  if (path_.empty()) return;
  std::error_code ignored;
  made_ = !std::filesystem::exists(path_, ignored);
  errno = 0;
  if (!std::ofstream(path_, std::ios::app)) refuse(path_);
}

ReportFile::~ReportFile() {
  std::error_code ignored;
  if (made_) std::filesystem::remove(path_, ignored);
}

void ReportFile::write(const std::string& text) {
  if (path_.empty()) return;
  errno = 0;
  std::ofstream file(path_);
  if (!(file << text << std::flush)) refuse(path_);
  made_ = false;
}

}  // namespace lockstep::app
