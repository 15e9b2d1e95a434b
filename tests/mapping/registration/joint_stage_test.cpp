// Registration of images with weak texture: plain ceilings whose structures are below the noise of
// a pixel.

#include "mapping/registration/joint_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

#include "calib/base/degrees.hpp"
#include "tests/mapping/registration/plain_ceiling.hpp"
#include "tests/mapping/registration/registrar_fixture.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::PlainCeiling;

constexpr double kPriorPx = 8;
constexpr double kPriorRad = kRadPerDeg;

/// A motion, and a prediction of it that is off by its own standard deviation.
struct Predicted {
  ImageMotion truth;
  MotionPrior prior;
};

/// The motion is one of `way_px` and at most 3 degrees.
Predicted PredictedMotion(std::uint32_t seed, double way_px = 40) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const double way = kPi * unit(random);
  const ImageMotion truth{
      way_px * std::cos(way), way_px * std::sin(way), 3 * kRadPerDeg * unit(random), 1};
  const double off = kPi * unit(random);
  const ImageMotion expected{truth.tx_px + kPriorPx * std::cos(off),
                             truth.ty_px + kPriorPx * std::sin(off),
                             truth.theta_rad + (seed % 2 == 0 ? -kPriorRad : kPriorRad),
                             1};
  return {truth, {expected, kPriorPx, kPriorRad}};
}

Eigen::Matrix3d CovarianceOf(const MotionPrior& prior) {
  const double variance = prior.sigma_px * prior.sigma_px;
  return Eigen::Vector3d(variance, variance, prior.sigma_theta_rad * prior.sigma_theta_rad)
      .asDiagonal();
}

class JointRegistration : public testing::Test {
 protected:
  struct Pair {
    FrameSpectrum reference;
    FrameSpectrum current;
  };
  Pair See(const cv::Mat& reference, const cv::Mat& current) {
    return {registrar_.Analyze(reference), registrar_.Analyze(current)};
  }
  Pair SeePlain(const PlainCeiling& ceiling,
                const ImageMotion& motion,
                double noise,
                std::uint32_t seed) {
    return See(ceiling.Render(kSize, {}, noise, 2 * seed),
               ceiling.Render(kSize, motion, noise, 2 * seed + 1));
  }

  Registrar registrar_{kSize};
};

/// Structures of twice the noise, and the noise.
PlainCeiling WeakCeiling(std::uint32_t seed, double noise) {
  return PlainCeiling({.seed = seed, .edge_grey = 2 * noise, .disc_grey = 2.4 * noise});
}

TEST_F(JointRegistration, FindsWhatNoBlockShowsAlone) {
  constexpr std::uint32_t kSeeds = 6;
  double sum_deg = 0;
  int found = 0;
  for (const double noise : {3.0, 4.5, 6.0}) {
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
      const std::string which = "noise " + std::to_string(noise) + ", " + std::to_string(seed);
      const Predicted motion = PredictedMotion(seed);
      const Pair pair = SeePlain(WeakCeiling(seed, noise), motion.truth, noise, seed);
      EXPECT_EQ(registrar_.Register(pair.reference, pair.current).verdict, Verdict::kNoMatch)
          << which;
      const Registration joint =
          registrar_.RegisterJointly(pair.reference, pair.current, motion.prior);
      ASSERT_TRUE(joint.ok()) << which << ": " << ToString(joint.verdict);
      const Eigen::Vector3d off(joint.motion.tx_px - motion.truth.tx_px,
                                joint.motion.ty_px - motion.truth.ty_px,
                                joint.motion.theta_rad - motion.truth.theta_rad);
      EXPECT_LT(off.head<2>().norm(), 2) << which;
      EXPECT_LT(std::abs(off.z()), 0.5 * kRadPerDeg) << which;
      EXPECT_EQ(joint.motion.scale, 1) << which;
      const Eigen::Matrix3d covariance = joint.covariance.topLeftCorner<3, 3>();
      EXPECT_LT(off.dot(covariance.inverse() * off), 16) << which << ": four sigmas";
      EXPECT_GT(joint.peak, joint.runner_up) << which;
      EXPECT_GT(joint.overlap, 0.8) << which;
      EXPECT_GT(joint.inliers, joint.blocks / 4) << which;
      sum_deg += std::abs(off.z()) / kRadPerDeg;
      ++found;
    }
  }
  EXPECT_LT(sum_deg / found, 0.25) << "of a degree by which the prior is off";
}

