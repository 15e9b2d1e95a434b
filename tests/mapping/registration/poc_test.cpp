#include "mapping/registration/poc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

const cv::Size kWindowSize(96, 80);

/// Periodic images: no window, so that shifts are exact.
PocParams Periodic() {
  return {.taper = 0, .band_sigma = 0.12};
}

/// White noise, i.e. all frequencies, shifted by any amount in its spectrum.
class PeriodicImage {
 public:
  explicit PeriodicImage(unsigned seed) : fft_(kWindowSize.height, kWindowSize.width) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0, 20);
    RealArray samples(fft_.RealSize());
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = normal(random);
    bins_.Resize(fft_.SpectrumSize());
    fft_.Forward({samples.data(), samples.size()}, {bins_.data(), bins_.size()});
  }

  /// Image with B(x) = A(x - shift), mean 0.
  [[nodiscard]] cv::Mat Shifted(const Eigen::Vector2d& shift) {
    ComplexArray bins(bins_.size());
    const std::size_t half = static_cast<std::size_t>(kWindowSize.width) / 2 + 1;
    for (int row = 0; row < kWindowSize.height; ++row) {
      for (int col = 0; col <= kWindowSize.width / 2; ++col) {
        // The highest frequency has no counterpart of the other sign; it is left out.
        if (row == kWindowSize.height / 2 || col == kWindowSize.width / 2) continue;
        const int k = row < kWindowSize.height / 2 ? row : row - kWindowSize.height;
        const double turns =
            col * shift.x() / kWindowSize.width + k * shift.y() / kWindowSize.height;
        const std::size_t i = static_cast<std::size_t>(row) * half + static_cast<std::size_t>(col);
        bins[i] = bins_[i] * std::complex<float>(std::polar(1.0, -2 * std::numbers::pi * turns));
      }
    }
    bins[0] = 0;
    cv::Mat image(kWindowSize, CV_32FC1);
    fft_.Inverse({bins.data(), bins.size()}, {image.ptr<float>(), fft_.RealSize()});
    return image / kWindowSize.area();
  }

 private:
  PlaneFft fft_;
  ComplexArray bins_;
};

double ErrorTo(const PocPeak& peak, double x, double y) {
  return (peak.shift - Eigen::Vector2d(x, y)).norm();
}

TEST(PocPlane, SubPixelShiftsOfPeriodicImages) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(1);
  const ComplexArray a = poc.Spectrum(image.Shifted({0, 0}));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> x(-45, 45);
  std::uniform_real_distribution<double> y(-38, 38);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d shift(x(random), y(random));
    poc.Correlate(a, poc.Spectrum(image.Shifted(shift)), 1e-3);
    const auto peaks = poc.BestPeaks(1);
    ASSERT_EQ(peaks.size(), 1U);
    EXPECT_LT(ErrorTo(peaks[0], shift.x(), shift.y()), 0.002) << shift.transpose();
  }
}

TEST(PocPlane, EqualImagesAgreeCompletely) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(3);
  const ComplexArray a = poc.Spectrum(image.Shifted({0, 0}));
  poc.Correlate(a, poc.Spectrum(image.Shifted({-11, 7})), 1e-3);
  const PocPeak peak = poc.BestPeaks(1).at(0);
  EXPECT_LT(ErrorTo(peak, -11, 7), 1e-3);
  EXPECT_NEAR(peak.height, 1, 1e-3);
  EXPECT_LT((peak.sharpness - Eigen::Matrix2d::Identity()).norm(), 0.02);
}

TEST(PocPlane, HeightBetweenPixelsIsThatOfTheNearestSample) {
  // A Gaussian band of deviation s is a Gaussian peak exp(-(2 pi s r)^2 / 2); half a pixel on both
  // axes is the farthest that a sample can be off its top.
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(4);
  const ComplexArray a = poc.Spectrum(image.Shifted({0, 0}));
  poc.Correlate(a, poc.Spectrum(image.Shifted({3.5, -2.5})), 1e-3);
  const double lowest = std::exp(-0.5 * std::pow(2 * std::numbers::pi * 0.12, 2) * 0.5);
  EXPECT_NEAR(poc.BestPeaks(1).at(0).height, lowest, 0.01);
}

TEST(PocPlane, UnrelatedImagesDoNotAgree) {
  PocPlane poc(kWindowSize, Periodic());
  const ComplexArray a = poc.Spectrum(PeriodicImage(5).Shifted({0, 0}));
  poc.Correlate(a, poc.Spectrum(PeriodicImage(6).Shifted({0, 0})), 1e-3);
  for (const PocPeak& peak : poc.BestPeaks(3)) EXPECT_LT(peak.height, 0.25);
}

