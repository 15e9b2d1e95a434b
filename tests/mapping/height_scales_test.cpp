#include "mapping/height_scales.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "mapping/planar_motion.hpp"
#include "tests/mapping/depth_drive.hpp"

namespace ceilmap::mapping {
namespace {

constexpr double kBorder = 1.5;  // metres: the ceiling is the reference plane before, ...
constexpr float kNearer = 1.3F;  // ... and has this inverse height ratio behind it
constexpr int kKeyframes = 11;
constexpr double kStep = 0.3;

/// The heights that a keyframe at a pose sees, without errors.
heights::HeightField Seen(const calib::CeilingView& view, const Pose2& T_map_base) {
  heights::HeightField field;
  field.grid = {20, 15};
  field.first_px = {-304, -224};
  field.step_px = {32, 32};
  field.cells.assign(300, heights::kUnknown);
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    const auto x_at = [&](double rho) {
      const Eigen::Vector2d p = view.MetresPerPixel() / rho * field.Centre(i);
      return (T_map_base * (view.T_base_view() * p).eval()).x();
    };
    if (x_at(1) < kBorder) field.cells[i] = {1, 0.01F};
    if (x_at(kNearer) >= kBorder) field.cells[i] = {kNearer, 0.01F};
  }
  return field;
}

/// A drive along x whose scale has an error for each keyframe: ratios too large, steps too short.
graph::MapGraph DriftingDrive(const calib::CeilingView& view, double drift) {
  graph::MapGraph graph;
  for (int i = 0; i < kKeyframes; ++i) {
    const double factor = std::exp(drift * i);
    graph::Keyframe keyframe;
    keyframe.id = i;
    keyframe.pose.T_map_base = {kStep * i, 0, 0};
    heights::HeightField field = Seen(view, keyframe.pose.T_map_base);
    field.Scale(factor);
    keyframe.heights = std::make_shared<const heights::HeightField>(std::move(field));
    graph.keyframes.push_back(keyframe);
    for (const int back : {1, 2}) {
      if (i < back) continue;
      graph::Edge edge;
      edge.from = i - back;
      edge.to = i;
      edge.T_from_to = {back * kStep / std::exp(drift * (i - back)), 0, 0};
      graph.edges.push_back(edge);
    }
  }
  return graph;
}

// The last keyframes see the nearer surface alone: their scale is that of those before.
TEST(ConsistentScales, FollowWhatKeyframesHaveInCommon) {
  const calib::CeilingView view = synthetic::CentredView();
  for (const double drift : {0.0, 0.008, -0.008}) {
    const auto factors = ConsistentScales(view, DriftingDrive(view, drift));
    ASSERT_EQ(factors.size(), static_cast<std::size_t>(kKeyframes));
    for (int i = 0; i < kKeyframes; ++i) {
      EXPECT_NEAR(std::log(factors.at(i)), drift * i, 0.012) << drift << ' ' << i;
    }
  }
}

// What moved while two images were taken can have any ratio.
TEST(ConsistentScales, CellsBehindTheCameraDoNotCount) {
  const calib::CeilingView view = synthetic::CentredView();
  graph::MapGraph graph = DriftingDrive(view, 0.008);
  for (const int i : {2, 3, 5, 8}) {
    heights::HeightField field = *graph.keyframes[static_cast<std::size_t>(i)].heights;
    for (std::size_t cell = 40; cell < 50; ++cell) field.cells[cell].rho = -0.4F;
    graph.keyframes[static_cast<std::size_t>(i)].heights =
        std::make_shared<const heights::HeightField>(std::move(field));
  }
  const auto factors = ConsistentScales(view, graph);
  for (int i = 0; i < kKeyframes; ++i) {
    EXPECT_NEAR(std::log(factors.at(i)), 0.008 * i, 0.012) << i;
  }
}

TEST(ConsistentScales, KeyframesWithoutHeightsHaveNone) {
  const calib::CeilingView view = synthetic::CentredView();
  graph::MapGraph graph = DriftingDrive(view, 0);
  graph.keyframes[3].heights = nullptr;
  EXPECT_FALSE(ConsistentScales(view, graph).contains(3));
  for (graph::Keyframe& keyframe : graph.keyframes) keyframe.heights = nullptr;
  EXPECT_TRUE(ConsistentScales(view, graph).empty());
}

}  // namespace
}  // namespace ceilmap::mapping