TEST_F(JointRegistration, FindsItInBothDirectionsAlike) {
  const Predicted motion = PredictedMotion(4);
  const Pair pair = SeePlain(WeakCeiling(4, 3), motion.truth, 3, 4);
  const MotionPrior back{motion.prior.motion.Inverse(), kPriorPx, kPriorRad};
  const Registration there = registrar_.RegisterJointly(pair.reference, pair.current, motion.prior);
  const Registration again = registrar_.RegisterJointly(pair.current, pair.reference, back);
  ASSERT_TRUE(there.ok() && again.ok());
  const ImageMotion loop = Compose(again.motion, there.motion);
  EXPECT_LT(std::hypot(loop.tx_px, loop.ty_px), 1);
  EXPECT_LT(std::abs(loop.theta_rad), 0.3 * kRadPerDeg);
}

TEST_F(JointRegistration, NothingInCommonIsNeverAccepted) {
  constexpr std::uint32_t kPairs = 20;
  const auto plaster = [](std::uint32_t seed) {
    return SyntheticCeiling({.seed = seed, .tile_px = 0});
  };
  for (std::uint32_t i = 1; i <= kPairs; ++i) {
    const Predicted motion = PredictedMotion(i);
    const auto expect_refused = [&](const cv::Mat& here, const cv::Mat& there, const char* what) {
      const Pair pair = See(here, there);
      const Registration joint =
          registrar_.RegisterJointly(pair.reference, pair.current, motion.prior);
      EXPECT_FALSE(joint.ok()) << what << " " << i << ", peak " << joint.peak << ", runner-up "
                               << joint.runner_up;
    };
    const PlainCeiling nothing({.edge_grey = 0, .disc_grey = 0});
    expect_refused(nothing.Render(kSize, {}, 4, 2 * i),
                   nothing.Render(kSize, motion.truth, 4, 2 * i + 1),
                   "noise");
    expect_refused(WeakCeiling(i, 4).Render(kSize, {}, 4, 2 * i),
                   WeakCeiling(i + 100, 4).Render(kSize, motion.truth, 4, 2 * i + 1),
                   "plain");
    expect_refused(plaster(i).Render(kSize, {}, 2, 2 * i),
                   plaster(i + 500).Render(kSize, motion.truth, 2, 2 * i + 1),
                   "plaster");
  }
}

TEST_F(JointRegistration, ImagesThatCannotBeComparedDoNotMatch) {
  const cv::Mat grey(kSize, CV_8UC1, cv::Scalar(128));
  const Pair flat = See(grey, grey);
  EXPECT_EQ(registrar_.RegisterJointly(flat.reference, flat.current, {{}, 8, 0.02}).verdict,
            Verdict::kNoMatch);
  const Pair plain = SeePlain(WeakCeiling(1, 3), {}, 3, 1);
  const ImageMotion outside{630, 0, 0, 1};
  EXPECT_EQ(registrar_.RegisterJointly(plain.reference, plain.current, {outside, 8, 0.02}).verdict,
            Verdict::kNoMatch);
  const MotionPrior prior{outside, kPriorPx, kPriorRad};
  const Registration corrected =
      registrar_.CorrectJointly(plain.reference, plain.current, outside, CovarianceOf(prior));
  EXPECT_EQ(corrected.verdict, Verdict::kNoMatch);
}

/// The errors of edges alone, along and across them.
struct EdgeErrors {
  int accepted = 0;
  double across_px = 0;      ///< largest error
  double along_squared = 0;  ///< sum, in standard deviations
};

EdgeErrors RegisterEdges(Registrar& registrar, std::uint32_t edges) {
  EdgeErrors errors;
  for (std::uint32_t seed = 1; seed <= edges; ++seed) {
    const PlainCeiling edge({.seed = seed, .edge_grey = 6, .disc_grey = 0});
    // The unknown height makes the covariance larger in the direction of a long way.
    const Predicted motion = PredictedMotion(seed, 5);
    const Registration joint = registrar.RegisterJointly(
        registrar.Analyze(edge.Render(kSize, {}, 3, 2 * seed)),
        registrar.Analyze(edge.Render(kSize, motion.truth, 3, 2 * seed + 1)),
        motion.prior);
    if (!joint.ok()) continue;
    ++errors.accepted;
    const Eigen::Vector2d along = Eigen::Rotation2Dd(motion.truth.theta_rad) * edge.AlongEdge();
    const Eigen::Vector2d across(along.y(), -along.x());
    const Eigen::Matrix2d covariance = joint.covariance.topLeftCorner<2, 2>();
    const Eigen::Vector2d off(joint.motion.tx_px - motion.truth.tx_px,
                              joint.motion.ty_px - motion.truth.ty_px);
    const double along_px = std::sqrt(along.dot(covariance * along));
    errors.across_px = std::max(errors.across_px, std::abs(off.dot(across)));
    errors.along_squared += off.dot(along) * off.dot(along) / (along_px * along_px);
  }
  return errors;
}

