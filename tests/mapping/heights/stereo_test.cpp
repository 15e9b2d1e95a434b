#include "mapping/heights/stereo.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace ceilmap::heights {
namespace {

constexpr double kRotation = 0.2;  // of the partner, radians
constexpr double kLampPx = 24;     // half the side of a saturated square in the middle

/// A ceiling that is known at every point: waves of 8 to 60 px in all directions.
class Ceiling {
 public:
  Ceiling() {
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    constexpr int kWaves = 150;
    for (int i = 0; i < kWaves; ++i) {
      const double direction = 2 * std::numbers::pi * uniform(generator);
      const double length = 8 + 52 * uniform(generator) * uniform(generator);
      const double frequency = 2 * std::numbers::pi / length;
      waves_.push_back({frequency * std::cos(direction),
                        frequency * std::sin(direction),
                        2 * std::numbers::pi * uniform(generator)});
    }
  }

  /// The image whose pixel x, from the centre, shows the ceiling's point at(x).
  template <typename At>
  [[nodiscard]] cv::Mat Image(cv::Size size, At at) const {
    cv::Mat image(size, CV_8UC1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Eigen::Vector2d x =
            at(Eigen::Vector2d(u - 0.5 * (size.width - 1), v - 0.5 * (size.height - 1)));
        double sum = 0;
        for (const Eigen::Vector3d& wave : waves_)
          sum += std::cos(wave.x() * x.x() + wave.y() * x.y() + wave.z());
        const bool lamp = x.cwiseAbs().maxCoeff() < kLampPx;
        image.at<uchar>(v, u) = lamp ? 255 : cv::saturate_cast<uchar>(120 + 5 * sum);
      }
    }
    return image;
  }

 private:
  std::vector<Eigen::Vector3d> waves_;  // frequencies, phase
};

double MedianRho(const HeightField& field) {
  std::vector<double> rho;
  for (const HeightCell& cell : field.cells) {
    if (cell.sigma < kMeasuredSigma) rho.push_back(cell.rho);
  }
  if (rho.size() < field.cells.size() / 2) return 0;
  std::nth_element(
      rho.begin(), rho.begin() + static_cast<std::ptrdiff_t>(rho.size() / 2), rho.end());
  return rho[rho.size() / 2];
}

class Stereo : public testing::Test {
 protected:
  /// An image of the ceiling at ratio rho, after the reference plane moved by `shift_px`.
  [[nodiscard]] StereoPartner Partner(const Eigen::Vector2d& shift_px, double rho) const {
    const Eigen::Matrix2d back = Eigen::Rotation2Dd(-kRotation).toRotationMatrix();
    return {ForStereo(ceiling_.Image(
                size_, [&](const Eigen::Vector2d& x) { return back * (x - rho * shift_px); })),
            kRotation,
            shift_px};
  }
  [[nodiscard]] StereoReference Reference() const {
    return {ForStereo(ceiling_.Image(size_, [](const Eigen::Vector2d& x) { return x; })),
            size_,
            {},
            Eigen::Vector2d::Zero()};
  }

  const cv::Size size_{320, 240};

 private:
  Ceiling ceiling_;
};

// Semi-global matching alone is off by up to 3 % here.
TEST_F(Stereo, DisparitiesAreNotDrawnToWholePixels) {
  const StereoReference reference = Reference();
  for (const double shift : {30.0, 30.3, 30.7, 31.0, 31.4, 31.8}) {
    const HeightField field =
        MeasureByStereo(reference, {Partner({0.6 * shift, 0.8 * shift}, 1.0)}, {});
    EXPECT_NEAR(MedianRho(field), 1.0, 0.002) << shift;
  }
}

TEST_F(Stereo, SaturatedAreasAreMeasuredLessAccurately) {
  const HeightField field =
      MeasureByStereo(Reference(), {Partner({0, 40}, 1.1), Partner({0, 45}, 1.1)}, HeightField());
  int in_lamp = 0;
  std::vector<float> elsewhere;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    const HeightCell& cell = field.cells[i];
    if (cell.sigma >= kMeasuredSigma) continue;
    const double off = field.Centre(i).cwiseAbs().maxCoeff();
    if (off < kLampPx) {
      ++in_lamp;
      EXPECT_NEAR(cell.rho, 1.1, 0.06) << i;
      EXPECT_GT(cell.sigma, 0.04) << i;
    } else if (off > 2 * kLampPx) {
      elsewhere.push_back(cell.sigma);
    }
  }
  EXPECT_GT(in_lamp, 10);
  ASSERT_GT(elsewhere.size(), 100U);
  std::sort(elsewhere.begin(), elsewhere.end());
  EXPECT_LT(elsewhere[elsewhere.size() / 2], 0.01);
}

TEST_F(Stereo, OfTwoPartnersTheMean) {
  const StereoReference reference = Reference();
  const HeightField field =
      MeasureByStereo(reference, {Partner({0, -31}, 1.103), Partner({31, 0}, 1.097)}, {});
  EXPECT_NEAR(MedianRho(field), 1.1, 0.002);
}

TEST_F(Stereo, NearThingsMayHaveLeftTheOtherImage) {
  // Walls beside the robot, known by a fisheye lens: over this travel they move by more than the
  // image is wide.
  HeightField known;
  known.cells.assign(50, {2.9F, 0.01F});
  known.cells.resize(100, {1.0F, 0.01F});
  const HeightField field =
      MeasureByStereo(Reference(), {Partner({0, 85}, 1.1), Partner({0, 90}, 1.1)}, known);
  EXPECT_NEAR(MedianRho(field), 1.1, 0.003);
}

TEST_F(Stereo, TwoPartnersThatDisagreeMeasureNothing) {
  const StereoReference reference = Reference();
  const HeightField field =
      MeasureByStereo(reference, {Partner({0, -31}, 1.0), Partner({31, 0}, 1.1)}, {});
  EXPECT_EQ(MedianRho(field), 0);
}

}  // namespace
}  // namespace ceilmap::heights
