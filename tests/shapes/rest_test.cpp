// Bodies at rest on each other: their contacts keep names and points, carry the weight and move nothing, whatever the
// shapes; and what rolls along a line keeps its speed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "host/backends/reference_backend.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::test::rest_test {
namespace {

constexpr double g = 9.81;

std::string vector_of(std::initializer_list<double> v) { return fmt::format("[{}]", fmt::join(v, ", ")); }

std::string around(double axis_x, double axis_y, double axis_z, double angle) {
  return fmt::format(R"({{"axis": {}, "angle": {}}})", vector_of({axis_x, axis_y, axis_z}), angle);
}

std::string prism(u32 corners, double radius, double height) {
  std::string points;
  for (u32 i = 0; i < 2 * corners; ++i) {
    const double angle = 6.283185307179586 * double(i / 2) / corners;
    points += (i ? ", " : "") +
              vector_of({radius * std::cos(angle), radius * std::sin(angle), (i % 2 ? 0.5 : -0.5) * height});
  }
  return fmt::format(R"({{"type": "hull", "points": [{}]}})", points);
}

std::string block(double x, double y, double z) {
  return fmt::format(R"({{"type": "box", "size": {}}})", vector_of({x, y, z}));
}

std::string hull_block(double x, double y, double z) {
  std::string points;
  for (u32 i = 0; i < 8; ++i)
    points +=
        (i ? ", " : "") + vector_of({(i & 1 ? 0.5 : -0.5) * x, (i & 2 ? 0.5 : -0.5) * y, (i & 4 ? 0.5 : -0.5) * z});
  return fmt::format(R"({{"type": "hull", "points": [{}]}})", points);
}

std::string round_shape(const char* type, double radius, double length) {
  return fmt::format(R"({{"type": "{}", "radius": {}, "length": {}}})", type, radius, length);
}

std::string still(const std::string& shape, std::initializer_list<double> position, const std::string& orientation) {
  return fmt::format(R"({{"type": "static", "position": {}, "orientation": {}, "shapes": [{}]}})", vector_of(position),
                     orientation, shape);
}

// One body, of 2 kg, that comes last.
std::string moving(const std::string& shape, std::initializer_list<double> position, const std::string& orientation,
                   const std::string& more = "") {
  return fmt::format(R"({{"mass": 2, "position": {}, "orientation": {}, "shapes": [{}]{}}})", vector_of(position),
                     orientation, shape, more);
}

const std::string upright = "[0, 0, 0, 1]";

struct Name {
  u32 a, b, feature;
  bool operator==(const Name&) const = default;
};

/// A contact as a step made it.
struct AnchorPair {
  Name name;
  double on_a[3], on_b[3];  // in the bodies
};

template <class real>
class Bench {
 public:
  Bench(const std::string& bodies, const std::string& solver, const std::string& more = "") {
    const Scene scene =
        parse_scene(fmt::format(R"({{"description": "at rest", "settings": {{"solver": "{}"{}}}, "bodies": [{}]}})",
                                solver, more, bodies),
                    "rest_test");
    InitialState<real> state = compile<real>(scene);
    body_ = u32(scene.bodies.size()) - 1;
    const StepParams<real> params = state.params;
    sub_step_ = double(params.dt);
    auto backend = std::make_unique<ReferenceBackend<real>>(std::move(state));
    buffers_ = &backend->buffers();
    simulation_ = std::make_unique<Simulation<real>>(std::move(backend), params);
  }

  void step(u32 count) {
    for (u32 i = 0; i < count; ++i) simulation_->step();
  }
  std::vector<AnchorPair> anchor_pairs() const {
    std::vector<AnchorPair> all;
    for (u32 i = 0; i < buffers_->counters[COUNTER_CONTACTS]; ++i) {
      const Contact& c = buffers_->contacts[i];
      const ContactPoint<real>& p = buffers_->contact_points[i];
      all.push_back({{c.shape_a, c.shape_b, c.feature},
                     {double(p.anchor_a[0]), double(p.anchor_a[1]), double(p.anchor_a[2])},
                     {double(p.anchor_b[0]), double(p.anchor_b[1]), double(p.anchor_b[2])}});
    }
    return all;
  }
  /// Of all contacts in the last sub-step, N s.
  double normal_impulse() const {
    double sum = 0;
    for (u32 i = 0; i < buffers_->cached_count[0]; ++i) sum += double(buffers_->cached_impulses[i].normal);
    return sum;
  }
  double sub_step() const { return sub_step_; }
  const Vec4<real>& position() const { return buffers_->positions[body_]; }
  const Motion<real>& motion() const { return buffers_->motions[body_]; }
  double speed() const {
    double most = 0;
    for (int k = 0; k < 3; ++k)
      most = std::max({most, std::abs(double(motion().v[k])), std::abs(double(motion().w[k]))});
    return most;
  }

