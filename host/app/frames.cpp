#include "host/app/frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/record/whole_file.hpp"

namespace lockstep::app {

namespace {

using Eigen::Vector3f;

constexpr std::size_t most_kept = std::size_t{512} << 20;  // bytes
constexpr Color untouched = {0.87f, 0.88f, 0.89f};
constexpr Color contact_color = {0.98f, 0.80f, 0.10f}, force_color = {0.85f, 0.11f, 0.20f};
constexpr Color anchor_color = {0.10f, 0.62f, 0.55f}, arm_color = {0.25f, 0.30f, 0.36f};

std::size_t bytes_of(const ShownState& s) {
  return s.poses.size() * sizeof(RenderPose) + s.values.size() * sizeof(float) +
         s.contacts.size() * sizeof(ContactMark) + s.joints.size() * sizeof(JointMark);
}

// What all but one in a hundred are below.
double usual_most(std::vector<float>& numbers) {
  if (numbers.empty()) return 0;
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(numbers.size() - 1));
  std::nth_element(numbers.begin(), at, numbers.end());
  return double(*at);
}

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Frames::Frames(const FrameOptions& options, SceneModel model, std::string scene, double dt)
    : options_(options),
      model_(std::move(model)),
      scene_(std::move(scene)),
      dt_(dt),
      renderer_(options.width, options.height) {
  model_.add_meshes_to(renderer_);
  if (!options_.film.empty())
    video_ = std::make_unique<VideoWriter>(options_.film, options_.width, options_.height, options_.film_rate);
}

std::string Frames::file_of(const std::string& folder, const std::string& scene, u32 step) {
  return fmt::format("{}/{}_{:06}.png", folder, scene, step);
}

void Frames::add(ShownState shown_state) {
  if (decided_) return write(shown_state);
  kept_bytes_ += bytes_of(shown_state);
  kept_.push_back(std::move(shown_state));
  if (kept_bytes_ >= most_kept) draw_kept();
}

void Frames::finish() {
  if (!decided_) draw_kept();
  if (video_) video_->close();
}

void Frames::draw_kept() {
  decide();
  for (const ShownState& shown_state : kept_) write(shown_state);
  kept_.clear();
}

void Frames::decide() {
  decided_ = true;
  std::vector<float> numbers;
  float largest = 0, strongest = 0;
  for (const ShownState& shown_state : kept_) {
    region_.extend(region_of(model_.extents(shown_state.poses)));
    for (u32 body = 0; body < shown_state.values.size(); ++body) {
      const float value = shown_state.values[body];
      if (!model_.movable(body)) continue;
      nothing_touches_ = nothing_touches_ || std::isnan(value);
      if (!std::isfinite(value)) continue;
      numbers.push_back(value);
      largest = std::max(largest, value);
    }
    for (const ContactMark& mark : shown_state.contacts) strongest = std::max(strongest, mark.force.norm());
  }
  camera_ =
      options_.camera ? *options_.camera : frame_region(region_, static_cast<double>(options_.width) / options_.height);
  scale_.whole = options_.color_by == ColorBy::contacts || options_.color_by == ColorBy::color;
  scale_.high = scale_.whole ? std::max(1.0f, largest) : round_scale(usual_most(numbers));
  if (options_.scale) scale_.high = *options_.scale;
  scale_.exceeded = double(largest) > scale_.high * (1 + 1e-6);
  const double radius = region_.isEmpty() ? 1 : 0.5 * region_.diagonal().norm();
  newtons_a_metre_ = round_scale(double(strongest) / (0.45 * radius));
}

Drawing Frames::drawing_of(const ShownState& shown_state) const {
  Drawing drawing;
  drawing.camera = camera_;
  drawing.region = region_;
  std::vector<Look> looks(model_.bodies());
  for (u32 body = 0; body < model_.bodies(); ++body) {
    if (!model_.movable(body)) continue;
    if (options_.color_by == ColorBy::body) {
      looks[body].color = body_color(model_.id(body));
    } else {
      const double value = double(shown_state.values[body]);
      looks[body].color = std::isnan(value) ? untouched : scale_color(value / scale_.high);
    }
  }
  model_.draw(shown_state.poses, looks, options_.color_by == ColorBy::body, drawing);
  add_marks(shown_state, drawing);
  return drawing;
}

void Frames::add_marks(const ShownState& shown_state, Drawing& drawing) const {
  const u32 height = options_.height;
  const float unit = static_cast<float>(height) / 720;  // pixels of a picture of the usual size
  if (options_.forces) {
    for (const ContactMark& mark : shown_state.contacts) {
      const Vector3f half = mark.force / static_cast<float>(2 * newtons_a_metre_);
      add_line(drawing, height, mark.point - half, mark.point + half, 2.6f * unit, force_color);
    }
  }
  if (options_.contacts) {
    for (const ContactMark& mark : shown_state.contacts) add_ball(drawing, height, mark.point, 6 * unit, contact_color);
  }
  for (const JointMark& mark : shown_state.joints) {
    add_line(drawing, height, mark.center_a, mark.anchor_a, 1.8f * unit, arm_color);
    add_line(drawing, height, mark.center_b, mark.anchor_b, 1.8f * unit, arm_color);
    add_line(drawing, height, mark.anchor_a, mark.anchor_b, 1.8f * unit, arm_color);
    add_ball(drawing, height, mark.anchor_a, 8 * unit, anchor_color);
    add_ball(drawing, height, mark.anchor_b, 8 * unit, anchor_color);
    const float half_length = 0.06f * static_cast<float>(region_.isEmpty() ? 1 : region_.diagonal().norm());
    if (!mark.axis.isZero())
      add_line(drawing, height, mark.anchor_a - half_length * mark.axis, mark.anchor_a + half_length * mark.axis,
               3.2f * unit, anchor_color);
  }
}

Legend Frames::legend() const {
  Legend legend;
  legend.title = title_of(options_.color_by);
  const bool by_body = options_.color_by == ColorBy::body;
  if (!by_body) legend.scale = scale_;
  if (by_body) {
    const std::span<const Color> palette = body_colors();
    legend.entries.push_back({{palette.begin(), palette.end()}, "each its own"});
  }
  bool any_still = false;
  for (u32 body = 0; body < model_.bodies(); ++body) any_still = any_still || !model_.movable(body);
  if (any_still) legend.entries.push_back({{still_color}, "static or driven"});
  if (!by_body && nothing_touches_) legend.entries.push_back({{untouched}, "touches nothing"});
  if (options_.contacts) legend.entries.push_back({{contact_color}, "contact"});
  if (options_.forces)
    legend.entries.push_back({{force_color}, fmt::format("force, 1 m for {:.4g} N", newtons_a_metre_)});
  if (options_.joints) legend.entries.push_back({{anchor_color}, "joint, and its axis"});
  return legend;
}

void Frames::write(const ShownState& shown_state) {
  const auto start = std::chrono::steady_clock::now();
  Picture picture = renderer_.draw(drawing_of(shown_state));
  if (!options_.plain) {
    draw_legend(picture, legend());
    const std::string time = fmt::format("t = {:.3f} s, step {}", shown_state.step * dt_, shown_state.step);
    draw_caption(picture, {scene_, model_.has_planes() ? time + ", lines 1 m apart" : time});
  }
  draw_ms_ += ms_since(start);
  save(shown_state, picture);
}

void Frames::save(const ShownState& shown_state, const Picture& picture) {
  const auto start = std::chrono::steady_clock::now();
  if (video_)
    video_->add(picture);
  else
    replace_file(file_of(options_.folder, scene_, shown_state.step), encode_png(picture));
  ++count_;
  write_ms_ += ms_since(start);
}

}  // namespace lockstep::app