TEST_F(JointRegistration, AnEdgeDeterminesTheMotionAcrossIt) {
  const EdgeErrors errors = RegisterEdges(registrar_, 12);
  EXPECT_LT(errors.across_px, 2);
}

TEST_F(JointRegistration, AnEdgeAloneClaimsNoMoreThanItKnows) {
  const EdgeErrors errors = RegisterEdges(registrar_, 24);
  EXPECT_GT(errors.accepted, 0);
  EXPECT_LT(errors.along_squared / std::max(errors.accepted, 1), 2);
}

TEST_F(JointRegistration, NoiseLeavesTheExpectationAsItIs) {
  const PlainCeiling nothing({.edge_grey = 0, .disc_grey = 0});
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const MotionPrior prior = PredictedMotion(i).prior;
    const Pair pair = SeePlain(nothing, {}, 4, i);
    const Registration corrected =
        registrar_.CorrectJointly(pair.reference, pair.current, prior.motion, CovarianceOf(prior));
    ASSERT_TRUE(corrected.ok()) << i;
    EXPECT_LT(ShiftError(corrected.motion, prior.motion), 0.1 * kPriorPx) << i;
    EXPECT_LT(AngleErrorDeg(corrected.motion, prior.motion), 0.1) << i;
    for (const int axis : {0, 1}) {
      EXPECT_NEAR(std::sqrt(corrected.covariance(axis, axis)) / kPriorPx, 1, 0.1) << i;
    }
    EXPECT_NEAR(std::sqrt(corrected.covariance(2, 2)) / kPriorRad, 1, 0.1) << i;
  }
}

TEST_F(JointRegistration, AVeryWideExpectationIsNotNarrowed) {
  // The right motion may lie outside of what is searched.
  const Predicted motion = PredictedMotion(2);
  const Pair pair = SeePlain(WeakCeiling(2, 4), motion.truth, 4, 2);
  for (const double sigma_px : {150.0, 1e8}) {
    const MotionPrior wide{motion.prior.motion, sigma_px, kPriorRad};
    const Registration corrected =
        registrar_.CorrectJointly(pair.reference, pair.current, wide.motion, CovarianceOf(wide));
    ASSERT_TRUE(corrected.ok());
    EXPECT_EQ(corrected.covariance(0, 0), CovarianceOf(wide)(0, 0));
    EXPECT_EQ(corrected.inliers, 0);
  }
}

TEST_F(JointRegistration, AWideExpectationIsSearchedWhole) {
  // Further than one lattice reaches, across and in its rotation.
  constexpr double kWidePx = 40;
  constexpr double kWideRad = 0.1;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const Predicted motion = PredictedMotion(seed);
    const synthetic::SyntheticCeiling ceiling({.seed = seed});
    const Pair pair =
        See(ceiling.Render(kSize, {}, 2, 2 * seed), ceiling.Render(kSize, motion.truth, 2, seed));
    MotionPrior wide{motion.truth, kWidePx, kWideRad};
    wide.motion.tx_px += 1.6 * kWidePx;
    wide.motion.theta_rad -= 1.5 * kWideRad;
    const Registration corrected =
        registrar_.CorrectJointly(pair.reference, pair.current, wide.motion, CovarianceOf(wide));
    ASSERT_TRUE(corrected.ok()) << seed;
    EXPECT_GT(corrected.peak, 2 * corrected.runner_up) << seed;
    EXPECT_LT(ShiftError(corrected.motion, motion.truth), 5) << seed;
    EXPECT_LT(AngleErrorDeg(corrected.motion, motion.truth), 1) << seed;
    EXPECT_LT(std::sqrt(corrected.covariance(0, 0)), 0.6 * kWidePx) << seed;
  }
}

