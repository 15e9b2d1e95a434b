#include "mapping/registration/polar.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mapping/registration/poc.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

const cv::Size kPolarSize(320, 240);

/// An image without a preferred direction.
synthetic::CeilingParams Plaster() {
  return {.seed = 3, .tile_px = 0, .lamps = false};
}

class PolarTest : public testing::Test {
 protected:
  ComplexArray Rings(const cv::Mat& image) {
    const ComplexArray spectrum = poc_.Spectrum(image);
    ComplexArray rings(search_.RingSpectrumSize());
    search_.Analyze({spectrum.data(), spectrum.size()},
                    static_cast<float>(0.1 * poc_.WindowPower()),
                    {rings.data(), rings.size()});
    return rings;
  }
  std::vector<RotationPeak> Search(const ComplexArray& a, const ComplexArray& b, bool scale) {
    return search_.Search({a.data(), a.size()}, {b.data(), b.size()}, scale);
  }

  PocPlane poc_{kPolarSize};
  PolarSearch search_{kPolarSize};
};

/// Difference of two angles that are known up to half a turn, degrees.
double HalfTurnErrorDeg(double a, double b) {
  return std::abs(std::remainder(a - b, std::numbers::pi)) / kRadPerDeg;
}

TEST_F(PolarTest, AImageAgreesWithItself) {
  const ComplexArray rings = Rings(synthetic::SyntheticCeiling().Render(kPolarSize));
  const auto peaks = Search(rings, rings, false);
  ASSERT_FALSE(peaks.empty());
  EXPECT_NEAR(peaks[0].theta_rad, 0, 1e-6);
  EXPECT_EQ(peaks[0].scale, 1);
  EXPECT_NEAR(peaks[0].value, 1, 1e-4);
}

TEST_F(PolarTest, RotationsOverTheHalfCircle) {
  const synthetic::SyntheticCeiling ceiling(Plaster());
  const ComplexArray reference = Rings(ceiling.Render(kPolarSize));
  for (int i = 0; i < 33; ++i) {
    const double theta_deg = -176.5 + 11 * i;
    const double theta = theta_deg * kRadPerDeg;
    const auto peaks =
        Search(reference, Rings(ceiling.Render(kPolarSize, {6, -4, theta, 1})), false);
    ASSERT_FALSE(peaks.empty());
    EXPECT_LT(HalfTurnErrorDeg(peaks[0].theta_rad, theta), 0.25) << theta_deg;
    EXPECT_GE(peaks[0].theta_rad, -std::numbers::pi / 2);
    EXPECT_LT(peaks[0].theta_rad, std::numbers::pi / 2);
    EXPECT_EQ(peaks[0].scale, 1);
  }
}

TEST_F(PolarTest, ScalesAndRotations) {
  const synthetic::SyntheticCeiling ceiling(Plaster());
  const ComplexArray reference = Rings(ceiling.Render(kPolarSize));
  for (const double scale : {0.7, 0.8, 0.9, 1.0, 1.12, 1.25, 1.4}) {
    const double theta = scale - 0.6;
    const auto peaks =
        Search(reference, Rings(ceiling.Render(kPolarSize, {0, 0, theta, scale})), true);
    ASSERT_FALSE(peaks.empty());
    EXPECT_LT(HalfTurnErrorDeg(peaks[0].theta_rad, theta), 0.5) << scale;
    EXPECT_NEAR(peaks[0].scale / scale, 1, 0.02);
  }
}

TEST_F(PolarTest, TilesLeaveTheTrueRotationAmongTheProposals) {
  const synthetic::SyntheticCeiling ceiling;
  const ComplexArray reference = Rings(ceiling.Render(kPolarSize));
  for (int i = 0; i < 10; ++i) {
    const double theta_deg = -85 + 19 * i;
    const auto peaks = Search(
        reference, Rings(ceiling.Render(kPolarSize, {0, 0, theta_deg * kRadPerDeg, 1})), false);
    double nearest = 90;
    for (const RotationPeak& peak : peaks) {
      nearest = std::min(nearest, HalfTurnErrorDeg(peak.theta_rad, theta_deg * kRadPerDeg));
    }
    EXPECT_LT(nearest, 0.5) << theta_deg;
  }
}

TEST_F(PolarTest, BestFirstNoMoreThanAskedAndApart) {
  const synthetic::SyntheticCeiling ceiling;
  const auto peaks = Search(
      Rings(ceiling.Render(kPolarSize)), Rings(ceiling.Render(kPolarSize, {0, 0, 0.3, 1})), false);
  ASSERT_LE(peaks.size(), 4U);
  for (std::size_t i = 1; i < peaks.size(); ++i) {
    EXPECT_LE(peaks[i].value, peaks[i - 1].value + 1e-3);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(HalfTurnErrorDeg(peaks[i].theta_rad, peaks[j].theta_rad), 3);
    }
  }
}

TEST_F(PolarTest, UniformImagesGetAProposalTooAndItIsANumber) {
  const ComplexArray flat = Rings(cv::Mat(kPolarSize, CV_8UC1, cv::Scalar(128)));
  for (const bool scale : {false, true}) {
    const auto peaks = Search(flat, flat, scale);
    ASSERT_FALSE(peaks.empty());
    for (const RotationPeak& peak : peaks) {
      EXPECT_TRUE(std::isfinite(peak.theta_rad) && std::isfinite(peak.scale) &&
                  std::isfinite(peak.value));
    }
  }
}

}  // namespace
}  // namespace ceilmap::registration
