#include "localization/robot/map_updater.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <utility>

#include "calib/base/error.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "mapping/change/map_difference.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::robot {
namespace {

using namespace localization::synthetic;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A change of the image of a robot at a pose.
using Changed = std::function<void(const Pose2& T_map_base, cv::Mat& image)>;

class MapUpdaterTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() {
    delete map_;
    map_ = nullptr;
  }
  void SetUp() override { std::filesystem::copy_file(map_->folder / "true.gpkg", File()); }
  [[nodiscard]] std::filesystem::path File() const { return folder_ / "map.gpkg"; }

  /// A drive over the map. @param ceiling  that the robot sees.
  MapUpdateReport Drive(const SyntheticCeiling& ceiling,
                        const Changed& change = {},
                        bool at_once = true) {
    calib::Rig rig;
    rig.ceiling_height_m = kCeiling_m;
    rig.up = up_;
    MapUpdaterOptions options;
    options.at_once = at_once;
    options.min_step = 0.1;
    MapUpdater updater(File(), File(), "update", options);
    CeilingLocalizer localizer(File(), rig);
    const calib::CeilingView view(up_, kCeiling_m);
    Pose2 T{1.2, 1.2, 0.4};
    for (int i = 1; i <= 40; ++i) {
      T = T * Pose2{0.06, 0.005, 0.03};
      cv::Mat image = Seen(ceiling, view, T, static_cast<std::uint32_t>(i));
      if (change) change(T, image);
      updater.Add(localizer.AddCeiling({image, 0.1 * i, i}));
    }
    return updater.Finish({});
  }

  /// A banner: a striped square of 0.6 m around a place of the ceiling.
  void Hang(const Pose2& T_map_base, cv::Mat& image) const {
    const calib::CeilingView view(up_, kCeiling_m);
    const mosaic::ViewPlacement placement(
        T_map_base * view.T_base_view(), view.Size(), view.MetresPerPixel());
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const cv::Point2d p = placement.ToMap(u, v) - kBanner;
        if (std::abs(p.x) > 0.3 || std::abs(p.y) > 0.3) continue;
        const double wave = 40 * std::sin(40 * p.x) + 30 * std::sin(55 * p.y + 20 * p.x);
        image.at<unsigned char>(v, u) = cv::saturate_cast<unsigned char>(120 + wave);
      }
    }
  }

  static TrueMap* map_;
  inline static const cv::Point2d kBanner{2.1, 2.0};
  calib::MountedCamera up_ = UpCamera(250, 0.5);
  support::TempFolder folder_;
};

TrueMap* MapUpdaterTest::map_ = nullptr;

TEST_F(MapUpdaterTest, AnUnchangedCeilingLeavesTheMap) {
  const MapUpdateReport report = Drive(map_->ceiling);
  EXPECT_GT(report.views, 5);
  EXPECT_EQ(report.confirmed, 0);
  EXPECT_EQ(report.candidates, 0);
  EXPECT_EQ(report.keyframes, 0);
  EXPECT_EQ(report.session.id, 1);
  const store::MapReader before(map_->folder / "true.gpkg");
  const store::MapReader after(File());
  EXPECT_EQ(after.ReadHistory().sessions.size(), 1U);
  for (const graph::Keyframe& keyframe : before.ReadKeyframes()) {
    EXPECT_EQ(after.ReadPng(keyframe.id), before.ReadPng(keyframe.id));
  }
}

