#include "app/recordings/omni_headings.hpp"

#include <cmath>
#include <numbers>

#include "app/recordings/sensor_fusion.hpp"
#include "tests/support/synthetic_recording.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const cv::Size kSize(160, 160);

/// A compass that turns by the grey level of each panorama, in degrees, and doubts it the more the
/// longer it runs. Black tells nothing.
class GreyCompass : public compass::Compass {
 public:
  GreyCompass(std::vector<double>& stamps, std::vector<std::optional<Eigen::Vector2d>>& travels)
      : stamps_(stamps), travels_(travels) {}

  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override {
    stamps_.push_back(frame.stamp_s);
    travels_.push_back(frame.travel);
    const double grey = cv::mean(frame.panorama)[0];
    compass::HeadingEstimate estimate;
    estimate.heading_rad = grey * std::numbers::pi / 180;
    estimate.variance_rad2 = 1e-4 * static_cast<double>(stamps_.size() - 1);
    estimate.confidence = grey < 1 ? 0 : 1;
    return estimate;
  }
  [[nodiscard]] compass::DistanceProfile Profile() const override { return {}; }
  [[nodiscard]] std::int64_t References() const override { return 1; }

 private:
  std::vector<double>& stamps_;
  std::vector<std::optional<Eigen::Vector2d>>& travels_;
};

class OmniHeadingsTest : public testing::Test {
 protected:
  /// Images of these grey levels, at these times.
  OmniHeadings Make(const std::vector<int>& greys, double first_s, double period_s) {
    std::vector<cv::Mat> images;
    for (const int grey : greys) images.emplace_back(kSize, CV_8UC1, cv::Scalar(grey));
    support::WriteImages(folder_ / "omni", images);
    const auto count = static_cast<int>(greys.size());
    const auto stamps = folder_.Write("omni.csv", support::StampsCsv(count, first_s, period_s));
    return {std::make_unique<SynchronizedStream>((folder_ / "omni").string(), stamps, "mirror"),
            calib::MirrorView(kSize, calib::MirrorRing{{79.5, 79.5}, 20, 70}),
            std::make_unique<GreyCompass>(stamps_, travels_),
            {0.5, 0}};
  }
  static double Deg(const std::optional<HeadingPrior>& heading) {
    return heading.value().heading_rad * 180 / std::numbers::pi;
  }

  support::TestFolder folder_;
  std::vector<double> stamps_;                           // of what the compass was shown ...
  std::vector<std::optional<Eigen::Vector2d>> travels_;  // ... and what it was told of the way
};

TEST_F(OmniHeadingsTest, GoWithUpwardFramesOfTheSameTimes) {
  OmniHeadings headings = Make({10, 20, 30}, 100, 0.1);
  for (int i = 0; i < 3; ++i) {
    const auto heading = headings.At(100 + 0.1 * i);
    EXPECT_NEAR(Deg(heading), 10 + 10 * i, 0.01);
    EXPECT_GT(heading->variance_rad2, 0) << "of the first one too";
    EXPECT_NEAR(heading->variance_rad2, 1e-4 * i, 1e-6);
  }
  EXPECT_FALSE(headings.At(101));
  EXPECT_EQ(headings.Quality()["headings"], 3);
  EXPECT_EQ(headings.Quality()["missing"], 1);
  EXPECT_THAT(headings.Warnings(),
              ElementsAre(HasSubstr("1 of 4 upward frames have no mirror frame at their time")));
}

TEST_F(OmniHeadingsTest, AImageIsShownOnceHoweverOftenItIsTheNearest) {
  OmniHeadings headings = Make({10, 20}, 100, 0.1);
  for (const double stamp_s : {99.96, 100.0, 100.04, 100.06, 100.1}) {
    EXPECT_TRUE(headings.At(stamp_s)) << stamp_s;
  }
  EXPECT_THAT(stamps_, ElementsAre(100, testing::DoubleNear(100.1, 1e-9)));
}

TEST_F(OmniHeadingsTest, WhatTheRobotTurnsBetweenTheTwoCamerasIsDoubt) {
  OmniHeadings headings = Make({10, 20, 30}, 100, 0.1);
  (void)headings.At(100);
  (void)headings.At(100.1);
  // 100 deg/s, seen 40 ms later.
  const double off_rad = 4 * std::numbers::pi / 180;
  EXPECT_NEAR(headings.At(100.14)->variance_rad2, 1e-4 + off_rad * off_rad, 1e-4);
}

TEST_F(OmniHeadingsTest, ImagesThatTellNothingAreTold) {
  OmniHeadings headings = Make({10, 0, 0, 40}, 100, 0.1);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(headings.At(100 + 0.1 * i)) << i;
  EXPECT_EQ(headings.Quality()["held"], 2);
  EXPECT_THAT(headings.Warnings(), ElementsAre(HasSubstr("2 of 4 mirror images tell no heading")));
}

TEST_F(OmniHeadingsTest, ComeWithTheFramesThatAreReadAhead) {
  OmniHeadings headings = Make({10, 20, 30, 40}, 100, 0.1);
  support::WriteImages(folder_ / "up",
                       std::vector<cv::Mat>(4, cv::Mat(kSize, CV_8UC1, cv::Scalar(5))));
  FrameSource up((folder_ / "up").string(),
                 {.stamps = folder_.Write("up.csv", support::StampsCsv(4, 100, 0.1))});
  SensorFusion frames(up, nullptr, &headings);
  MeasuredFrame frame;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(frames.Read(frame));
    EXPECT_EQ(frame.frame.index, i);
    EXPECT_NEAR(Deg(frame.context.heading), 10 + 10 * i, 0.01);
    EXPECT_TRUE(frame.context.tilt.IsLevel());
  }
  EXPECT_FALSE(frames.Read(frame));
  EXPECT_THAT(headings.Warnings(), IsEmpty());
}

TEST_F(OmniHeadingsTest, TellTheCompassHowTheMirrorTravels) {
  constexpr int kFrames = 7;
  OmniHeadings headings = Make(std::vector<int>(kFrames, 50), 100, 0.1);
  support::WriteImages(folder_ / "up",
                       std::vector<cv::Mat>(kFrames, cv::Mat(kSize, CV_8UC1, cv::Scalar(5))));
  FrameSource up((folder_ / "up").string(),
                 {.stamps = folder_.Write("up.csv", support::StampsCsv(kFrames, 100, 0.1))});
  SensorFusion frames(up, nullptr, &headings);
  MeasuredFrame frame;
  for (int i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(frames.Read(frame));
    // Sideways along the wall, turning; once it was lost.
    frames.Locate(i == 4 ? std::nullopt : std::optional(Pose2{1, 0.2 * i, 0.1 * i}));
  }
  // A frame is looked at while the one before is located, so two poses must be known before that.
  ASSERT_EQ(travels_.size(), kFrames);
  for (const int i : {0, 1, 2, 6}) EXPECT_FALSE(travels_[static_cast<std::size_t>(i)]) << i;
  for (const int i : {3, 4, 5}) {
    const auto& travel = travels_[static_cast<std::size_t>(i)];
    ASSERT_TRUE(travel) << i;
    // By the way from frame i - 3 to i - 2; the mirror stands half a metre ahead of the axle.
    const double yaw = 0.1 * (i - 2);
    EXPECT_NEAR(travel->x(), 0.2 * std::sin(yaw), 0.01) << i;
    EXPECT_NEAR(travel->y(), 0.2 * std::cos(yaw) + 0.5 * 0.1, 0.01) << i;
  }
}

}  // namespace
}  // namespace ceilmap::recordings
