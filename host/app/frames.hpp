// The pictures of a run: kept until it is known what they show together, then drawn and written.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/body_values.hpp"
#include "host/render/legend.hpp"
#include "host/render/marks.hpp"
#include "host/render/scene_model.hpp"
#include "host/render/video.hpp"
#include "host/scene/compile.hpp"

namespace lockstep::app {

struct FrameOptions {
  u32 width = 1280, height = 720;
  std::string folder, film;  // where pictures go; a film instead of them
  double film_rate = 30;
  ColorBy color_by = ColorBy::body;
  bool contacts = false, forces = false, joints = false;  // marks
  Shown shown = Shown::shapes;                            // of bodies that are particles
  std::optional<Camera> camera;                           // none: framed automatically
  std::optional<double> scale;                            // the number of the brightest colour
  bool plain = false;                                     // without legend and caption
};

/// A state to be shown.
struct ShownState {
  u32 step = 0;
  std::vector<RenderPose> poses;
  std::vector<float> values;  // of each body; empty where bodies have colours of their own
  std::vector<ContactMark> contacts;
  std::vector<JointMark> joints;
};

class Frames {
 public:
  /// `dt`: of a step, s. Throws Error (device) where nothing can draw here.
  Frames(const FrameOptions& options, SceneModel model, std::string scene, double dt);

  /// Keeps snapshots until there are half a gigabyte of them: what they show decides camera and scale of all that
  /// follow.
  void add(ShownState shown_state);
  /// Draws and writes what is left.
  void finish();

  u32 count() const { return count_; }
  const std::string& driver() const { return renderer_.driver(); }
  double draw_ms() const { return draw_ms_; }    // of all pictures
  double write_ms() const { return write_ms_; }  // encoding included
  /// The file of a picture.
  static std::string file_of(const std::string& folder, const std::string& scene, u32 step);

 private:
  void decide();
  void draw_kept();
  void write(const ShownState& shown_state);
  Drawing drawing_of(const ShownState& shown_state) const;
  void add_marks(const ShownState& shown_state, Drawing& drawing) const;
  Legend legend() const;
  void save(const ShownState& shown_state, const Picture& picture);

  FrameOptions options_;
  SceneModel model_;
  std::string scene_;
  double dt_;
  Renderer renderer_;
  std::unique_ptr<VideoWriter> video_;
  std::vector<ShownState> kept_;
  std::size_t kept_bytes_ = 0;
  bool decided_ = false;
  // what all pictures share
  Camera camera_;
  Region region_;
  Legend::Scale scale_;
  bool nothing_touches_ = false;  // somewhere a body has no number
  double newtons_a_metre_ = 1;    // of the lines that show forces
  u32 count_ = 0;
  double draw_ms_ = 0, write_ms_ = 0;
};

}  // namespace lockstep::app
