// What is in one picture.
#pragma once

#include <vector>

#include "host/render/camera.hpp"
#include "host/render/colors.hpp"

namespace lockstep {

enum class Form { sphere, box, cylinder, tube, hemisphere, hull };  // a tube is a cylinder without its ends

/// Shows how a solid is turned.
enum class Pattern { none = 0, edges = 1, fields = 2, wedges = 3 };

struct Solid {
  Form form = Form::sphere;
  u32 hull = 0;  // of Form::hull: what Renderer::add_hull gave
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
  Eigen::Vector3f scale = Eigen::Vector3f::Ones();  // what the mesh of size 1 is stretched by along its axes
  Color color = still_color;
  float alpha = 1;
  Pattern pattern = Pattern::none;
};

/// Through the origin, normal z; everything behind it is solid.
struct PlaneSurface {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();

  Eigen::Vector3f normal() const { return rotation * Eigen::Vector3f::UnitZ(); }
};

struct Drawing {
  Camera camera;
  Region region;                   // what the picture is about: here shadows are sharp
  Eigen::Vector3f up = {0, 0, 1};  // against gravity: planes that face it are floors, the others are walls
  Eigen::Vector3f to_light = {-0.42f, -0.5f, 0.9f};  // need not be unit
  std::vector<Solid> solids;
  std::vector<PlaneSurface> planes;
  std::vector<Solid> marks;  // seen faintly through what is in front of them
};

}  // namespace lockstep