TEST_F(JointRegistration, APlainCeilingCorrectsTheExpectation) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const Predicted motion = PredictedMotion(seed);
    const Pair pair = SeePlain(WeakCeiling(seed, 4), motion.truth, 4, seed);
    const Registration corrected = registrar_.CorrectJointly(
        pair.reference, pair.current, motion.prior.motion, CovarianceOf(motion.prior));
    ASSERT_TRUE(corrected.ok()) << seed;
    EXPECT_LT(ShiftError(corrected.motion, motion.truth), 0.5 * kPriorPx) << seed;
    EXPECT_LT(AngleErrorDeg(corrected.motion, motion.truth), 0.85) << seed;
    for (const int axis : {0, 1}) {
      EXPECT_LT(std::sqrt(corrected.covariance(axis, axis)), 0.6 * kPriorPx) << seed;
    }
    EXPECT_LT(std::sqrt(corrected.covariance(2, 2)), 0.85 * kPriorRad) << seed;
  }
}

TEST_F(JointRegistration, OtherLightMayMakeDarkOfBright) {
  // Between recordings lamps are switched, and edges lit from their other side.
  RegistrarParams params;
  params.same_recording = false;
  Registrar between_recordings(kSize, params);
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const Predicted motion = PredictedMotion(seed);
    const PlainCeiling ceiling = WeakCeiling(seed, 5);
    const cv::Mat by_day = ceiling.Render(kSize, {}, 3, 2 * seed);
    const cv::Mat by_night = 255 - ceiling.Render(kSize, motion.truth, 3, 2 * seed + 1);
    const auto correct = [&](Registrar& registrar) {
      return registrar.CorrectJointly(registrar.Analyze(by_day),
                                      registrar.Analyze(by_night),
                                      motion.prior.motion,
                                      CovarianceOf(motion.prior));
    };
    const Registration corrected = correct(between_recordings);
    ASSERT_TRUE(corrected.ok()) << seed;
    EXPECT_LT(ShiftError(corrected.motion, motion.truth), 0.4 * kPriorPx) << seed;
    EXPECT_GT(corrected.inliers, corrected.blocks / 4) << seed;
    const Registration same_light = correct(registrar_);
    EXPECT_GT(ShiftError(same_light.motion, motion.truth), 0.7 * kPriorPx) << seed;
  }
}

// Many blocks show the same lamp, beside the middle of the image. Turned about itself it looks the
// same.
TEST_F(JointRegistration, ARoundLampTellsNoRotation) {
  const auto lamp = [](const Eigen::Vector2d& at, std::uint32_t seed) {
    cv::Mat image(kSize, CV_32FC1);
    cv::RNG random(seed);
    random.fill(image, cv::RNG::NORMAL, 60, 3);
    const cv::Point centre(cvRound(at.x() + 0.5 * kSize.width),
                           cvRound(at.y() + 0.5 * kSize.height));
    cv::circle(image, centre, 60, cv::Scalar(230), cv::FILLED, cv::LINE_AA);
    cv::GaussianBlur(image, image, {}, 1.5);
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  };
  const Eigen::Vector2d at(70, -50);
  // Noise alone narrows or widens a posterior: of one pair it is 0.55 to 0.9 of the expected one.
  constexpr std::uint32_t kPairs = 5;
  for (const double off_deg : {-6, -2, 2, 6}) {
    // Turned about the lamp.
    const double off_rad = off_deg * kRadPerDeg;
    const double sigma_rad = std::abs(off_rad);
    const Eigen::Vector2d shift = at - Eigen::Rotation2Dd(off_rad) * at;
    const ImageMotion expected{shift.x(), shift.y(), off_rad, 1};
    double sum_rad = 0;
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      const Pair pair = See(lamp(at, 2 * i + 3), lamp(at, 2 * i + 4));
      const Registration corrected =
          registrar_.CorrectJointly(pair.reference,
                                    pair.current,
                                    expected,
                                    CovarianceOf({expected, 3 * kPriorPx, sigma_rad}));
      ASSERT_TRUE(corrected.ok());
      sum_rad += std::sqrt(corrected.covariance(2, 2));
      const Eigen::Vector2d seen = corrected.motion.Apply(at);
      EXPECT_LT((seen - at).norm(), 3) << off_deg;
    }
    EXPECT_GT(sum_rad / kPairs, (std::abs(off_deg) > 2 ? 0.5 : 0.65) * sigma_rad) << off_deg;
  }
}

