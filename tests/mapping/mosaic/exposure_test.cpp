#include "mapping/mosaic/exposure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>

namespace ceilmap::mosaic {
namespace {

/// Observations of points of random brightness by keyframes of known gains.
struct Scene {
  ExposureModel truth;
  std::vector<ExposureObservation> observations;

  Scene(int keyframes, int points, double noise, double outlier_share) {
    cv::RNG rng(7);
    for (int k = 0; k < keyframes; ++k) truth.log_gain.push_back(rng.uniform(-0.3, 0.3));
    const double mean = std::accumulate(truth.log_gain.begin(), truth.log_gain.end(), 0.0) /
                        static_cast<double>(keyframes);
    for (double& gain : truth.log_gain) gain -= mean;
    truth.vignetting = {-0.4, 0.15, -0.1};
    for (int point = 0; point < points; ++point) {
      const double log_brightness = rng.uniform(4.0, 5.2);
      const int first = rng.uniform(0, keyframes);
      for (int k = 0; k < 4; ++k) {
        ExposureObservation o;
        o.point = point;
        o.keyframe = (first + k) % keyframes;
        o.q = rng.uniform(0.0, 1.0);
        o.log_grey = log_brightness + truth.log_gain[static_cast<std::size_t>(o.keyframe)] +
                     truth.LogVignetting(o.q) + rng.gaussian(noise);
        if (rng.uniform(0.0, 1.0) < outlier_share) o.log_grey += 0.5;
        observations.push_back(o);
      }
    }
  }

  void ExpectSolved(double tolerance) const {
    const ExposureModel model =
        SolveExposure(static_cast<int>(truth.log_gain.size()), observations);
    for (std::size_t k = 0; k < truth.log_gain.size(); ++k) {
      EXPECT_NEAR(model.log_gain[k], truth.log_gain[k], tolerance) << k;
    }
    for (const double q : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      EXPECT_NEAR(model.LogVignetting(q), truth.LogVignetting(q), tolerance) << q;
    }
  }
};

TEST(Exposure, FindsGainsAndVignetting) {
  Scene(20, 500, 0, 0).ExpectSolved(1e-4);
}
TEST(Exposure, AveragesNoise) {
  Scene(20, 2000, 0.01, 0).ExpectSolved(2e-3);
}
TEST(Exposure, LeavesOutliersAside) {
  Scene(20, 2000, 0.005, 0.05).ExpectSolved(4e-3);
}

TEST(Exposure, APointInAllKeyframesIsNotExpensive) {
  // 300 keyframes on one spot: each of the few points is seen by all of them.
  cv::RNG rng(3);
  std::vector<double> gains;
  std::vector<ExposureObservation> observations;
  for (int k = 0; k < 300; ++k) {
    gains.push_back(0.2 * std::sin(k));
    for (int point = 0; point < 200; ++point) {
      observations.push_back(
          {point, k, 0.0, 4 + 0.001 * point + gains.back() + rng.gaussian(0.003)});
    }
  }
  const double mean = std::accumulate(gains.begin(), gains.end(), 0.0) / 300;
  const ExposureModel model = SolveExposure(300, observations);
  for (std::size_t k = 0; k < gains.size(); ++k) {
    EXPECT_NEAR(model.log_gain[k], gains[k] - mean, 0.01) << k;
  }
}

TEST(Exposure, MeanGainIsZero) {
  const ExposureModel model = SolveExposure(20, Scene(20, 300, 0.01, 0.1).observations);
  EXPECT_NEAR(std::accumulate(model.log_gain.begin(), model.log_gain.end(), 0.0), 0, 1e-12);
}

TEST(Exposure, NothingInCommonMeansNoCorrection) {
  const std::vector<ExposureObservation> observations = {
      {0, 0, 0.3, 4.0}, {1, 1, 0.3, 5.0}, {2, 2, 0.3, 6.0}};
  for (const auto& set : {observations, std::vector<ExposureObservation>()}) {
    const ExposureModel model = SolveExposure(3, set);
    EXPECT_EQ(model.log_gain, std::vector<double>(3, 0.0));
    EXPECT_EQ(model.LogVignetting(1), 0);
  }
  EXPECT_TRUE(SolveExposure(0, {}).log_gain.empty());
}

/// Lattice points in the images of a camera that moves along its rows' direction, of which some
/// have bands: those taken before the bands were known, for example.
std::vector<ExposureObservation> WithBands(double flicker_hz,
                                           const std::map<int, std::complex<double>>& bands) {
  cv::RNG rng(11);
  ExposureModel truth;
  truth.flicker_hz = flicker_hz;
  truth.bands.assign(10, 0);
  for (const auto& [k, band] : bands) truth.bands[static_cast<std::size_t>(k)] = band;
  std::vector<ExposureObservation> observations;
  for (int point = 0; point < 600; ++point) {
    const double y = rng.uniform(0.0, 3.7);  // in heights of an image, which moves by 0.3
    const double log_brightness = rng.uniform(4.0, 5.2);
    for (int k = 0; k < 10; ++k) {
      const double v = y - 0.3 * k - 0.5;
      if (std::abs(v) > 0.5) continue;
      ExposureObservation o{point, k, 0.5 * v * v, 0, 0.025 * v};
      o.log_grey = log_brightness + truth.LogBand(k, o.row_s) + rng.gaussian(0.005);
      observations.push_back(o);
    }
  }
  return observations;
}

TEST(Exposure, FindsTheImagesThatHaveBands) {
  const std::complex<double> band(0.06, -0.08);
  for (const double hz : {100.0, 120.0}) {
    const ExposureModel model =
        SolveExposure(10, WithBands(hz, {{0, band}, {6, 0.5 * band}}), true);
    EXPECT_EQ(model.flicker_hz, hz);
    ASSERT_EQ(model.bands.size(), 10U);
    for (int k = 0; k < 10; ++k) {
      const std::complex<double> wanted = k == 0 ? band : k == 6 ? 0.5 * band : 0.0;
      EXPECT_LT(std::abs(model.bands[static_cast<std::size_t>(k)] - wanted), 0.012)
          << hz << ' ' << k;
    }
  }
}

TEST(Exposure, WithoutFlickerNoImageHasBands) {
  const ExposureModel model = SolveExposure(10, WithBands(100, {}), true);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(model.LogBand(k, 0.003), 0) << k;
}

TEST(Exposure, RowsExposedAtOnceHaveNoBands) {
  EXPECT_TRUE(SolveExposure(10, WithBands(100, {{0, 0.1}})).bands.empty());
}

}  // namespace
}  // namespace ceilmap::mosaic