 private:
  std::unique_ptr<Simulation<real>> simulation_;
  Buffers<real>* buffers_;
  u32 body_;
  double sub_step_;
};

double distance(const double* p, const double* q) { return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]); }

/// Names stay what they are and anchors where they are, within `near`; nothing moves.
template <class real>
void expect_contacts_to_stay(Bench<real>& bench, u32 steps, double near, double most_speed) {
  std::vector<AnchorPair> before = bench.anchor_pairs();
  ASSERT_FALSE(before.empty());
  for (u32 i = 0; i < steps; ++i) {
    bench.step(1);
    const std::vector<AnchorPair> after = bench.anchor_pairs();
    ASSERT_EQ(after.size(), before.size()) << "step " << i;
    for (std::size_t k = 0; k < after.size(); ++k) {
      ASSERT_EQ(after[k].name, before[k].name) << "step " << i << ", contact " << k;
      // of a point on a face the other side's anchor alone has a place: one of the two is at rest
      ASSERT_LT(std::min(distance(after[k].on_a, before[k].on_a), distance(after[k].on_b, before[k].on_b)), near)
          << "step " << i << ", contact " << k;
    }
    ASSERT_LT(bench.speed(), most_speed) << "step " << i;
    before = after;
  }
}

struct Ground {
  const char* name;
  std::string body;
};

std::vector<Ground> grounds() {
  std::string heights;
  for (u32 i = 0; i < 9; ++i) heights += (i ? ", " : "") + std::string("[0, 0, 0, 0, 0, 0, 0, 0, 0]");
  return {{"plane", still(R"({"type": "plane"})", {0, 0, 0}, upright)},
          {"box", still(block(3, 3, 1), {0, 0, -0.5}, around(0, 0, 1, 0.7))},
          {"hull", still(prism(7, 2, 1), {0, 0, -0.5}, around(0, 0, 1, 0.3))},
          {"cylinder", still(round_shape("cylinder", 2, 1), {0, 0, -0.5}, around(0, 0, 1, 2))},
          {"triangles", still(fmt::format(R"({{"type": "height_field", "spacing": 0.5, "heights": [{}]}})", heights),
                              {0.03, 0.04, 0}, upright)}};
}

template <class real>
void expect_flats_to_stay(const std::string& solver) {
  for (const auto& [name, ground] : grounds()) {
    for (const double yaw : {0.0, 0.4, 1.1, 2.9}) {
      for (const auto& [kind, shape] : {std::pair{"cylinder", round_shape("cylinder", 0.2, 0.5)},
                                        {"pentagon", prism(5, 0.2, 0.5)},
                                        {"octagon", prism(8, 0.2, 0.5)}}) {
        SCOPED_TRACE(fmt::format("{} on {}, turned by {}, {}", kind, name, yaw, solver));
        Bench<real> bench(ground + ", " + moving(shape, {0.01, 0.02, 0.251}, around(0, 0, 1, yaw)), solver);
        bench.step(240);
        expect_contacts_to_stay(bench, 60, 1e-4, sizeof(real) == 4 ? 2e-5 : 2e-6);
        EXPECT_NEAR(double(bench.position().z), 0.25, 3e-4);
        EXPECT_NEAR(bench.normal_impulse(), 2 * g * bench.sub_step(), 2e-3 * 2 * g * bench.sub_step());
      }
    }
  }
}

TEST(Flats, KeepTheirFourPointsAtRest) {
  for (const char* solver : {"gauss_seidel", "small_steps"}) {
    expect_flats_to_stay<float>(solver);
    expect_flats_to_stay<double>(solver);
  }
}

// Two of the same lie aligned: corners are at corners, and rims at rims.
template <class real>
void expect_aligned_ones_to_stay(const std::string& solver) {
  for (const auto& [kind, shape] : {std::pair{"cylinder", round_shape("cylinder", 0.2, 0.5)},
                                    {"octagon", prism(8, 0.2, 0.5)},
                                    {"block", hull_block(0.3, 0.4, 0.5)}}) {
    SCOPED_TRACE(fmt::format("{} on its like, {}", kind, solver));
    Bench<real> bench(still(shape, {0, 0, -0.25}, upright) + ", " + moving(shape, {0, 0, 0.251}, upright), solver);
    bench.step(240);
    expect_contacts_to_stay(bench, 60, 1e-4, sizeof(real) == 4 ? 2e-5 : 2e-6);
    EXPECT_NEAR(bench.normal_impulse(), 2 * g * bench.sub_step(), 2e-3 * 2 * g * bench.sub_step());
  }
}