TEST(PocPlane, FindsTheGhostToo) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(7);
  const cv::Mat both = image.Shifted({12.3, -5.6}) + 0.6 * image.Shifted({-20.4, 17.7});
  poc.Correlate(poc.Spectrum(image.Shifted({0, 0})), poc.Spectrum(both), 1e-3);
  const auto peaks = poc.BestPeaks(3);
  ASSERT_EQ(peaks.size(), 3U);
  EXPECT_LT(ErrorTo(peaks[0], 12.3, -5.6), 0.1);
  EXPECT_LT(ErrorTo(peaks[1], -20.4, 17.7), 0.15);
  EXPECT_GT(peaks[0].height, peaks[1].height);
  EXPECT_LT(peaks[2].height, 0.6 * peaks[1].height);
}

TEST(PocPlane, PeaksAcrossTheBorderAreFoundOnce) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(8);
  const ComplexArray a = poc.Spectrum(image.Shifted({0, 0}));
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(-0.4, 0.4), Eigen::Vector2d(-47.6, 39.6)}) {
    poc.Correlate(a, poc.Spectrum(image.Shifted(shift)), 1e-3);
    const auto peaks = poc.BestPeaks(2);
    ASSERT_GE(peaks.size(), 1U);
    EXPECT_NEAR(std::remainder(peaks[0].shift.x() - shift.x(), kWindowSize.width), 0, 0.002);
    EXPECT_NEAR(std::remainder(peaks[0].shift.y() - shift.y(), kWindowSize.height), 0, 0.002);
    for (std::size_t i = 1; i < peaks.size(); ++i) EXPECT_LT(peaks[i].height, 0.2);
  }
}

TEST(PocPlane, HalfTurnIsAConjugate) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(9);
  const cv::Mat first = image.Shifted({0, 0});
  const cv::Mat shifted = image.Shifted({8.25, -13.5});
  cv::Mat turned(kWindowSize, CV_32FC1);  // about pixel (0, 0)
  for (int y = 0; y < kWindowSize.height; ++y) {
    for (int x = 0; x < kWindowSize.width; ++x) {
      turned.at<float>((kWindowSize.height - y) % kWindowSize.height,
                       (kWindowSize.width - x) % kWindowSize.width) = shifted.at<float>(y, x);
    }
  }
  poc.Correlate(poc.Spectrum(first), poc.Spectrum(turned), 1e-3, true);
  const PocPeak peak = poc.BestPeaks(1).at(0);
  EXPECT_LT(ErrorTo(peak, 8.25, -13.5), 0.002);
  EXPECT_GT(peak.height, 0.85);
  poc.Correlate(poc.Spectrum(first), poc.Spectrum(turned), 1e-3, false);
  EXPECT_LT(poc.BestPeaks(1).at(0).height, 0.3);
}

TEST(PocPlane, NoiseLowersThePeakAndHardlyMovesIt) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(10);
  const cv::Mat first = image.Shifted({0, 0});
  cv::RNG random(11);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d shift(0.7 * i - 3, 2.5 - 0.3 * i);
    cv::Mat second = image.Shifted(shift);
    cv::Mat noise(kWindowSize, CV_32FC1);
    random.fill(noise, cv::RNG::NORMAL, 0, 10);  // half of the image's own deviation
    second += noise;
    poc.Correlate(poc.Spectrum(first), poc.Spectrum(second), 20 * 10 * poc.WindowPower());
    const PocPeak peak = poc.PeakWithin(8);
    EXPECT_LT(ErrorTo(peak, shift.x(), shift.y()), 0.05) << i;
    EXPECT_LT(peak.height, 0.97);
    EXPECT_GT(peak.height, 0.6);
  }
}

TEST(PocPlane, SubPixelShiftsOfCeilingsInOneShot) {
  const cv::Size size(256, 256);
  PocPlane poc(size);
  const synthetic::SyntheticCeiling ceiling;
  const ComplexArray a = poc.Spectrum(ceiling.Render(size));
  std::mt19937 random(12);
  std::uniform_real_distribution<double> part(-0.7, 0.7);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d shift(part(random), part(random));
    const cv::Mat moved = ceiling.Render(size, {shift.x(), shift.y(), 0, 1});
    poc.Correlate(a, poc.Spectrum(moved), 0.3 * 0.3 * poc.WindowPower());
    EXPECT_LT(ErrorTo(poc.PeakWithin(4), shift.x(), shift.y()), 0.02) << shift.transpose();
  }
}

TEST(PocPlane, ALineGivesOneDirectionOnly) {
  const cv::Size size(64, 64);
  PocPlane poc(size);
  cv::RNG random(14);
  const auto line = [&](double at) {
    cv::Mat image(size, CV_32FC1);
    random.fill(image, cv::RNG::NORMAL, 0, 1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        image.at<float>(y, x) += static_cast<float>(100 * std::exp(-0.25 * (x - at) * (x - at)));
      }
    }
    return poc.Spectrum(image);
  };
  const ComplexArray a = line(30);
  poc.Correlate(a, line(31.5), 4 * poc.WindowPower());
  const PocPeak peak = poc.PeakWithin(4);
  EXPECT_NEAR(peak.shift.x(), 1.5, 0.05);
  EXPECT_GT(peak.sharpness(0, 0), 0.6);
  EXPECT_LT(peak.sharpness(1, 1), 0.2);
}

