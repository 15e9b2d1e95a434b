#include "mapping/registration/local_features.hpp"

#include <gtest/gtest.h>

#include <random>

namespace ceilmap::registration {
namespace {

/// Keypoints of two heights in two images; every third match is wrong.
struct Pair {
  LocalFeatures reference;
  LocalFeatures current;
  FeatureHeights heights;
};

Pair MakePair(const ImageMotion& about_principal, const Eigen::Vector2d& principal) {
  Pair pair;
  pair.heights.principal_px = principal;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> part(-1, 1);
  std::uniform_int_distribution<int> byte(0, 255);
  constexpr int kCount = 60;
  pair.reference.size = pair.current.size = {320, 240};
  pair.reference.descriptors = cv::Mat(kCount, 128, CV_8UC1);
  for (int i = 0; i < kCount; ++i) {
    for (int k = 0; k < 128; ++k) {
      pair.reference.descriptors.at<unsigned char>(i, k) = static_cast<unsigned char>(byte(random));
    }
    const double rho = i % 2 == 0 ? 1 : 1.4;
    const Eigen::Vector2d at(150 * part(random), 110 * part(random));
    const Eigen::Vector2d shift(about_principal.tx_px, about_principal.ty_px);
    Eigen::Vector2d seen = about_principal.Apply(at - principal) + (rho - 1) * shift + principal;
    if (i % 3 == 0) seen = {150 * part(random), 110 * part(random)};
    pair.reference.keypoints.push_back({at, 0.2, 4});
    pair.current.keypoints.push_back({seen, 0.2 + about_principal.theta_rad, 4});
    pair.heights.rho.push_back(rho);
  }
  pair.current.descriptors = pair.reference.descriptors.clone();
  return pair;
}

TEST(LocalFeatures, HeightsMakeOneMotionOfAllMatches) {
  const Eigen::Vector2d principal(6, -4);
  const ImageMotion motion{30, -18, 0.5, 1};
  const Pair pair = MakePair(motion, principal);
  const auto found = MotionsOfFeatures(pair.reference, pair.current, false, pair.heights);
  ASSERT_FALSE(found.empty());
  EXPECT_GE(found.front().evidence.inliers, 40);
  EXPECT_NEAR(found.front().motion.theta_rad, 0.5, 1e-9);
  // At the principal point the plane moves by the shift alone.
  const Eigen::Vector2d moved = found.front().motion.Apply(principal) - principal;
  EXPECT_NEAR(moved.x(), 30, 1e-9);
  EXPECT_NEAR(moved.y(), -18, 1e-9);
}

TEST(LocalFeatures, WithoutHeightsOneOfTheHeightsDeterminesTheMotion) {
  const Pair pair = MakePair({30, -18, 0.5, 1}, Eigen::Vector2d::Zero());
  const auto found = MotionsOfFeatures(pair.reference, pair.current, false);
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found.front().evidence.inliers, 25);
}

}  // namespace
}  // namespace ceilmap::registration
