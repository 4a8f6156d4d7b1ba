// The file that --report names: refused before the first step where it cannot be written.
#pragma once

#include <string>

namespace lockstep::app {

class ReportFile {
 public:
  /// Throws Error (input) where `path` cannot be written. What is there stays until write(), and where nothing is,
  /// nothing is until then. An empty path: no report.
  explicit ReportFile(std::string path);

  /// There whole or not at all; a device or a pipe gets it as it comes.
  void write(const std::string& text) const;

 private:
  std::string path_;
  bool is_replaced_ = false;  // by a file that is whole
};

}  // namespace lockstep::app
