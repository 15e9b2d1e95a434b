#include "localization/heading_track.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::localization {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Samples 0.05 to 0.9 s apart with headings anywhere on the circle.
std::vector<HeadingSample> RandomSamples(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> step_s(0.05, 0.9);
  std::uniform_real_distribution<double> heading_rad(-kPi, kPi);
  std::uniform_real_distribution<double> sigma_rad(0.01, 0.5);
  std::vector<HeadingSample> samples;
  double stamp_s = 1.7e9;
  for (int i = 0; i < count; ++i) {
    samples.push_back({stamp_s, heading_rad(random), sigma_rad(random)});
    stamp_s += step_s(random);
  }
  return samples;
}

void ExpectPrior(const std::optional<HeadingPrior>& prior,
                 double heading_rad,
                 double variance_rad2,
                 double tolerance = 1e-12) {
  ASSERT_TRUE(prior.has_value());
  EXPECT_NEAR(WrapAngle(prior->heading_rad - heading_rad), 0, tolerance);
  EXPECT_NEAR(prior->variance_rad2, variance_rad2, tolerance);
  EXPECT_GT(prior->heading_rad, -kPi);
  EXPECT_LE(prior->heading_rad, kPi);
}

TEST(HeadingTrack, InterpolatesByHand) {
  const HeadingTrack track({{10, 0.2, 0.1}, {11, 0.6, 0.2}},
                           {.variance_growth_rad2_per_s = 0.04, .max_gap_s = 0.5});
  ExpectPrior(track.At(10), 0.2, 0.01);
  ExpectPrior(track.At(11), 0.6, 0.04);
  ExpectPrior(track.At(10.25), 0.3, 0.75 * 0.01 + 0.25 * 0.04 + 0.25 * 0.04);
  ExpectPrior(track.At(10.75), 0.5, 0.25 * 0.01 + 0.75 * 0.04 + 0.25 * 0.04);
}

// From 170 deg to -170 deg is a left turn of 20 deg through 180, not one of 340 deg to the right.
TEST(HeadingTrack, TakesTheShorterWayThroughPi) {
  const double rad_per_deg = kPi / 180;
  const HeadingTrack track({{0, 170 * rad_per_deg, 0.1}, {1, -170 * rad_per_deg, 0.1}});
  ExpectPrior(track.At(0.25), 175 * rad_per_deg, 0.01 + 0.25 * 0.03);
  ExpectPrior(track.At(0.5), kPi, 0.01 + 0.5 * 0.03);
  ExpectPrior(track.At(0.75), -175 * rad_per_deg, 0.01 + 0.25 * 0.03);
}

TEST(HeadingTrack, HoldsTheEndsUpToTheGap) {
  const HeadingTrack track({{10, 1, 0.1}, {10.5, 2, 0.2}},
                           {.variance_growth_rad2_per_s = 0.04, .max_gap_s = 0.25});
  ExpectPrior(track.At(9.75), 1, 0.01 + 0.01);
  ExpectPrior(track.At(10.75), 2, 0.04 + 0.01);
  EXPECT_FALSE(track.At(9.749).has_value());
  EXPECT_FALSE(track.At(10.751).has_value());
}

// The robot may have turned anywhere in a gap of 10 s: the samples are held, not joined.
TEST(HeadingTrack, DoesNotBridgeAWideGap) {
  const HeadingTrack track({{0, 1, 0.1}, {10, 2, 0.2}},
                           {.variance_growth_rad2_per_s = 0.04, .max_gap_s = 0.5});
  ExpectPrior(track.At(0.5), 1, 0.01 + 0.02);
  ExpectPrior(track.At(9.5), 2, 0.04 + 0.02);
  EXPECT_FALSE(track.At(0.501).has_value());
  EXPECT_FALSE(track.At(5).has_value());
  EXPECT_FALSE(track.At(9.499).has_value());
}

