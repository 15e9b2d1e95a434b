#include "localization/submap_search.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "localization/submap_evidence.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::AngleBetween;
using synthetic::CeilingParams;
using synthetic::DistanceOf;
using synthetic::kCeiling_m;
using synthetic::Periodic;
using synthetic::SyntheticCeiling;
using synthetic::TrueMap;
using synthetic::UpCamera;

/// Grain and grooves below the noise of a pixel.
CeilingParams Weak(std::uint32_t seed) {
  CeilingParams params;
  params.seed = seed;
  params.tile_px = 0;
  params.speckle_grey = 6;
  params.lamps = false;
  params.marks = false;
  return params;
}

/// What a robot sees that drives straight ahead, its position known only by its own motion.
class Drive {
 public:
  explicit Drive(const SyntheticCeiling& ceiling) : ceiling_(ceiling), submap_(view_) {}

  const Submap& Along(Pose2 T_map_base, int steps = 12, bool inverted = false) {
    const Pose2 step{0.25, 0, 0};
    submap_.Clear();
    for (int i = 0; i < steps; ++i) {
      if (i > 0) {
        submap_.Move(step);
        T_map_base = T_map_base * step;
      }
      registration::ImageMotion motion = synthetic::MotionAt(view_, T_map_base);
      motion.scale = synthetic::kUnit_m / view_.MetresPerPixel();
      constexpr double kNoiseGrey = 8;
      const auto seed = static_cast<std::uint32_t>(i) + 7;
      cv::Mat image = ceiling_.Render(view_.Size(), motion, kNoiseGrey, seed);
      if (inverted) image = 255 - image;
      submap_.Add(image, {});
    }
    T_map_base_ = T_map_base;
    return submap_;
  }
  [[nodiscard]] const Pose2& Last() const { return T_map_base_; }
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }

 private:
  const SyntheticCeiling& ceiling_;
  calib::CeilingView view_{UpCamera(), kCeiling_m};
  Submap submap_;
  Pose2 T_map_base_;
};

/// Whether a single search tells the place.
bool IsClear(const SubmapSearch::Result& found) {
  SubmapEvidence evidence;
  evidence.Add(found, {}, 1);
  return evidence.IsClear();
}

const TrueMap& WeakMap() {
  static const TrueMap map(Weak(1));
  return map;
}

TEST(SubmapSearch, FindsTheLastMetresUnderAWeakCeiling) {
  SubmapSearch search(*WeakMap().map);
  Drive drive(WeakMap().ceiling);
  for (const Pose2& start : {Pose2{0.5, 0.4, 0.3}, Pose2{4.5, 3.5, -2.9}, Pose2{3.2, 0.6, 1.4}}) {
    const Submap& submap = drive.Along(start);
    const auto found = search.Find(submap);
    ASSERT_TRUE(found);
    EXPECT_TRUE(IsClear(*found)) << found->score << " " << found->second;
    EXPECT_LT(DistanceOf(found->pose.pose, drive.Last()), submap.Unit());
    EXPECT_LT(AngleBetween(found->pose.pose, drive.Last()), 1.5 * kRadPerDeg);
    const Eigen::Vector3d sigma = found->pose.covariance.diagonal().cwiseSqrt();
    EXPECT_GT(sigma.x(), DistanceOf(found->pose.pose, drive.Last()));
  }
}

TEST(SubmapSearch, AnotherCeilingIsNotClear) {
  SubmapSearch search(*WeakMap().map);
  for (const std::uint32_t seed : {2U, 3U, 4U}) {
    const SyntheticCeiling other(Weak(seed));
    Drive drive(other);
    const auto found = search.Find(drive.Along({1, 1, 0.5}));
    EXPECT_FALSE(found && IsClear(*found)) << found->score << " " << found->second;
  }
}

TEST(SubmapSearch, OtherLightMayMakeDarkOfBright) {
  // Nothing but the directions of the edges is the same.
  SubmapSearch search(*WeakMap().map);
  Drive drive(WeakMap().ceiling);
  for (const Pose2& start : {Pose2{0.5, 0.4, 0.3}, Pose2{3.2, 0.6, 1.4}}) {
    const auto found = search.Find(drive.Along(start, 12, true));
    ASSERT_TRUE(found);
    EXPECT_GT(found->Lead(), 1);
    const double sigma = std::sqrt(found->pose.covariance(0, 0));
    EXPECT_LT(DistanceOf(found->pose.pose, drive.Last()), sigma);
  }
}

TEST(SubmapSearch, IdenticalTilesAreNotClear) {
  const TrueMap map(Periodic());
  SubmapSearch search(*map.map);
  Drive drive(map.ceiling);
  const auto found = search.Find(drive.Along({1, 1, 0.5}));
  ASSERT_TRUE(found);
  EXPECT_FALSE(IsClear(*found)) << found->score << " " << found->second;
}

TEST(SubmapSearch, AHeadingExcludesOthers) {
  SubmapSearch search(*WeakMap().map);
  Drive drive(WeakMap().ceiling);
  const Submap& submap = drive.Along({0.5, 0.4, 0.3});
  const auto near = [](double yaw) { return std::abs(WrapAngle(yaw - 0.3)) < 0.3; };
  const auto found = search.Find(submap, near);
  ASSERT_TRUE(found);
  EXPECT_LT(DistanceOf(found->pose.pose, drive.Last()), submap.Unit());
  EXPECT_FALSE(search.Find(submap, [](double) { return false; }));
}

TEST(Submap, KeepsWhatIsNew) {
  const calib::CeilingView view(UpCamera(), kCeiling_m);
  Submap submap(view);
  const cv::Mat image(view.Size(), CV_8UC1, cv::Scalar(100));
  submap.Add(image, {});
  EXPECT_EQ(submap.Length(), 0);
  submap.Move({0.01, 0, 0});  // too near to the first one
  submap.Add(image, {});
  EXPECT_EQ(submap.Length(), 0);
  submap.Move({0.6, 0, 0.2});
  submap.Add(image, {});
  EXPECT_NEAR(submap.Length(), 0.61, 1e-9);
  EXPECT_NEAR(submap.Travelled(), 0.61, 1e-9);
  submap.Clear();
  EXPECT_EQ(submap.Travelled(), 0);
}

TEST(Submap, AnEvenCeilingHasNoStructure) {
  const calib::CeilingView view(UpCamera(), kCeiling_m);
  Submap submap(view);
  cv::Mat mask(view.Size(), CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 60, view.Size().height)).setTo(0);
  submap.Add(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(100)), mask);
  const Submap::Drawing drawing = submap.Draw(1);
  const double all = cv::countNonZero(drawing.structure.known);
  const double image =
      static_cast<double>(view.Size().area()) * std::pow(view.MetresPerPixel() / submap.Unit(), 2);
  EXPECT_GT(all, 0.6 * image);
  EXPECT_LT(all, (1 - 60.0 / view.Size().width) * image);
  EXPECT_LT(cv::norm(drawing.structure.detail, cv::NORM_INF), 0.1);
}

}  // namespace
}  // namespace ceilmap::localization
