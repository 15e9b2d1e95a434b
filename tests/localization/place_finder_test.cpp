#include "localization/place_finder.hpp"

#include <gtest/gtest.h>

#include <random>

#include "calib/base/error.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::AngleBetween;
using synthetic::DistanceOf;
using synthetic::Seen;
using synthetic::TrueMap;
using synthetic::UpCamera;

class PlaceFinderTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() { delete map_; }

  static Pose2 Anywhere(std::mt19937& random) {
    std::uniform_real_distribution<double> x(0.5, 4.3);
    std::uniform_real_distribution<double> y(0.4, 3.6);
    std::uniform_real_distribution<double> yaw(-3.1, 3.1);
    return {x(random), y(random), yaw(random)};
  }

  static TrueMap* map_;
};
TrueMap* PlaceFinderTest::map_ = nullptr;

TEST_F(PlaceFinderTest, FindsThePoseOfAnImage) {
  const calib::CeilingView view(UpCamera(250, 0.5), synthetic::kCeiling_m);
  PlaceFinder finder(*map_->map, view);
  std::mt19937 random(3);
  int right = 0;
  constexpr int kImages = 20;
  for (int i = 0; i < kImages; ++i) {
    const Pose2 truth = Anywhere(random);
    const auto places =
        finder.Find(Seen(map_->ceiling, view, truth, static_cast<std::uint32_t>(i) + 1));
    ASSERT_FALSE(places.empty()) << i;
    for (std::size_t k = 1; k < places.size(); ++k) {
      EXPECT_TRUE(places[k].any_yaw || places[0].votes >= places[k].votes);
    }
    if (DistanceOf(places[0].T_map_base, truth) < 0.2 &&
        AngleBetween(places[0].T_map_base, truth) < 0.1) {
      ++right;
      EXPECT_GE(places[0].keyframes, 2);
    }
  }
  EXPECT_GE(right, kImages - 2);
}

TEST_F(PlaceFinderTest, PlacesThatCannotBeAreLeftOut) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  PlaceFinder finder(*map_->map, view);
  const Pose2 truth{2.1, 1.9, 1};
  const cv::Mat image = Seen(map_->ceiling, view, truth);
  for (const PlaceProposal& place :
       finder.Find(image, [](const PlaceProposal& p) { return p.T_map_base.x > 3; })) {
    EXPECT_GT(place.T_map_base.x, 2.8);  // the mean of what was allowed
  }
  EXPECT_TRUE(finder.Find(image, [](const PlaceProposal&) { return false; }).empty());
}

TEST_F(PlaceFinderTest, ABlankImageIsNowhere) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  PlaceFinder finder(*map_->map, view);
  EXPECT_TRUE(finder.Find(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(90))).empty());
}

TEST_F(PlaceFinderTest, EndsBeforeItsIndexIsReady) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  const PlaceFinder finder(*map_->map, view);  // must not crash or wait for long
}

}  // namespace
}  // namespace ceilmap::localization
