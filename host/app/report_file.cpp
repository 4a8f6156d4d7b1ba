#include "host/app/report_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/error.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep::app {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path) {
  throw Error(Failure::input, path, std::string("the report cannot be written: ") + std::strerror(errno));
}

}  // namespace

ReportFile::ReportFile(std::string path) : path_(std::move(path)) {
  if (path_.empty()) return;
  std::error_code none;
  // what a link names is replaced, not the link
  if (const fs::path named = fs::canonical(path_, none); !none) path_ = named.string();
  const fs::file_status status = fs::status(path_, none);
  const bool is_new = status.type() == fs::file_type::not_found;
  errno = 0;
  is_replaced_ = (is_new || status.type() == fs::file_type::regular) && can_be_made(path_);
  if (!(is_new ? is_replaced_ : static_cast<bool>(std::ofstream(path_, std::ios::app)))) refuse(path_);
}

void ReportFile::write(const std::string& text) const {
  if (path_.empty()) return;
  if (is_replaced_) return replace_file(path_, {reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  errno = 0;
  std::ofstream file(path_);
  if (!(file << text << std::flush)) refuse(path_);
}

}  // namespace lockstep::app
