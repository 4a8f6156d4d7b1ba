// A film of pictures, made by ffmpeg where it is installed.
#pragma once

#include <cstdio>
#include <string>

#include "host/render/picture.hpp"

namespace lockstep {

class VideoWriter {
 public:
  /// Starts ffmpeg. Throws Error (device) where it is not installed; `size` is of every picture, in even numbers.
  VideoWriter(const std::string& path, u32 width, u32 height, double pictures_per_second);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  void add(const Picture& picture);

  /// Waits until the file is whole. Throws Error (device) where ffmpeg could not write it.
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  std::FILE* pipe_ = nullptr;
};

/// Throws Error (device), in one line, where there is no ffmpeg to start.
void expect_ffmpeg();

}  // namespace lockstep
