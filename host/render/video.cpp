#include "host/render/video.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <utility>

#include "host/error.hpp"

namespace lockstep {

namespace {

// For the shell: nothing in it means anything.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

}  // namespace

void expect_ffmpeg() {
  if (std::system("command -v ffmpeg > /dev/null 2>&1") == 0) return;
  throw Error(Failure::device, "--video",
              "there is no ffmpeg here to make a film; install ffmpeg, or leave --video out for PNG pictures");
}

VideoWriter::VideoWriter(const std::string& path, u32 width, u32 height, double pictures_per_second) : path_(path) {
  expect_ffmpeg();
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that gives up is told of as an error of writing
  // in a session of its own: Ctrl-C is the terminal's to all of a group, and the film is to be closed by who writes it
  const std::string command = fmt::format(
      "exec $(command -v setsid) ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} -i - -an -c:v "
      "libx264 -pix_fmt yuv420p "
      "-crf 18 -movflags +faststart -f mp4 {}",
      width, height, pictures_per_second, quoted(path.rfind('-', 0) == 0 ? "./" + path : path));
  pipe_ = popen(command.c_str(), "w");
  if (pipe_ == nullptr) fail();
}

VideoWriter::~VideoWriter() {
  if (pipe_ != nullptr) pclose(pipe_);
}

void VideoWriter::fail() const { throw Error(Failure::device, path_, "ffmpeg could not write the film"); }

void VideoWriter::add(const Picture& picture) {
  if (std::fwrite(picture.bytes.data(), 1, picture.bytes.size(), pipe_) != picture.bytes.size()) fail();
}

void VideoWriter::close() {
  if (pclose(std::exchange(pipe_, nullptr)) != 0) fail();
}

}  // namespace lockstep