TEST(Flats, KeepTheirFourPointsOnTheirLike) {
  for (const char* solver : {"gauss_seidel", "small_steps"}) {
    expect_aligned_ones_to_stay<float>(solver);
    expect_aligned_ones_to_stay<double>(solver);
  }
}

// A bar lies between two edges, along both: a line of contact each, as long as it is. Either edge holds it by
// m g / (2 cos t) with sin t = gap / (2 radius).
template <class real>
void expect_bar_to_lie_in_a_gap(const std::string& solver) {
  const double radius = 0.05, gap = 0.06, sine = gap / (2 * radius), cosine = std::sqrt(1 - sine * sine);
  for (const bool hulls : {false, true}) {
    for (const char* type : {"capsule", "cylinder"}) {
      SCOPED_TRACE(fmt::format("{} between {}, {}", type, hulls ? "hulls" : "boxes", solver));
      const std::string wall = hulls ? hull_block(0.4, 3, 0.2) : block(0.4, 3, 0.2);
      Bench<real> bench(still(wall, {-0.2 - gap / 2, 0, -0.1}, upright) + ", " +
                            still(wall, {0.2 + gap / 2, 0, -0.1}, upright) + ", " +
                            moving(round_shape(type, radius, 1), {0, 0, radius * cosine + 0.0005},
                                   around(1, 0, 0, 1.5707963267948966)),
                        solver);
      bench.step(240);
      expect_contacts_to_stay(bench, 60, 1e-3, 1e-3);
      const std::vector<AnchorPair> anchors = bench.anchor_pairs();
      ASSERT_EQ(anchors.size(), 4u);
      for (u32 k = 0; k < 4; k += 2) EXPECT_NEAR(distance(anchors[k].on_a, anchors[k + 1].on_a), 1, 1e-3);
      EXPECT_NEAR(double(bench.position().z), radius * cosine, 5e-4);
      // friction may take a share of it, and each edge the other's
      EXPECT_LE(bench.normal_impulse(), 1.02 * 2 * g / cosine * bench.sub_step());
      EXPECT_GE(bench.normal_impulse(), 0.98 * 2 * g * cosine * bench.sub_step());
    }
  }
}

TEST(Lines, AreFoundAlongEdges) {
  for (const char* solver : {"gauss_seidel", "small_steps"}) {
    expect_bar_to_lie_in_a_gap<float>(solver);
    expect_bar_to_lie_in_a_gap<double>(solver);
  }
}

// What rolls over a level line, without a slip, goes on at v. In sub-steps a contact that stays behind pushes: it made
// the speed seven times as much in five seconds.
TEST(Lines, AreRolledOverAtASteadySpeed) {
  const double half = std::sqrt(0.5);
  const std::string along_y = around(1, 0, 0, 1.5707963267948966), along_x = around(0, 1, 0, 1.5707963267948966);
  const std::string on_edge = around(0, 1, 0, 0.7853981633974483);
  const double v = 0.1, r = 0.1;
  for (const auto& [name, line, top] :
       {std::tuple{"capsule", still(round_shape("capsule", 0.1, 6), {0, 0, 0}, along_y), 0.1},
        {"cylinder", still(round_shape("cylinder", 0.1, 6), {0, 0, 0}, along_y), 0.1},
        {"box", still(block(0.2, 6, 0.2), {0, 0, 0}, on_edge), 0.2 * half},
        {"hull", still(hull_block(0.2, 6, 0.2), {0, 0, 0}, on_edge), 0.2 * half}}) {
    for (const char* solver : {"gauss_seidel", "small_steps"}) {
      for (const char* type : {"capsule", "cylinder"}) {
        SCOPED_TRACE(fmt::format("{} over {}, {}", type, name, solver));
        Bench<double> bench(line + ", " +
                                moving(round_shape(type, r, 1), {0, 0, top + r}, along_x,
                                       R"(, "velocity": [0, 0.1, 0], "angular_velocity": [-1, 0, 0])"),
                            solver, R"(, "dt": 0.016666666666666666)");
        bench.step(300);
        EXPECT_NEAR(double(bench.motion().v[1]), v, 0.04 * v);
        EXPECT_NEAR(double(bench.motion().w[0]), -v / r, 0.04 * v / r);
        EXPECT_NEAR(double(bench.position().y), 5 * v, 0.03 * 5 * v);
        EXPECT_NEAR(double(bench.position().z), top + r, 5e-4);
      }
    }
  }
  for (const char* solver : {"gauss_seidel", "small_steps"}) {
    SCOPED_TRACE(fmt::format("sphere along capsule, {}", solver));
    Bench<double> bench(still(round_shape("capsule", 0.1, 6), {0, 0, 0}, along_y) + ", " +
                            moving(R"({"type": "sphere", "radius": 0.1})", {0, 0, 0.2}, upright,
                                   R"(, "velocity": [0, 0.1, 0], "angular_velocity": [-1, 0, 0])"),
                        solver, R"(, "dt": 0.016666666666666666)");
    bench.step(300);
    EXPECT_NEAR(double(bench.motion().v[1]), v, 0.01 * v);
  }
}

