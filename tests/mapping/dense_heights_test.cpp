// Dense stereo, on the synthetic ceiling with depth of the registration tests.

#include "mapping/heights/stereo.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/mapping/registration/synthetic_depth.hpp"

namespace ceilmap::heights {
namespace {

using registration::ImageMotion;
using registration::synthetic::SyntheticDepth;

const cv::Size kImage{640, 480};
constexpr double kStrips = 1.35;

class Stereo : public testing::Test {
 protected:
  Stereo() {
    blocks_.grid = {2, 1};
    blocks_.cells = {{1.0F, 0.01F}, {static_cast<float>(kStrips), 0.01F}};
  }
  [[nodiscard]] StereoPartner Partner(const ImageMotion& motion, std::uint32_t seed) const {
    return {ForStereo(ceiling_.Render(kImage, motion, 1, seed)),
            motion.theta_rad,
            {motion.tx_px, motion.ty_px}};
  }
  [[nodiscard]] StereoReference Reference() const {
    return {ForStereo(ceiling_.Render(kImage, {}, 1, 1)), kImage, {}, Eigen::Vector2d::Zero()};
  }
  /// Cells at least this far from a border of a strip, by the error of their ratio.
  struct Count {
    int right = 0;
    int wrong = 0;
    int unknown = 0;
  };
  [[nodiscard]] Count Check(const HeightField& field, double from_border_px) const {
    Count count;
    for (std::size_t i = 0; i < field.cells.size(); ++i) {
      const Eigen::Vector2d at = field.Centre(i);
      const double cover = ceiling_.Cover(at);
      if (ceiling_.Cover(at + Eigen::Vector2d(from_border_px, 0)) != cover ||
          ceiling_.Cover(at - Eigen::Vector2d(from_border_px, 0)) != cover) {
        continue;
      }
      const double rho = cover > 0 ? kStrips : 1;
      if (field.cells[i].sigma >= kMeasuredSigma) {
        ++count.unknown;
      } else if (std::abs(field.cells[i].rho / rho - 1) < 0.015) {
        ++count.right;
      } else {
        ++count.wrong;
      }
    }
    return count;
  }

  SyntheticDepth ceiling_{kStrips};
  HeightField blocks_;
};

TEST_F(Stereo, FollowsTheEdgesOfWhatHangsBelow) {
  const HeightField field = MeasureByStereo(
      Reference(),
      {Partner({70, 12, 0.02}, 2), Partner({-60, -25, 0.4}, 3), Partner({15, 65, -0.1}, 4)},
      blocks_);
  EXPECT_EQ(field.step_px.x(), kStereoStepPx);
  const Count count = Check(field, 12);
  EXPECT_GT(count.right, 1500);
  EXPECT_LT(count.wrong, 0.03 * count.right);
  // What is seen by one partner only is not known.
  EXPECT_LT(count.unknown, 0.6 * count.right);
}

TEST_F(Stereo, OnePartnerSufficesWithLessCertainty) {
  const HeightField field = MeasureByStereo(Reference(), {Partner({70, 12, 0.02}, 2)}, blocks_);
  const Count count = Check(field, 16);
  EXPECT_GT(count.right, 1500);
  EXPECT_LT(count.wrong, 0.08 * count.right);
  for (const HeightCell& cell : field.cells) EXPECT_GE(cell.sigma, 0.02F);
}

TEST_F(Stereo, AMaskedPartOfTheImageIsNotKnown) {
  StereoReference reference = Reference();
  reference.mask = cv::Mat(kImage, CV_8UC1, cv::Scalar(255));
  reference.mask(cv::Rect(0, 0, 640, 240)).setTo(0);
  const HeightField field = MeasureByStereo(reference, {Partner({70, 12, 0.02}, 2)}, blocks_);
  int measured = 0;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    if (field.cells[i].sigma >= kMeasuredSigma) continue;
    EXPECT_GT(field.Centre(i).y(), -4);
    ++measured;
  }
  EXPECT_GT(measured, 700);
}

}  // namespace
}  // namespace ceilmap::heights