TEST(HeadingTrack, HasNoHeadingOutsideItsSamplesAndInGaps) {
  const HeadingTrack track({{0, 1, 0.1}, {1, 2, 0.2}}, {.max_gap_s = 0});
  ExpectPrior(track.At(0), 1, 0.01);
  ExpectPrior(track.At(1), 2, 0.04);
  EXPECT_FALSE(track.At(1e-9).has_value());
  EXPECT_FALSE(track.At(0.5).has_value());
}

TEST(HeadingTrack, MayBeEmptyOrOfOneSample) {
  EXPECT_FALSE(HeadingTrack().At(0).has_value());
  const HeadingTrack one({{5, 3 * kPi, 0.1}});
  ExpectPrior(one.At(5), kPi, 0.01);
  ExpectPrior(one.At(4.75), kPi, 0.01 + 0.25 * 0.03);
  ExpectPrior(one.At(5.25), kPi, 0.01 + 0.25 * 0.03);
  EXPECT_FALSE(one.At(5.6).has_value());
}

TEST(HeadingTrack, HasNoAnswerForAMomentThatIsNone) {
  const HeadingTrack track({{0, 1, 0.1}, {1, 2, 0.2}});
  for (const double stamp_s : {kNan, kInfinity, -kInfinity}) {
    EXPECT_FALSE(track.At(stamp_s).has_value());
  }
}

TEST(HeadingTrack, ReturnsItsSamples) {
  std::mt19937 random(1);
  const auto samples = RandomSamples(random, 200);
  const HeadingTrack track(samples);
  for (const HeadingSample& sample : samples) {
    const auto prior = track.At(sample.stamp_s);
    ASSERT_TRUE(prior.has_value());
    EXPECT_EQ(prior->heading_rad, sample.heading_rad);
    EXPECT_EQ(prior->variance_rad2, sample.sigma_rad * sample.sigma_rad);
  }
}

// A robot that turns at a constant rate, many times around: its heading at any moment is known, and
// the samples' headings may be wrapped or not.
TEST(HeadingTrack, FollowsAConstantTurn) {
  std::mt19937 random(2);
  for (const double rate_rad_s : {-2.5, -0.3, 0.7, 3.0}) {
    std::vector<HeadingSample> samples = RandomSamples(random, 100);
    const double start_s = samples.front().stamp_s;
    for (HeadingSample& sample : samples) {
      sample.heading_rad = 1 + rate_rad_s * (sample.stamp_s - start_s);
    }
    const HeadingTrack unwrapped(samples);
    for (HeadingSample& sample : samples) sample.heading_rad = WrapAngle(sample.heading_rad);
    const HeadingTrack wrapped(samples);
    std::uniform_real_distribution<double> stamps_s(start_s, samples.back().stamp_s);
    for (int i = 0; i < 500; ++i) {
      const double stamp_s = stamps_s(random);
      const double truth_rad = 1 + rate_rad_s * (stamp_s - start_s);
      for (const HeadingTrack* track : {&wrapped, &unwrapped}) {
        const auto prior = track->At(stamp_s);
        ASSERT_TRUE(prior.has_value());
        EXPECT_NEAR(WrapAngle(prior->heading_rad - truth_rad), 0, 1e-9);
      }
    }
  }
}

// Another zero direction turns all answers and leaves their variances.
TEST(HeadingTrack, TurnsWithItsZeroDirection) {
  std::mt19937 random(3);
  auto samples = RandomSamples(random, 100);
  const HeadingTrack track(samples);
  for (HeadingSample& sample : samples) sample.heading_rad += 2;
  const HeadingTrack turned(samples);
  std::uniform_real_distribution<double> stamps_s(samples.front().stamp_s, samples.back().stamp_s);
  for (int i = 0; i < 1000; ++i) {
    const double stamp_s = stamps_s(random);
    const auto prior = track.At(stamp_s);
    ASSERT_TRUE(prior.has_value());
    ExpectPrior(turned.At(stamp_s), prior->heading_rad + 2, prior->variance_rad2);
  }
}