// What rolls along a beam narrower than itself, or along one edge of a table, touches it where an edge crosses its own
// line: a point that goes with the body. One that stayed on the edge was ahead of the body and threw it up.
template <class real>
void expect_to_roll_along_edges() {
  const std::string along_y = around(1, 0, 0, 1.5707963267948966);
  for (const auto& [radius, v] : {std::pair{0.05, 9.6}, {0.3, 3.0}, {0.15, 0.7}}) {
    for (const bool beam : {true, false}) {
      const double width = beam ? 2 * radius : 8 * radius, beside = beam ? 0 : 3.2 * radius;
      for (const auto& [name, ground] : {std::pair{"box", block(40, width, 1)}, {"hull", hull_block(40, width, 1)}}) {
        for (const char* type : {"capsule", "cylinder"}) {
          for (const char* solver : {"small_steps", "gauss_seidel"}) {
            SCOPED_TRACE(fmt::format("{} of {} m at {} m/s, {}, {}, {}", type, radius, v, name, width, solver));
            const std::string rolls =
                fmt::format(R"(, "velocity": [{}, 0, 0], "angular_velocity": [0, {}, 0])", v, v / radius);
            Bench<real> bench(
                still(ground, {10, 0, -0.5}, upright) + ", " +
                    moving(round_shape(type, radius, 4 * radius), {0, beside, 1.004 * radius}, along_y, rolls),
                solver, R"(, "dt": 0.016666666666666666)");
            bench.step(60);
            EXPECT_NEAR(double(bench.motion().v[0]), v, 2e-3 * v);
            EXPECT_NEAR(double(bench.motion().w[1]), v / radius, 2e-3 * v / radius);
            EXPECT_NEAR(double(bench.position().z), radius, 2e-3 * radius);
          }
        }
      }
    }
  }
}
TEST(Lines, EdgesThatCrossThemAreRolledAlong) {
  expect_to_roll_along_edges<float>();
  expect_to_roll_along_edges<double>();
}

// What is ten millimetres large lies on a ground of 200 m and more as high as on one of its own size.
template <class real>
void expect_small_ones_to_lie_right(double ground, double from_center, double share) {
  const double s = 0.01;
  const std::string lying = around(1, 0, 0, 1.5707963267948966);
  for (const bool hull : {false, true}) {
    const std::string floor =
        hull ? hull_block(ground, ground, 2 * from_center) : block(ground, ground, 2 * from_center);
    for (const auto& [kind, shape, orientation] :
         {std::tuple{"cylinder", round_shape("cylinder", s / 2, s), around(0, 0, 1, 0.4)},
          {"cylinder lying", round_shape("cylinder", s / 2, s), lying},
          {"capsule lying", round_shape("capsule", s / 2, s), lying},
          {"prism", prism(6, s / 2, s), upright}}) {
      SCOPED_TRACE(
          fmt::format("{} on a {} of {} m, {} m above its centre", kind, hull ? "hull" : "box", ground, from_center));
      Bench<real> bench(
          still(floor, {0, 0, -from_center}, upright) + ", " + moving(shape, {0, 0, s / 2 + 1e-4}, orientation),
          "gauss_seidel", R"(, "dt": 0.004, "margin": 2e-4, "slop": 1e-6)");
      bench.step(400);
      EXPECT_NEAR(double(bench.position().z), s / 2, share * s);
      EXPECT_LT(bench.speed() * s, 1e-3 * s);
    }
  }
}

TEST(SmallShapes, LieAsHighOnALargeGround) {
  expect_small_ones_to_lie_right<double>(200, 100, 1e-3);
  expect_small_ones_to_lie_right<double>(1e4, 5e3, 1e-3);
  expect_small_ones_to_lie_right<float>(200, 50, 1e-3);
  expect_small_ones_to_lie_right<float>(1000, 5, 1e-3);
}

}  // namespace
}  // namespace lockstep::test::rest_test
