#include "compensation/band_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace ceilmap::compensation {
namespace {

constexpr double kReadoutS = 0.025;

/// A ceiling whose points are found again with errors, in images with bands, vignetting and
/// another gain each; every fifth point is another one than in the image before.
struct BandedRecording {
  double frequency_hz = 100;
  double amplitude = 0.04;
  double frame_s = 0.1;
  double travel_rows = 0.15;  // between two images, of the image's height
  double noise = 0.02;
  std::mt19937 random{7};

  [[nodiscard]] double Band(double time_s) const {
    return amplitude * std::sin(2 * std::numbers::pi * frequency_hz * time_s + 0.4);
  }

  void Add(int i, BandFit& fit) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> anywhere(-0.5, 0.5);
    const double now = 50 + frame_s * i;
    const double before = 50 + frame_s * (i - 1);
    std::vector<BandSample> samples;
    for (int k = 0; k < 400; ++k) {
      const double u = anywhere(random);
      const double v = anywhere(random);
      const double earlier_v = v - travel_rows;
      if (std::abs(earlier_v) > 0.5) continue;
      BandSample sample;
      sample.row_s = kReadoutS * v;
      sample.earlier_row_s = kReadoutS * earlier_v;
      sample.radius2 = 2 * (u * u + v * v);
      sample.earlier_radius2 = 2 * (u * u + earlier_v * earlier_v);
      sample.log_ratio = Band(now + sample.row_s) - Band(before + sample.earlier_row_s) +
                         0.1 * std::sin(i) - 0.3 * (sample.radius2 - sample.earlier_radius2) +
                         noise * normal(random) + (k % 5 == 0 ? 0.3 * normal(random) : 0);
      samples.push_back(sample);
    }
    fit.Add(now, before, samples);
  }

  /// Largest error of the bands in the rows of the next image.
  [[nodiscard]] double ErrorIn(int i, const Bands& found) const {
    double largest = 0;
    for (double v = -0.5; v <= 0.5; v += 0.05) {
      const double time_s = 50 + frame_s * i + kReadoutS * v;
      largest = std::max(largest, std::abs(found.LogGain(time_s) - Band(time_s)));
    }
    return largest;
  }
};

void ExpectFound(BandedRecording recording) {
  BandFit fit;
  for (int i = 1; i < 25; ++i) recording.Add(i, fit);
  const auto found = fit.Solve();
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->frequency_hz, recording.frequency_hz, 0.035);
  EXPECT_LT(recording.ErrorIn(25, *found), 0.15 * recording.amplitude);
}

TEST(BandFit, FindsBandsThatWander) {
  ExpectFound({.frequency_hz = 100.07});
  ExpectFound({.frequency_hz = 119.9});
}

TEST(BandFit, FindsBandsThatStandStillInTheRows) {
  ExpectFound({.frequency_hz = 100, .frame_s = 0.1});
  ExpectFound({.frequency_hz = 120, .frame_s = 1 / 30.0});
}

TEST(BandFit, FollowsALampThatIsSwitchedOn) {
  BandedRecording recording{.frequency_hz = 99.94};
  BandFit fit;
  recording.amplitude = 0;
  for (int i = 1; i < 60; ++i) recording.Add(i, fit);
  EXPECT_FALSE(fit.Solve().has_value());
  recording.amplitude = 0.05;
  for (int i = 60; i < 120; ++i) recording.Add(i, fit);
  ASSERT_TRUE(fit.Solve().has_value());
  EXPECT_LT(recording.ErrorIn(120, *fit.Solve()), 0.005);
}

TEST(BandFit, LeavesWeakBandsButKeepsThoseItKnows) {
  BandedRecording recording{.frequency_hz = 100.05, .amplitude = 0.014};
  BandFit fit;
  for (int i = 1; i < 60; ++i) recording.Add(i, fit);
  EXPECT_FALSE(fit.Solve(false).has_value());
  ASSERT_TRUE(fit.Solve(true).has_value());
  EXPECT_LT(recording.ErrorIn(60, *fit.Solve(true)), 0.003);
}

TEST(BandFit, FindsNoneWhereThereAreNone) {
  BandedRecording recording{.amplitude = 0};
  BandFit fit;
  EXPECT_FALSE(fit.Solve().has_value());
  for (int i = 1; i < 100; ++i) {
    recording.Add(i, fit);
    EXPECT_FALSE(fit.Solve().has_value()) << i;
  }
}

/// In the images of a robot at rest, bands that stand still are part of the ceiling.
TEST(BandFit, AtRestStillBandsAreNotSeen) {
  BandedRecording recording{.travel_rows = 0};
  BandFit fit;
  for (int i = 1; i < 20; ++i) recording.Add(i, fit);
  EXPECT_FALSE(fit.Solve().has_value());
}

TEST(BandFit, KnowsThemWhileTheRobotRests) {
  BandedRecording recording{.frequency_hz = 100};
  BandFit fit;
  for (int i = 1; i < 25; ++i) recording.Add(i, fit);
  recording.travel_rows = 0;
  for (int i = 25; i < 40; ++i) recording.Add(i, fit);
  ASSERT_TRUE(fit.Solve().has_value());
  EXPECT_LT(recording.ErrorIn(40, *fit.Solve()), 0.004);
}

}  // namespace
}  // namespace ceilmap::compensation
