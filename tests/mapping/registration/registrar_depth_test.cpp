#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "mapping/registration/registrar.hpp"
#include "tests/mapping/registration/synthetic_depth.hpp"

namespace ceilmap::registration {
namespace {

using heights::HeightField;
using synthetic::SyntheticDepth;

const cv::Size kDeckSize{640, 480};
constexpr double kNearRho = 1.35;

class RegistrarDepth : public testing::Test {
 protected:
  FrameSpectrum See(const ImageMotion& motion, std::uint32_t seed) {
    return registrar_.Analyze(ceiling_.Render(kDeckSize, motion, 1, seed));
  }
  static MotionPrior Near(ImageMotion motion) {
    motion.tx_px += 3;
    motion.theta_rad += 0.004;
    return {motion, 4, 0.1};
  }
  static double Error(const Registration& r, const ImageMotion& truth) {
    return std::hypot(r.motion.tx_px - truth.tx_px, r.motion.ty_px - truth.ty_px);
  }

  SyntheticDepth ceiling_{kNearRho};
  Registrar registrar_{kDeckSize};
};

TEST_F(RegistrarDepth, BlocksAreFoundWhereTheirHeightsPredictThem) {
  const ImageMotion truth{4, 30, 0.03};
  FrameSpectrum reference = See({}, 1);
  reference.SetHeights(registrar_.RegisterWithDepth(reference, See(truth, 2), Near(truth)).heights);
  ASSERT_NE(reference.Heights(), nullptr);
  // Farther away: by the plane alone, blocks of the strips would be looked for 20 px beside.
  const ImageMotion far{10, 60, 0.05};
  ImageMotion near = far;
  near.tx_px *= kNearRho;
  near.ty_px *= kNearRho;
  constexpr double kFocalPx = 640;  // without a camera; level motions do not depend on it
  const PlaneMotion motion = PlaneMotion::FromSimilarity({kFocalPx}, far);
  constexpr int kCount = 120;
  const auto places = registrar_.MeasureWithDepth(reference, See(far, 3), motion, kCount);
  EXPECT_LE(places.size(), static_cast<std::size_t>(kCount));
  int right = 0;
  int strips = 0;
  for (const PlaneShift& place : places) {
    const bool is_near = ceiling_.Cover(place.block.point) > 0.5;
    const ImageMotion& of_place = is_near ? near : far;
    if ((place.seen - of_place.Apply(place.block.point)).norm() > 0.5) continue;
    ++right;
    if (is_near) ++strips;
  }
  EXPECT_GT(right, static_cast<int>(places.size()) * 7 / 10);
  EXPECT_GT(strips, 15);
}

/// Errors of heights that grow towards the image's border look like a keystone.
TEST_F(RegistrarDepth, HeightsThatAreWrongAreNoTilt) {
  const ImageMotion truth{4, 50, 0.03};
  FrameSpectrum reference = See({}, 1);
  HeightField field =
      *registrar_.RegisterWithDepth(reference, See({4, 30, 0.03}, 2), Near({4, 30, 0.03})).heights;
  constexpr double kBorderError = 0.1;
  for (std::size_t i = 0; i < field.cells.size(); ++i) {
    const double off = field.Centre(i).y() / (kDeckSize.height / 2.0);
    field.cells[i].rho += static_cast<float>(kBorderError * off * off);
    field.cells[i].sigma = std::max(field.cells[i].sigma, 0.01F);
  }
  reference.SetHeights(std::make_shared<const HeightField>(std::move(field)));
  constexpr double kFocalPx = 640;
  const PlaneFit fit = registrar_.RefineWithDepth(
      reference, See(truth, 3), PlaneMotion::FromSimilarity({kFocalPx}, truth));
  ASSERT_TRUE(fit.ok);
  EXPECT_LT(std::hypot(fit.motion.tilt_x, fit.motion.tilt_y), 5e-4);
}

TEST_F(RegistrarDepth, OneImageShowsHeightsAndTheReferencePlane) {
  const ImageMotion truth{4, 30, 0.03};
  const FrameSpectrum reference = See({}, 1);
  const Registration found = registrar_.RegisterWithDepth(reference, See(truth, 2), Near(truth));
  ASSERT_TRUE(found.ok());
  ASSERT_TRUE(found.heights);
  EXPECT_LT(Error(found, truth), 0.6);
  EXPECT_NEAR(found.motion.theta_rad, truth.theta_rad, 1e-3);
  EXPECT_NEAR(found.heights->DepthRatio(), 0.45, 0.2);
  int right = 0;
  int wrong = 0;
  for (std::size_t i = 0; i < found.heights->cells.size(); ++i) {
    const heights::HeightCell& cell = found.heights->cells[i];
    const Eigen::Vector2d at = found.heights->Centre(i);
    bool inside = true;  // one height in all of the block
    for (const double side : {-18.0, 18.0}) {
      inside = inside && ceiling_.Cover(at + Eigen::Vector2d(side, 0)) == ceiling_.Cover(at);
    }
    if (!inside || cell.sigma > 0.03F) continue;
    const double rho = ceiling_.Cover(at) > 0 ? kNearRho : 1;
    (std::abs(cell.rho - rho) < 0.04 ? right : wrong) += 1;
  }
  EXPECT_GT(right, 60);
  EXPECT_LE(wrong, right / 20);
}

TEST_F(RegistrarDepth, KnownHeightsMakeTheMotionExact) {
  FrameSpectrum reference = See({}, 1);
  const ImageMotion first{2, 25, 0.01};
  const Registration found =
      registrar_.RegisterWithDepth(reference, See(first, 2), MotionPrior{{0, 20, 0}, 8, 0.1});
  ASSERT_TRUE(found.ok());
  auto scaled = std::make_shared<HeightField>(*found.heights);
  scaled->scale_sigma = 0.001;
  reference.SetHeights(scaled);
  const double scale = std::hypot(found.motion.tx_px, found.motion.ty_px) / std::hypot(2, 25);
  for (const ImageMotion& truth : {ImageMotion{-20, 50, 0.2}, ImageMotion{60, 45, -0.6}}) {
    const Registration next = registrar_.Register(reference, See(truth, 3), Near(truth));
    ASSERT_TRUE(next.ok());
    EXPECT_NEAR(next.motion.tx_px, scale * truth.tx_px, 0.25);
    EXPECT_NEAR(next.motion.ty_px, scale * truth.ty_px, 0.25);
    EXPECT_NEAR(next.motion.theta_rad, truth.theta_rad, 5e-4);
  }
}

// A prediction that is too far away for the blocks, and another start that is not.
TEST_F(RegistrarDepth, StartsFromASecondMotionToo) {
  const ImageMotion truth{4, 30, 0.03};
  const FrameSpectrum reference = See({}, 1);
  const FrameSpectrum current = See(truth, 2);
  const MotionPrior far{{0, -20, 0}, 8, 0.05};
  const Registration found =
      registrar_.RegisterWithDepth(reference, current, far, ImageMotion{6, 32, 0.027});
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found.ShowsDepth());
  EXPECT_TRUE(found.IsBestGuess());
  EXPECT_LT(Error(found, truth), 0.6);
  // The better of both is taken.
  const Registration other =
      registrar_.RegisterWithDepth(reference, current, Near(truth), ImageMotion{-40, 0, 0});
  ASSERT_TRUE(other.ok());
  EXPECT_LT(Error(other, truth), 0.6);
}

TEST_F(RegistrarDepth, OfOnePlaneShowsNoDepth) {
  const SyntheticDepth plane(kNearRho, 0);
  const ImageMotion truth{4, 30, 0.03};
  const Registration found =
      registrar_.RegisterWithDepth(registrar_.Analyze(plane.Render(kDeckSize, {}, 1, 1)),
                                   registrar_.Analyze(plane.Render(kDeckSize, truth, 1, 2)),
                                   Near(truth));
  ASSERT_TRUE(found.ok());
  EXPECT_GT(found.textured_inliers, 0.9);
  EXPECT_FALSE(found.ShowsDepth());
}

TEST_F(RegistrarDepth, OtherPlacesAreRefused) {
  const SyntheticDepth elsewhere(kNearRho, 0.45, 400);
  const FrameSpectrum reference = See({}, 1);
  const FrameSpectrum other = registrar_.Analyze(elsewhere.Render(kDeckSize, {}, 1, 5));
  EXPECT_FALSE(registrar_.RegisterWithDepth(reference, other).ok());
  for (int i = 0; i < 8; ++i) {
    const MotionPrior prior{{10.0 * i, -7.0 * i, 0.1 * i}, 4, 0.1};
    EXPECT_FALSE(registrar_.RegisterWithDepth(reference, other, prior).ok()) << i;
  }
}

TEST_F(RegistrarDepth, HeightsArePredictedForTheNextKeyframeAndRefined) {
  FrameSpectrum reference = See({}, 1);
  const ImageMotion first{2, 25, 0.01};
  const Registration start =
      registrar_.RegisterWithDepth(reference, See(first, 3), MotionPrior{{0, 20, 0}, 8, 0.1});
  ASSERT_TRUE(start.ok());
  reference.SetHeights(start.heights);
  const ImageMotion truth{5, 60, 0.05};
  const Registration found = registrar_.Register(reference, See(truth, 2), Near(truth));
  ASSERT_TRUE(found.ok());
  reference.SetHeights(found.heights);
  FrameSpectrum next = See(truth, 2);
  next.SetHeights(
      std::make_shared<HeightField>(registrar_.PredictHeights(reference, found.motion)));
  const auto measured = [](const HeightField& field) {
    int count = 0;
    for (const heights::HeightCell& cell : field.cells) count += cell.sigma < 0.02F ? 1 : 0;
    return count;
  };
  const HeightField refined = registrar_.RefineHeights(next, reference, found.motion.Inverse());
  EXPECT_GT(measured(refined), 1.2 * measured(*next.Heights()));
  EXPECT_GT(refined.DepthRatio(), 0.25);
}

// What the image before did not show, or too far away from the next one.
TEST_F(RegistrarDepth, UnknownHeightsAreFoundInAnImageThatIsFarAway) {
  FrameSpectrum reference = See({}, 1);
  reference.SetHeights(std::make_shared<HeightField>(registrar_.EmptyHeights()));
  const ImageMotion truth{5, 60, 0.05};
  const HeightField refined = registrar_.RefineHeights(reference, See(truth, 2), truth);
  int measured = 0;
  int right = 0;
  for (const heights::HeightCell& cell : refined.cells) {
    if (cell.sigma > heights::kMeasuredSigma) continue;
    ++measured;
    const double nearest = std::min(std::abs(cell.rho - 1.0), std::abs(cell.rho - kNearRho));
    right += nearest < 0.03 ? 1 : 0;
  }
  EXPECT_GT(measured, 0.6 * static_cast<double>(refined.cells.size()));
  EXPECT_GT(right, 0.85 * measured);
}

}  // namespace
}  // namespace ceilmap::registration
