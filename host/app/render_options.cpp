#include "host/app/render_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>

#include "host/app/command_files.hpp"
#include "host/error.hpp"
#include "host/record/recording_writer.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep::app {

namespace {

namespace fs = std::filesystem;

constexpr u32 widest = 3840, highest = 2160, smallest = 64;

void read_size(const std::string& text, FrameOptions& frames) {
  const char* const end = text.data() + text.size();
  u32 width = 0, height = 0;
  const auto first = std::from_chars(text.data(), end, width);
  const bool by = first.ec == std::errc() && first.ptr != end && *first.ptr == 'x';
  const auto second = by ? std::from_chars(first.ptr + 1, end, height) : first;
  const bool good = by && second.ec == std::errc() && second.ptr == end && width >= smallest && height >= smallest &&
                    width <= widest && height <= highest;
  if (!good)
    throw Error(
        Failure::input, "--size",
        fmt::format("must be WIDTHxHEIGHT, from {0}x{0} to {1}x{2}, is '{3}'", smallest, widest, highest, text));
  frames.width = width;
  frames.height = height;
}

void read_color_by(const std::string& text, FrameOptions& frames) {
  std::vector<std::string> known;
  for (const auto& [name, by] : color_by_names) {
    if (text == name) {
      frames.color_by = by;
      return;
    }
    known.push_back(name);
  }
  throw Error(Failure::input, "--color-by", fmt::format("must be one of {}, is '{}'", fmt::join(known, ", "), text));
}

void read_show(const std::vector<std::string>& words, FrameOptions& frames) {
  bool shapes = false, particles = false;
  for (const std::string& word : words) {
    if (word == "contacts")
      frames.contacts = true;
    else if (word == "forces")
      frames.forces = true;
    else if (word == "joints")
      frames.joints = true;
    else if (word == "particles")
      particles = true;
    else if (word == "shapes")
      shapes = true;
    else
      throw Error(
          Failure::input, "--show",
          fmt::format("must be some of contacts, forces, joints, particles, shapes, separated by commas, is '{}'",
                      word));
  }
  if (particles) frames.shown = shapes ? Shown::both : Shown::particles;
}

void read_camera(RenderOptions& options) {
  if (options.from.empty() && options.to.empty()) {
    if (options.fov) throw Error(Failure::input, "--fov", "goes with --from and --to");
    return;
  }
  if (options.from.size() != 3 || options.to.size() != 3)
    throw Error(Failure::input, "--from --to", "go together, each three numbers, as in --from 6,-10,5 --to 0,0,1");
  Camera camera;
  camera.position = Eigen::Vector3d(options.from[0], options.from[1], options.from[2]);
  camera.target = Eigen::Vector3d(options.to[0], options.to[1], options.to[2]);
  if (!(camera.target - camera.position).allFinite() || camera.target == camera.position)
    throw Error(Failure::input, "--to", "must be another place than --from");
  camera.fov_deg = options.fov.value_or(camera.fov_deg);
  options.camera = camera;
}

}  // namespace

void add_render_options(CLI::App& command, RenderOptions& options) {
  add_scene_options(command, options);
  command.get_option("scene")->description("Built-in scene (lockstep scenes), JSON file, robot, or recording");
  const std::string group = "Pictures";
  options.frames.folder = "out";
  std::vector<CLI::Option*> added = {
      command.add_option("--out", options.frames.folder, "Folder for PNG pictures")->capture_default_str(),
      add_file_option(command, "--video", options.frames.film, "Write an MP4 film instead of pictures (needs ffmpeg)"),
      command.add_option("--size", options.size, "Size in pixels, WIDTHxHEIGHT, up to 3840x2160")
          ->capture_default_str(),
      command
          .add_option("--color-by", options.color_by,
                      "Colour bodies by body, speed, contacts, color, penetration or residual")
          ->capture_default_str(),
      command.add_option("--scale", options.frames.scale, "Value of the brightest colour")->check(positive),
      command
          .add_option("--show", options.show,
                      "Draw marks: contacts, forces, joints; or particle bodies as particles, shapes or both")
          ->delimiter(','),
      command.add_option("--from", options.from, "Camera position x,y,z in m, instead of the scene's")->delimiter(','),
      command.add_option("--to", options.to, "Point that the camera looks at, x,y,z in m")->delimiter(','),
      command.add_option("--fov", options.fov, "Vertical angle of view, degrees")
          ->check(finite)
          ->check(CLI::Range(1.0, 150.0)),
      command.add_flag("--plain", options.frames.plain, "Draw no legend and no caption")};
  for (CLI::Option* option : added) option->group(group);
  add_shown_options(command, options.shown);
  command.add_flag("--quiet", options.quiet, "Print no progress bar and no summary");
}

void finish_render_options(const CLI::App& command, RenderOptions& options) {
  FrameOptions& frames = options.frames;
  read_size(options.size, frames);
  read_color_by(options.color_by, frames);
  read_show(options.show, frames);
  read_camera(options);
  if (frames.scale && frames.color_by == ColorBy::body)
    throw Error(Failure::input, "--scale", "goes with a --color-by that has numbers");
  if (frames.film.empty()) return;
  if (command.count("--out") > 0) throw Error(Failure::input, "--out", "is for pictures; --video names its own file");
  if (frames.width % 2 != 0 || frames.height % 2 != 0)
    throw Error(Failure::input, "--size", fmt::format("of a film must be even numbers, is '{}'", options.size));
  expect_separate({{"--video", frames.film}}, {{"the scene", options.scene}, {"--resume", options.resume}});
  expect_writable(frames.film, "the film", "ftyp", 4);
  expect_ffmpeg();
}

bool is_recording(const std::string& path) {
  std::string start(recording_signature.size(), '\0');
  std::ifstream(path, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == recording_signature || fs::path(path).extension() == ".h5";
}

void expect_nothing_simulated(const CLI::App& command, const std::string& recording, const std::set<std::string>& own) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() > 0 && own.count(option->get_single_name()) == 0)
      throw Error(Failure::input, recording,
                  option->get_name() + " is for what is simulated; a recording is only drawn");
  }
}

void expect_recording_suffices(const CLI::App& command, const RenderOptions& options) {
  expect_nothing_simulated(command, options.scene,
                           {"scene", "out", "video", "size", "color-by", "scale", "show", "from", "to", "fov", "plain",
                            "at", "frames", "every", "fps", "quiet", "help"});
  const std::string cure = ", a recording has poses and velocities only; render its scene instead";
  if (needs_contacts(options.frames.color_by))
    throw Error(Failure::input, options.scene, "--color-by " + options.color_by + " needs contacts" + cure);
  if (options.frames.contacts || options.frames.forces)
    throw Error(Failure::input, options.scene, "--show contacts, forces needs contacts" + cure);
}

void expect_pictures_writable(const RenderOptions& options, const std::string& scene, u32 first_step) {
  const FrameOptions& frames = options.frames;
  if (!frames.film.empty()) return;
  std::error_code error;
  fs::create_directory(frames.folder, error);
  if (!fs::is_directory(frames.folder, error))
    throw Error(Failure::input, frames.folder,
                "is no folder, and none can be made there; --out names one for pictures");
  expect_writable(Frames::file_of(frames.folder, scene, first_step), "the picture", png_signature);
}

}  // namespace lockstep::app