TEST(PocPlane, SearchesWithinTheGivenReach) {
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(13);
  poc.Correlate(poc.Spectrum(image.Shifted({0, 0})), poc.Spectrum(image.Shifted({9, 0})), 1e-3);
  EXPECT_LT(poc.PeakWithin(5).height, 0.3);
  EXPECT_LT(ErrorTo(poc.PeakWithin(10), 9, 0), 1e-2);
}

TEST(PocPlane, NormalizedSurfacesHaveUnitPower) {
  const cv::Size size(64, 64);
  constexpr int kReach = 31;
  constexpr int kSide = 2 * kReach + 1;
  PocPlane poc(size);
  cv::RNG random(21);
  const auto noise = [&](double sigma) {
    cv::Mat image(size, CV_32FC1);
    random.fill(image, cv::RNG::NORMAL, 0, sigma);
    return poc.Spectrum(image);
  };
  std::vector<float> values(kSide * kSide);
  for (const double sigma : {1.0, 40.0}) {
    poc.Correlate(noise(sigma), noise(sigma), 0.5 * sigma * sigma * poc.WindowPower());
    poc.Normalized(kReach, values.data());
    const Eigen::Map<const Eigen::VectorXf> z(values.data(), Eigen::Index{kSide} * kSide);
    EXPECT_NEAR(z.squaredNorm() / static_cast<float>(z.size()), 1, 0.05);
    EXPECT_NEAR(z.mean(), 0, 0.1);
    EXPECT_LT(z.maxCoeff(), 5) << "images without anything in common";
  }
}

TEST(PocPlane, NormalizedSurfacesArePeakedAtTheShift) {
  constexpr int kReach = 9;
  constexpr int kSide = 2 * kReach + 1;
  PocPlane poc(kWindowSize, Periodic());
  PeriodicImage image(22);
  std::vector<float> values(kSide * kSide);
  for (const cv::Point shift : {cv::Point(7, -3), cv::Point(-9, 9), cv::Point(0, 0)}) {
    poc.Correlate(poc.Spectrum(image.Shifted({0, 0})),
                  poc.Spectrum(image.Shifted(Eigen::Vector2d(shift.x, shift.y))),
                  1e-3);
    poc.Normalized(kReach, values.data());
    const auto most = std::max_element(values.begin(), values.end());
    const auto at = static_cast<int>(most - values.begin());
    EXPECT_EQ(cv::Point(at % kSide - kReach, at / kSide - kReach), shift);
    EXPECT_GT(*most, 10);
  }
}

TEST(PocPlane, EmptyImagesHaveNoPeak) {
  PocPlane poc(kWindowSize);
  const ComplexArray nothing = poc.Spectrum(cv::Mat(kWindowSize, CV_8UC1, cv::Scalar(77)));
  for (const double noise_power : {0.0, 1.0}) {
    poc.Correlate(nothing, nothing, noise_power);
    EXPECT_TRUE(poc.BestPeaks(3).empty());
    EXPECT_EQ(poc.PeakWithin(4).height, 0);
  }
  std::vector<float> values(9 * 9, 1);
  poc.Normalized(4, values.data());
  EXPECT_EQ(values, std::vector<float>(9 * 9, 0));
}

TEST(PocPlane, RefusesOtherImages) {
  PocPlane poc(kWindowSize);
  EXPECT_THROW(poc.Spectrum(cv::Mat::zeros(kWindowSize, CV_16UC1)), std::invalid_argument);
  EXPECT_THROW(poc.Spectrum(cv::Mat::zeros(kWindowSize, CV_8UC3)), std::invalid_argument);
  EXPECT_THROW(poc.Spectrum(cv::Mat::zeros(kWindowSize.width, kWindowSize.height, CV_8UC1)),
               std::invalid_argument);
}

TEST(TukeyWindow, BetweenNoneAndHann) {
  for (const float w : TukeyWindow(9, 0)) EXPECT_EQ(w, 1);
  const auto hann = TukeyWindow(30, 0.5);
  for (int i = 0; i < 30; ++i) {
    EXPECT_NEAR(hann[static_cast<std::size_t>(i)],
                std::pow(std::sin(std::numbers::pi * (i + 0.5) / 30), 2),
                1e-6);
  }
  const auto window = TukeyWindow(41, 0.2);
  for (std::size_t i = 0; i < 41; ++i) EXPECT_EQ(window[i], window[40 - i]);
  EXPECT_EQ(window[9], 1);
  EXPECT_LT(window[7], 1);
  EXPECT_LT(window[0], 0.02);
}

}  // namespace
}  // namespace ceilmap::registration
