// The file that --report names: refused before the first step where it cannot be written.
#pragma once

#include <string>

namespace lockstep::app {

class ReportFile {
 public:
  /// Throws Error (input) where `path` cannot be written. What is there stays until write(). An empty path: no report.
  explicit ReportFile(std::string path);
  /// Takes away the empty file that the constructor made where nothing was written.
  ~ReportFile();
  ReportFile(const ReportFile&) = delete;
  ReportFile& operator=(const ReportFile&) = delete;

  void write(const std::string& text);

 private:
  std::string path_;
  bool made_ = false;
};

}  // namespace lockstep::app