// Blocks at the border leave the image under the turn that they tell.
TEST_F(JointRegistration, AnEdgeAtTheBorderTellsTheTurnBesideALamp) {
  const auto room = [](double turn_rad, std::uint32_t seed) {
    const auto turned = [&](double x, double y) {
      const Eigen::Vector2d at = Eigen::Rotation2Dd(turn_rad) * Eigen::Vector2d(x, y);
      return cv::Point(cvRound(at.x() + 0.5 * kSize.width), cvRound(at.y() + 0.5 * kSize.height));
    };
    cv::Mat image(kSize, CV_32FC1);
    cv::RNG random(seed);
    random.fill(image, cv::RNG::NORMAL, 60, 3);
    const std::vector<cv::Point> lower = {turned(600, -230), turned(0, 370), turned(600, 370)};
    cv::Mat step(kSize, CV_32FC1, cv::Scalar(0));
    cv::fillConvexPoly(step, lower, cv::Scalar(12), cv::LINE_AA);
    image += step;
    cv::circle(image, turned(-60, -70), 60, cv::Scalar(230), cv::FILLED, cv::LINE_AA);
    cv::GaussianBlur(image, image, {}, 1.5);
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  };
  for (const double turn_deg : {-3.4, 3.4}) {
    const double turn_rad = turn_deg * kRadPerDeg;
    const Pair pair = See(room(0, 5), room(turn_rad, 6));
    const Registration corrected = registrar_.CorrectJointly(
        pair.reference, pair.current, {}, CovarianceOf({{}, 2, 0.5 * turn_rad}));
    ASSERT_TRUE(corrected.ok());
    EXPECT_NEAR(corrected.motion.theta_rad, turn_rad, 0.48 * std::abs(turn_rad)) << turn_deg;
  }
}

TEST_F(JointRegistration, AnEdgeCorrectsTheExpectationAcrossIt) {
  constexpr std::uint32_t kEdges = 12;
  double across_px = 0;
  double along_squared = 0;
  double along_sum = 0;
  double across_sum = 0;
  for (std::uint32_t seed = 1; seed <= kEdges; ++seed) {
    const PlainCeiling edge({.seed = seed, .edge_grey = 9, .disc_grey = 0});
    const Predicted motion = PredictedMotion(seed, 5);
    const Pair pair = SeePlain(edge, motion.truth, 3, seed);
    const Registration corrected = registrar_.CorrectJointly(
        pair.reference, pair.current, motion.prior.motion, CovarianceOf(motion.prior));
    ASSERT_TRUE(corrected.ok()) << seed;
    const Eigen::Vector2d along = Eigen::Rotation2Dd(motion.truth.theta_rad) * edge.AlongEdge();
    const Eigen::Vector2d across(along.y(), -along.x());
    const Eigen::Matrix2d covariance = corrected.covariance.topLeftCorner<2, 2>();
    const Eigen::Vector2d off(corrected.motion.tx_px - motion.truth.tx_px,
                              corrected.motion.ty_px - motion.truth.ty_px);
    const double along_variance = along.dot(covariance * along);
    along_sum += along_variance;
    across_sum += across.dot(covariance * across);
    across_px += std::abs(off.dot(across)) / kEdges;
    along_squared += off.dot(along) * off.dot(along) / along_variance / kEdges;
  }
  EXPECT_LT(across_px, 0.25 * kPriorPx);
  EXPECT_LT(along_squared, 4) << "in standard deviations";
  EXPECT_GT(along_sum, 1.2 * across_sum);
}

TEST_F(JointRegistration, HeightsScaleTheTravel) {
  constexpr double kRho = 1.15;
  auto heights = std::make_shared<heights::HeightField>(registrar_.EmptyHeights());
  for (heights::HeightCell& cell : heights->cells) cell = {static_cast<float>(kRho), 0.01F};
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Predicted motion = PredictedMotion(seed);
    ImageMotion seen = motion.truth;  // what is lower moves further
    seen.tx_px *= kRho;
    seen.ty_px *= kRho;
    Pair pair = SeePlain(WeakCeiling(seed, 3), seen, 3, seed);
    const Registration plane =
        registrar_.RegisterJointly(pair.reference, pair.current, motion.prior);
    ASSERT_TRUE(plane.ok()) << seed;
    EXPECT_LT(ShiftError(plane.motion, seen), 2) << seed;
    pair.reference.SetHeights(heights);
    const Registration deep =
        registrar_.RegisterJointly(pair.reference, pair.current, motion.prior);
    ASSERT_TRUE(deep.ok()) << seed;
    EXPECT_LT(ShiftError(deep.motion, motion.truth), 2) << seed;
  }
}

}  // namespace
}  // namespace ceilmap::registration
