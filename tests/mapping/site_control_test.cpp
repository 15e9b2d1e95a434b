#include "mapping/site_control.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/graph/bent_corridor.hpp"

namespace ceilmap::mapping {
namespace {

using graph::synthetic::Corridor;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// The measured points as a user picks them on the bent map.
std::vector<survey::ControlPoint> PickedOn(const Corridor& corridor,
                                           const std::vector<graph::ControlMeasurement>& measured) {
  std::vector<survey::ControlPoint> points;
  for (const graph::ControlMeasurement& measurement : measured) {
    const auto id = static_cast<std::size_t>(measurement.keyframe_id);
    const Pose2& T_map_base = corridor.graph.keyframes[id].pose.T_map_base;
    points.push_back({"P" + std::to_string(id),
                      T_map_base * measurement.p_base,
                      measurement.p_site,
                      measurement.sigma_m});
  }
  return points;
}

/// Root mean square error of the keyframes in the building.
double ErrorInBuilding(const Corridor& corridor, const Similarity2& S_site_map) {
  double squares = 0;
  for (const graph::Keyframe& keyframe : corridor.graph.keyframes) {
    const Pose2& truth = corridor.truth[static_cast<std::size_t>(keyframe.id)];
    squares +=
        (S_site_map * keyframe.pose.T_map_base.Translation() - corridor.site * truth.Translation())
            .squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(corridor.truth.size()));
}

TEST(ControlMap, ABentCorridorHasItsPlacesInTheBuilding) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Corridor corridor(seed);
    const std::vector<survey::ControlPoint> points = PickedOn(corridor, corridor.Points(0.002));
    const double before =
        ErrorInBuilding(corridor, survey::Align(points, {.sigma_m = 1}).site.S_site_map);
    const survey::Alignment alignment = ControlMap(corridor.graph, points, 2);
    EXPECT_GT(before, 0.1);
    EXPECT_LT(ErrorInBuilding(corridor, alignment.site.S_site_map), 0.005) << seed;
    EXPECT_EQ(alignment.used, static_cast<int>(points.size())) << seed;
  }
}

TEST(ControlMap, FindsAWrongPointInABentMap) {
  Corridor corridor(2, 0.0001);
  std::vector<survey::ControlPoint> points = PickedOn(corridor, corridor.Points(0.002));
  points[6].p_site += Eigen::Vector2d(0.7, -0.7);
  const survey::Alignment alignment = ControlMap(corridor.graph, points, 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(alignment.site.points[i].used, i != 6) << points[i].name;
  }
  EXPECT_LT(ErrorInBuilding(corridor, alignment.site.S_site_map), 0.005);
}

TEST(ControlMap, NamesAPointThatNoKeyframeShows) {
  Corridor corridor(3);
  std::vector<survey::ControlPoint> points = PickedOn(corridor, corridor.Points(0.002));
  points[1].p_map = {-500, 3};
  EXPECT_THAT([&] { ControlMap(corridor.graph, points, 2); },
              ThrowsMessage<InputError>(HasSubstr("'P10' at -500.000, 3.000 lies outside")));
}

}  // namespace
}  // namespace ceilmap::mapping
