// Robots on a map of a ceiling with depth, with cameras of another height and focal length.

#include <gtest/gtest.h>

#include <cmath>

#include "localization/localizer.hpp"
#include "localization/map_uncertainty.hpp"
#include "tests/localization/depth_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::DeckCamera;
using synthetic::DepthMap;
using synthetic::DistanceOf;
using synthetic::kDeck_m;
using synthetic::SeenBelow;

class DepthMapTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new DepthMap(); }
  static void TearDownTestSuite() { delete map_; }

  static DepthMap* map_;
};
DepthMap* DepthMapTest::map_ = nullptr;

TEST_F(DepthMapTest, PatchesShowWhatAHigherCameraSees) {
  const calib::CeilingView view(DeckCamera(320, 0.9), kDeck_m);
  registration::Registrar registrar(view.Size());
  const mosaic::HeightMap heights(map_->map->ReadKeyframes(), map_->map->Metadata());
  const DepthDrawing depth(heights, map_->map->Metadata(), view);
  ASSERT_TRUE(depth.HasDepth());
  const MapPatches with_depth(*map_->map, view, registrar, &depth);
  const MapPatches plane(*map_->map, view, registrar);
  const Pose2 T_map_base{2.9, 0.5, 0.3};
  const cv::Mat seen = SeenBelow(map_->ceiling, view, T_map_base);
  // Fraction of the view that differs by more than the noise of both images.
  const auto unlike = [&](const MapPatches& patches) {
    cv::Mat grey;
    cv::Mat mask;
    patches.Draw(T_map_base, grey, mask);
    EXPECT_GT(cv::countNonZero(mask), 0.9 * static_cast<double>(mask.total()));
    cv::Mat difference;
    cv::absdiff(grey, seen, difference);
    constexpr double kNoise = 8;
    return cv::countNonZero((difference > kNoise) & mask) /
           static_cast<double>(cv::countNonZero(mask));
  };
  // The borders of the strips remain.
  const double at_borders = unlike(with_depth);
  EXPECT_LT(at_borders, 0.05);
  EXPECT_GT(unlike(plane), 1.8 * at_borders);
}

TEST_F(DepthMapTest, TheScaleIsUncertainAwayFromTheMiddle) {
  MapUncertainty shape(*map_->map);
  const Eigen::Vector2d from_middle(-2.4, -0.6);
  const Eigen::Matrix2d corner = shape.At({0, 0, 0}).topLeftCorner<2, 2>();
  const Eigen::Vector2d along = from_middle.normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double by_scale = 4e-6 * from_middle.squaredNorm();
  EXPECT_GT(along.dot(corner * along), by_scale);
  EXPECT_LT(along.dot(corner * along), 2 * by_scale);
  EXPECT_LT(across.dot(corner * across), 0.5 * by_scale);
  EXPECT_LT(shape.At({2.4, 0.6, 0}).topLeftCorner(2, 2).trace(), 0.5 * by_scale);
}

TEST_F(DepthMapTest, AStandingRobotIsFoundAtOnce) {
  const calib::MountedCamera up = DeckCamera(320, 0.9);
  const calib::CeilingView view(up, kDeck_m);
  for (const Pose2& truth : {Pose2{1.7, 0.3, 0.4}, Pose2{3.1, 0.9, -2.2}, Pose2{0.3, 0.8, 1.5}}) {
    Localizer localizer(*map_->map, up);
    Location location;
    for (int i = 0; i < 4; ++i) {
      const cv::Mat image =
          SeenBelow(map_->ceiling, view, truth, static_cast<std::uint32_t>(i) + 7);
      location = localizer.Locate({image, i, 0.1 * i, {}});
    }
    ASSERT_TRUE(location.Placed());
    EXPECT_LT(DistanceOf(location.pose.T_map_base, truth), 0.01);
    EXPECT_NEAR(WrapAngle(location.pose.T_map_base.yaw - truth.yaw), 0, 0.002);
  }
}

TEST_F(DepthMapTest, ARobotBelowAnotherDeckIsNotPlaced) {
  const calib::MountedCamera up = DeckCamera(320, 0.9);
  const calib::CeilingView view(up, kDeck_m);
  const registration::synthetic::SyntheticDepth elsewhere(synthetic::kStripRho, 0.45, 700);
  Localizer localizer(*map_->map, up);
  for (int i = 0; i < 6; ++i) {
    const cv::Mat image =
        SeenBelow(elsewhere, view, {1.7 + 0.2 * i, 0.3, 0.4}, static_cast<std::uint32_t>(i) + 7);
    EXPECT_FALSE(localizer.Locate({image, i, 0.1 * i, {}}).Placed());
  }
}

}  // namespace
}  // namespace ceilmap::localization