TEST_F(MapUpdaterTest, ABannerIsFoundAndTheMapShowsIt) {
  const auto banner = [this](const Pose2& T, cv::Mat& image) { Hang(T, image); };
  const MapUpdateReport report = Drive(map_->ceiling, banner);
  EXPECT_EQ(report.confirmed, 1);
  EXPECT_GT(report.keyframes, 0);
  const store::MapReader before(map_->folder / "true.gpkg");
  const store::MapReader after(File());
  const store::MapHistory history = after.ReadHistory();
  ASSERT_EQ(history.changes.size(), 1U);
  EXPECT_NEAR(history.changes[0].area, 0.36, 0.2);
  EXPECT_EQ(history.changes[0].kind, store::Change::Kind::kSurface);
  for (const cv::Point2d& p : history.changes[0].polygons[0][0]) {
    EXPECT_LT(cv::norm(p - kBanner), 0.3 * std::sqrt(2) + 0.25);
  }
  // The difference of the two maps is the same place, seen from either side.
  for (const auto& [a, b] : {std::pair(&before, &after), std::pair(&after, &before)}) {
    const change::MapDifference difference = change::CompareMaps(*a, *b, b->ReadKeyframes());
    ASSERT_EQ(difference.changes.size(), 1U);
    EXPECT_EQ(difference.changes[0].kind, store::Change::Kind::kSurface);
    EXPECT_NEAR(difference.changed_area, history.changes[0].area, 0.15);
    EXPECT_FALSE(difference.other_light);
    EXPECT_GT(difference.compared_area, 5 * difference.changed_area);
    for (const cv::Point2d& p : difference.changes[0].polygons[0][0]) {
      EXPECT_LT(cv::norm(p - kBanner), 0.3 * std::sqrt(2) + 0.25);
    }
  }
  EXPECT_TRUE(change::CompareMaps(before, before, before.ReadKeyframes()).changes.empty());
  EXPECT_TRUE(change::CompareMaps(after, after, after.ReadKeyframes(), 1).changes.empty());
  // Poses stay to the last bit; images change inside of the banner only.
  const std::vector<graph::Keyframe> old = before.ReadKeyframes();
  const std::vector<graph::Keyframe> kept = after.ReadKeyframes();
  ASSERT_EQ(old.size(), kept.size());
  for (std::size_t i = 0; i < old.size(); ++i) {
    EXPECT_EQ(old[i].pose.T_map_base.x, kept[i].pose.T_map_base.x);
    EXPECT_EQ(old[i].pose.T_map_base.yaw, kept[i].pose.T_map_base.yaw);
  }
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid& grid = after.Grid();
  after.ReadMosaic({0, 0, grid.width_px, grid.height_px}, grey, alpha);
  double squares = 0;
  int pixels = 0;
  for (int row = 0; row < grey.rows; ++row) {
    for (int col = 0; col < grey.cols; ++col) {
      const Eigen::Vector2d at = store::PixelToMap(grid, {col, row});
      const cv::Point2d p = cv::Point2d(at.x(), at.y()) - kBanner;
      if (std::abs(p.x) > 0.25 || std::abs(p.y) > 0.25) continue;
      const double wave = 40 * std::sin(40 * p.x) + 30 * std::sin(55 * p.y + 20 * p.x);
      squares += std::pow(grey.at<unsigned char>(row, col) - 120 - wave, 2);
      ++pixels;
    }
  }
  EXPECT_LT(std::sqrt(squares / pixels), 8);

  // The next session sees what the map shows.
  const MapUpdateReport again = Drive(map_->ceiling, banner);
  EXPECT_EQ(again.confirmed, 0);
  EXPECT_EQ(store::MapReader(File()).ReadHistory().changes.at(0).last_session, 2);
}

TEST_F(MapUpdaterTest, ASecondSessionConfirms) {
  const auto banner = [this](const Pose2& T, cv::Mat& image) { Hang(T, image); };
  const MapUpdateReport first = Drive(map_->ceiling, banner, false);
  EXPECT_EQ(first.confirmed, 0);
  EXPECT_EQ(first.candidates, 1);
  EXPECT_EQ(first.keyframes, 0);
  const MapUpdateReport second = Drive(map_->ceiling, banner, false);
  EXPECT_EQ(second.confirmed, 1);
  EXPECT_GT(second.keyframes, 0);
  EXPECT_EQ(Drive(map_->ceiling, banner, false).candidates, 0);
}

TEST_F(MapUpdaterTest, WhatHangsFarBelowTheCeilingIsNoChange) {
  // Half-way between camera and ceiling: in each image at another place of the mosaic.
  const auto person = [this](const Pose2& T, cv::Mat& image) {
    Pose2 seen = T;
    seen.x += T.x - kBanner.x;
    seen.y += T.y - kBanner.y;
    Hang(seen, image);
  };
  const MapUpdateReport report = Drive(map_->ceiling, person);
  EXPECT_EQ(report.confirmed, 0);
  EXPECT_EQ(report.keyframes, 0);
}

TEST_F(MapUpdaterTest, AnotherBuildingIsRefused) {
  CeilingParams other;
  other.seed = 4711;
  EXPECT_THAT([&] { Drive(SyntheticCeiling(other)); },
              ThrowsMessage<RunError>(HasSubstr("nothing was changed")));
  EXPECT_TRUE(store::MapReader(File()).ReadHistory().sessions.empty());
}

TEST_F(MapUpdaterTest, ASecondUpdateOfTheMapIsRefusedMeanwhile) {
  const MapUpdater first(File(), File(), "first");
  EXPECT_THROW(MapUpdater(File(), File(), "second"), InputError);
}

}  // namespace
}  // namespace ceilmap::robot