TEST(HeadingTrack, IsTheSameBackwardsInTime) {
  std::mt19937 random(4);
  const auto samples = RandomSamples(random, 100);
  std::vector<HeadingSample> reversed(samples.rbegin(), samples.rend());
  for (HeadingSample& sample : reversed) sample.stamp_s = -sample.stamp_s;
  const HeadingTrackParams params{.variance_growth_rad2_per_s = 0.1, .max_gap_s = 0.2};
  const HeadingTrack track(samples, params);
  const HeadingTrack mirrored(reversed, params);
  std::uniform_real_distribution<double> stamps_s(samples.front().stamp_s - 1,
                                                  samples.back().stamp_s + 1);
  for (int i = 0; i < 1000; ++i) {
    const double stamp_s = stamps_s(random);
    const auto prior = track.At(stamp_s);
    const auto mirror = mirrored.At(-stamp_s);
    ASSERT_EQ(prior.has_value(), mirror.has_value());
    if (prior) ExpectPrior(mirror, prior->heading_rad, prior->variance_rad2);
  }
}

// The variance lies between those of the neighbours plus growth, and there is an answer exactly
// within the gap.
TEST(HeadingTrack, VarianceGrowsWithTheDistanceToTheNearestSample) {
  std::mt19937 random(5);
  const auto samples = RandomSamples(random, 100);
  const HeadingTrackParams params{.variance_growth_rad2_per_s = 0.1, .max_gap_s = 0.3};
  const HeadingTrack track(samples, params);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const HeadingSample& a = samples[i - 1];
    const HeadingSample& b = samples[i];
    const auto [low, high] = std::minmax({a.sigma_rad * a.sigma_rad, b.sigma_rad * b.sigma_rad});
    for (const double part : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      const double stamp_s = a.stamp_s + part * (b.stamp_s - a.stamp_s);
      const double distance_s = std::min(stamp_s - a.stamp_s, b.stamp_s - stamp_s);
      const auto prior = track.At(stamp_s);
      ASSERT_EQ(prior.has_value(), distance_s <= params.max_gap_s);
      if (!prior) continue;
      EXPECT_GE(prior->variance_rad2, low + 0.1 * distance_s - 1e-15);
      EXPECT_LE(prior->variance_rad2, high + 0.1 * distance_s + 1e-15);
    }
  }
}

std::string ErrorOf(const std::vector<HeadingSample>& samples,
                    const HeadingTrackParams& params = {}) {
  try {
    const HeadingTrack track(samples, params);
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

TEST(HeadingTrack, RefusesBadSamples) {
  EXPECT_EQ(ErrorOf({{kNan, 0, 0.1}}), "heading sample 1: stamp_s = nan, must be finite");
  EXPECT_EQ(ErrorOf({{0, 0, 0.1}, {kInfinity, 0, 0.1}}),
            "heading sample 2: stamp_s = inf, must be finite");
  EXPECT_EQ(ErrorOf({{0, kNan, 0.1}}),
            "heading sample 1: heading_rad = nan, must be finite; leave out moments without a "
            "heading");
  EXPECT_EQ(ErrorOf({{0, 0, 0}}), "heading sample 1: sigma_rad = 0, must be finite and > 0");
  for (const double sigma_rad : {-0.1, kNan, kInfinity}) {
    EXPECT_THROW(HeadingTrack({{0, 0, sigma_rad}}), InputError) << sigma_rad;
  }
  for (const double stamp_s : {0.5, 1.0}) {
    EXPECT_EQ(ErrorOf({{1, 0, 0.1}, {stamp_s, 0, 0.1}}),
              "heading sample 2: stamp_s = " + std::string(stamp_s == 1 ? "1" : "0.5") +
                  ", must be larger than the one before; sort the samples and drop repeated "
                  "stamps");
  }
}

TEST(HeadingTrack, RefusesBadParameters) {
  EXPECT_EQ(ErrorOf({}, {.variance_growth_rad2_per_s = -1}),
            "heading track: variance_growth_rad2_per_s = -1, must be finite and >= 0");
  EXPECT_EQ(ErrorOf({}, {.max_gap_s = kInfinity}),
            "heading track: max_gap_s = inf, must be finite and >= 0");
  EXPECT_THROW((HeadingTrackParams{.max_gap_s = kNan}.Validate()), InputError);
}

}  // namespace
}  // namespace ceilmap::localization
