#include "localization/map_patches.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "calib/base/error.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::Seen;
using synthetic::TrueMap;
using synthetic::UpCamera;

class MapPatchesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() { delete map_; }

  /// Root mean square difference of a drawn patch and what a camera would see there, grey levels.
  static double Difference(const calib::CeilingView& view, const Pose2& T_map_base) {
    registration::Registrar registrar(view.Size());
    const MapPatches patches(*map_->map, view, registrar);
    cv::Mat grey;
    cv::Mat mask;
    patches.Draw(T_map_base, grey, mask);
    EXPECT_EQ(cv::countNonZero(mask), static_cast<int>(mask.total()));
    return cv::norm(grey, Seen(map_->ceiling, view, T_map_base), cv::NORM_L2) /
           std::sqrt(static_cast<double>(grey.total()));
  }

  static TrueMap* map_;
};
TrueMap* MapPatchesTest::map_ = nullptr;

TEST_F(MapPatchesTest, ShowTheViewOfTheLocalizedRobot) {
  // Noise of 1.5 grey levels is in the images; half a pixel of shift would make more than 4.
  const calib::CeilingView same(UpCamera(), synthetic::kCeiling_m);
  EXPECT_LT(Difference(same, {2.4, 2.0, 0}), 2.5);
  EXPECT_LT(Difference(same, {2.613, 1.787, 2.2}), 2.5);
  const calib::CeilingView nearer(UpCamera(300, 0.6), synthetic::kCeiling_m);
  EXPECT_LT(Difference(nearer, {2.4, 2.0, -1}), 2.5);
  const calib::CeilingView wider(UpCamera(180, 0.3), synthetic::kCeiling_m);
  EXPECT_LT(Difference(wider, {2.4, 2.0, 0.5}), 2.5);
}

TEST_F(MapPatchesTest, LooksAreDrawnInTheOtherLightOnly) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  registration::Registrar registrar(view.Size());
  store::Look look;
  look.image = cv::Mat(store::Look::kSizePx, store::Look::kSizePx, CV_8UC1, cv::Scalar(0));
  look.image(cv::Rect(200, 200, 40, 30)).setTo(77);
  MapPatches patches(*map_->map, view, registrar, nullptr, {look});
  // Above the middle of the look.
  const store::MosaicGrid& grid = map_->map->Grid();
  const Pose2 below{grid.min_x + 220 * grid.resolution, grid.max_y - 215 * grid.resolution, 0};
  EXPECT_TRUE(patches.DependsOnLight(below));
  EXPECT_FALSE(patches.DependsOnLight({below.x + 10, below.y, 0}));
  const auto shown = [&] {
    cv::Mat grey;
    cv::Mat mask;
    patches.Draw(below, grey, mask);
    return cv::countNonZero(grey == 77);
  };
  const int by_chance = shown();
  patches.SetOtherLight(true);
  // A pixel of the view is one of the mosaic.
  EXPECT_NEAR(shown(), 40 * 30, by_chance + 150);
  const std::shared_ptr<const Patch> other = patches.Near(below);
  patches.SetOtherLight(false);
  EXPECT_EQ(shown(), by_chance);
  EXPECT_NE(patches.Near(below), other);
}

TEST_F(MapPatchesTest, ACoarseCameraGetsMeans) {
  const calib::CeilingView coarse(UpCamera(100, 0.2), synthetic::kCeiling_m);  // 24 mm a pixel
  registration::Registrar registrar(coarse.Size());
  const MapPatches patches(*map_->map, coarse, registrar);
  cv::Mat grey;
  cv::Mat mask;
  patches.Draw({2.4, 2.0, 0}, grey, mask);
  const double seen = cv::countNonZero(mask) / static_cast<double>(mask.total());
  EXPECT_GT(seen, 0.5);  // its view extends beyond the map's border
  EXPECT_LT(seen, 1);
  // The middle is the view of a camera of the map's scale, in less detail.
  cv::Mat fine;
  cv::Mat fine_mask;
  const calib::CeilingView same(UpCamera(), synthetic::kCeiling_m);
  const MapPatches of_map(*map_->map, same, registrar);
  of_map.Draw({2.4, 2.0, 0}, fine, fine_mask);
  const cv::Mat middle = grey(cv::Rect(94, 70, 132, 100));
  EXPECT_NEAR(cv::mean(middle)[0], cv::mean(fine)[0], 1.5);
}

TEST_F(MapPatchesTest, AreKeptAndSharedByNeighbours) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  registration::Registrar registrar(view.Size());
  MapPatches patches(*map_->map, view, registrar);
  const auto first = patches.Near({2.4, 2.0, 0});
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->spectrum.empty());
  EXPECT_NEAR(first->content, 1, 1e-9);
  EXPECT_EQ(patches.Near({2.45, 2.05, 0.1}), first);
  EXPECT_NE(patches.Near({2.9, 2.0, 0}), first);
  EXPECT_NE(patches.Near({2.4, 2.0, 0.5}), first);
  // The heading -pi + a bit is the same direction as pi.
  EXPECT_EQ(patches.Near({2.4, 2.0, 3.13}), patches.Near({2.4, 2.0, -3.13}));
}

TEST_F(MapPatchesTest, WhereLittleIsMappedThereIsNone) {
  const calib::CeilingView view(UpCamera(), synthetic::kCeiling_m);
  registration::Registrar registrar(view.Size());
  MapPatches patches(*map_->map, view, registrar);
  EXPECT_FALSE(patches.Near({-2, -2, 0}));
  EXPECT_FALSE(patches.Near({1e7, -1e7, 1}));
  const auto half = patches.Near({2.4, -1.1, 0});
  ASSERT_TRUE(half);
  EXPECT_LT(half->content, 0.7);
  EXPECT_GT(half->content, 0.3);
}

}  // namespace
}  // namespace ceilmap::localization
