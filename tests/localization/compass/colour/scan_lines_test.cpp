#include "localization/compass/colour/scan_lines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "tests/localization/compass/colour/coloured_room.hpp"

namespace ceilmap::colour {
namespace {

constexpr double kRad = std::numbers::pi / 180;

TEST(ScanLines, StandSideBySideFromLeftToRight) {
  const ScanLines lines(ForwardCamera(14));
  ASSERT_TRUE(lines.Usable());
  ASSERT_EQ(lines.Azimuths().size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(lines.Azimuths()[i], -lines.Azimuths()[9 - i], 1e-9);
    EXPECT_GT(lines.Length(i), 30);
    if (i > 0) {
      EXPECT_LT(lines.Azimuths()[i], lines.Azimuths()[i - 1]);
    }
  }
  EXPECT_GT(lines.Azimuths()[0], 20 * kRad);
}

// f tan(14 deg) = 67.8 px below the centre lies the horizon.
TEST(ScanLines, KnowHowMuchIsAboveTheHorizon) {
  EXPECT_NEAR(ScanLines(ForwardCamera(14)).AboveHorizon(), (120 + 67.8) / 240, 0.01);
  EXPECT_NEAR(ScanLines(ForwardCamera(0)).AboveHorizon(), 0.5, 0.01);
  EXPECT_FALSE(ScanLines(ForwardCamera(0)).Usable());
  EXPECT_TRUE(ScanLines(ForwardCamera(0), {.min_above_horizon = 0.4}).Usable());
  EXPECT_FALSE(ScanLines(ForwardCamera(-30)).Usable());
}

TEST(ScanLines, AreUprightForATiltedRobotToo) {
  Tilt tilt;
  tilt.pitch_rad = -14 * kRad;  // nose up: a level camera then has the view of a raised one
  const ScanLines tilted(ForwardCamera(0), {}, tilt);
  const ScanLines raised(ForwardCamera(14));
  ASSERT_TRUE(tilted.Usable());
  EXPECT_NEAR(tilted.AboveHorizon(), raised.AboveHorizon(), 1e-9);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(tilted.Azimuths()[i], raised.Azimuths()[i], 1e-9);
    EXPECT_EQ(tilted.Length(i), raised.Length(i));
  }
}

// Each line meets the pixels of its azimuth, and none below the horizon.
TEST(ScanLines, SampleOneAzimuth) {
  const calib::MountedCamera forward = ForwardCamera(20);
  cv::Mat image(forward.camera.Size(), CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector3d ray =
          forward.T_base_cam.linear() * Eigen::Vector3d((u - 159.5) / 272, (v - 119.5) / 272, 1);
      const double azimuth = std::atan2(ray.y(), ray.x()) / kRad;
      image.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(127 + 2 * azimuth),
                                   0,
                                   static_cast<uchar>(ray.z() > 0 ? 200 : 0)};
    }
  }
  const ScanLines lines(forward);
  cv::Mat samples;
  lines.Sample(image, samples);
  for (int i = 0; i < samples.rows; ++i) {
    const double azimuth_deg = lines.Azimuths()[static_cast<std::size_t>(i)] / kRad;
    for (int u = 2; u < lines.Length(static_cast<std::size_t>(i)); ++u) {
      EXPECT_NEAR(samples.at<cv::Vec3b>(i, u)[0], 127 + 2 * azimuth_deg, 1.01) << i << " " << u;
      EXPECT_EQ(samples.at<cv::Vec3b>(i, u)[2], 200) << i << " " << u;
    }
  }
}

TEST(ScanLines, RefuseWhatCannotBe) {
  EXPECT_THROW(ScanLines(ForwardCamera(75)), InputError);
  EXPECT_THROW(ScanLines(ForwardCamera(14), {.lines = 1}), InputError);
  cv::Mat samples;
  const ScanLines lines(ForwardCamera(14));
  EXPECT_THROW(lines.Sample(cv::Mat(240, 320, CV_8UC1), samples), InputError);
  EXPECT_THROW(lines.Sample(cv::Mat(480, 640, CV_8UC3), samples), InputError);
}

TEST(LineFeatures, CountTransitionsUpTheLine) {
  const ScanLines lines(ForwardCamera(14));
  std::vector<ColourClass> two(2);
  two[0].mean = {0, 128, 128};
  two[1].mean = {255, 128, 128};
  const ColourClasses classes(two);
  int longest = 0;
  for (std::size_t i = 0; i < 10; ++i) longest = std::max(longest, lines.Length(i));
  cv::Mat samples(10, longest, CV_8UC3, cv::Scalar::all(0));
  samples.at<cv::Vec3b>(3, 5) = cv::Vec3b::all(255);
  samples.at<cv::Vec3b>(3, 6) = cv::Vec3b::all(255);
  LineFeatures features;
  CountTransitions(samples, lines, classes, features);
  ASSERT_EQ(features.rows(), 10);
  ASSERT_EQ(features.cols(), 4);
  const float n = static_cast<float>(lines.Length(3) - 1);
  EXPECT_NEAR(features(3, 0), (n - 3) / n, 1e-5);  // dark to dark
  EXPECT_NEAR(features(3, 1), 1 / n, 1e-6);        // dark to bright
  EXPECT_NEAR(features(3, 2), 1 / n, 1e-6);
  EXPECT_NEAR(features(3, 3), 1 / n, 1e-6);
  EXPECT_NEAR(features(4, 0), 1, 1e-5);
}

}  // namespace
}  // namespace ceilmap::colour
