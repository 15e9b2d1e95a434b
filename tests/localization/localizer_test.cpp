#include "localization/localizer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/localization/visitor.hpp"

namespace ceilmap::localization {
namespace {

using graph::TrackingStatus;
using synthetic::DistanceOf;
using synthetic::kRight_m;
using synthetic::kStep;
using synthetic::Seen;
using synthetic::SyntheticCeiling;
using synthetic::TrueMap;
using synthetic::UpCamera;
using synthetic::Visitor;

class LocalizerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() { delete map_; }
  static TrueMap* map_;
};
TrueMap* LocalizerTest::map_ = nullptr;

TEST_F(LocalizerTest, IsSwitchedOnAnywhereAndFollowed) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(1.2, 3.6);
  std::uniform_real_distribution<double> y(1.0, 3.0);
  std::uniform_real_distribution<double> yaw(-3.1, 3.1);
  Visitor visitor(*map_);
  for (int place = 0; place < 6; ++place) {
    SCOPED_TRACE(place);
    visitor.Get().Reset();
    Pose2 T{x(random), y(random), yaw(random)};
    Location location = visitor.Drive(T, kStep, 5);
    EXPECT_TRUE(location.Placed());
    for (int i = 0; i < 10; ++i) {
      location = visitor.Drive(T, kStep, 1);
      EXPECT_EQ(location.pose.status, TrackingStatus::kTracking);
      EXPECT_GT(location.peak, 0.4);
      EXPECT_GT(location.inliers, 10);
    }
  }
  const LocalizerReport& report = visitor.Get().Report();
  EXPECT_EQ(report.frames, 6 * 15);
  EXPECT_EQ(report.relocalized, 6);
  EXPECT_GE(report.tracking, 6 * 10);
  EXPECT_GE(report.searches, 6);
}

TEST_F(LocalizerTest, TheFirstAcceptedFrameHasItsOwnStatus) {
  Visitor visitor(*map_);
  Pose2 T{2, 2, 0};
  std::vector<TrackingStatus> seen;
  for (int i = 0; i < 6; ++i) seen.push_back(visitor.Drive(T, kStep, 1).pose.status);
  EXPECT_EQ(seen.front(), TrackingStatus::kAmbiguous);  // not confirmed yet
  EXPECT_EQ(std::count(seen.begin(), seen.end(), TrackingStatus::kRelocalized), 1);
  EXPECT_EQ(seen.back(), TrackingStatus::kTracking);
}

TEST_F(LocalizerTest, AStartPoseIsAcceptedAtOnce) {
  LocalizerParams params;
  PoseWithCovariance start{{2.1, 1.95, 0.45}};
  start.covariance.diagonal() << 0.04, 0.04, 0.01;
  params.start = start;
  Visitor visitor(*map_, UpCamera(250, 0.5), params);
  const Pose2 T{2, 2, 0.5};
  const Location location = visitor.Locate(T);
  EXPECT_TRUE(location.Placed());
  Visitor::ExpectRight(location, T);
}

TEST_F(LocalizerTest, AWrongStartIsGivenUp) {
  LocalizerParams params;
  PoseWithCovariance start{{4, 3.5, 0}};
  start.covariance.diagonal() << 1e-2, 1e-2, 1e-2;
  params.start = start;
  params.max_frames_at_start_prior = 4;
  params.speed_noise_when_lost_m_s = 0.1;
  Visitor visitor(*map_, UpCamera(250, 0.5), params);
  Pose2 T{0.8, 1, 2};
  EXPECT_FALSE(visitor.Drive(T, kStep, 4).Placed());
  EXPECT_TRUE(visitor.Drive(T, kStep, 8).Placed());
}

TEST_F(LocalizerTest, DarknessAndACoveredLensAreLostAndFoundAgain) {
  Visitor visitor(*map_);
  Pose2 T{1.5, 1.5, 0};
  visitor.Drive(T, kStep, 6);
  for (const int grey : {0, 128, 255}) {
    SCOPED_TRACE(grey);
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(visitor.Show(visitor.Uniform(grey)).pose.status, TrackingStatus::kLost);
    }
    T = T * Pose2{0.4, 0.1, 0.5};  // it went on meanwhile
    EXPECT_TRUE(visitor.Drive(T, kStep, 5).Placed());
  }
  EXPECT_GE(visitor.Get().Report().relocalized, 4);
}

TEST_F(LocalizerTest, IsFoundAgainAfterItWasCarriedAway) {
  Visitor visitor(*map_);
  for (const Pose2& at : {Pose2{1, 1, 0}, Pose2{3.5, 3, 2}, Pose2{0.8, 3.1, -2}}) {
    Pose2 T = at;
    visitor.IsCarriedAway();
    visitor.Drive(T, kStep, 5);
    EXPECT_TRUE(visitor.Drive(T, kStep, 2).Placed());
  }
}

TEST_F(LocalizerTest, TheRobotIsNotCarriedAwayWithinAMoment) {
  // A damaged stream may show another place without a flaw.
  Visitor visitor(*map_);
  Pose2 T{1, 1, 0};
  ASSERT_TRUE(visitor.Drive(T, kStep, 8).Placed());
  for (int i = 0; i < 8; ++i) {
    const Location location = visitor.Locate(Pose2{3.5, 3, 2});
    EXPECT_FALSE(location.Placed()) << i;
  }
}

TEST_F(LocalizerTest, OffTheMapItIsLost) {
  Visitor visitor(*map_);
  Pose2 T{4.0, 2, 0};
  visitor.Drive(T, {0.08, 0, 0}, 6);
  const Location outside = visitor.Drive(T, {0.1, 0, 0}, 40);
  EXPECT_EQ(outside.pose.status, TrackingStatus::kLost);
  T = {3.0, 2, 3};
  EXPECT_TRUE(visitor.Drive(T, {0.08, 0, 0}, 6).Placed());
}

TEST_F(LocalizerTest, LightAndAFifthOfTheCeilingMayChange) {
  synthetic::CeilingParams changed;
  changed.lamps = false;  // all of them are off
  const SyntheticCeiling other(changed);
  const calib::MountedCamera up = UpCamera(250, 0.5);
  const calib::CeilingView view(up, synthetic::kCeiling_m);
  Visitor visitor(*map_, up);
  Pose2 T{1.5, 1.2, 0};
  int placed = 0;
  constexpr int kFrames = 30;
  for (int i = 0; i < kFrames; ++i) {
    T = T * kStep;
    cv::Mat image = Seen(other, view, T, static_cast<std::uint32_t>(i) + 50);
    image.convertTo(image, CV_8U, i < 15 ? 0.6 : 1.2, i < 15 ? 5 : -20);  // and exposure
    // An object covers a fifth of the image, static in the image.
    image(cv::Rect(0, 0, 130, 118)).setTo(70);
    const Location location = visitor.Show(image);
    Visitor::ExpectRight(location, T);
    placed += location.Placed() ? 1 : 0;
  }
  EXPECT_GE(placed, kFrames - 4);
}

TEST_F(LocalizerTest, AnotherCeilingIsNeverAPose) {
  const calib::MountedCamera up = UpCamera(250, 0.5);
  const calib::CeilingView view(up, synthetic::kCeiling_m);
  for (std::uint32_t seed = 2; seed <= 5; ++seed) {
    const SyntheticCeiling elsewhere({.seed = seed});
    Visitor visitor(*map_, up);
    Pose2 T{1, 1, 0};
    for (int i = 0; i < 8; ++i) {
      T = T * kStep;
      EXPECT_FALSE(visitor.Show(Seen(elsewhere, view, T)).Placed()) << seed << " " << i;
    }
  }
}

TEST_F(LocalizerTest, HeadingsOfTheMapChooseAmongPlaces) {
  Visitor right(*map_, UpCamera(250, 0.5));
  Visitor wrong(*map_, UpCamera(250, 0.5));
  Pose2 T{2, 2, 0.5};
  bool found = false;
  for (int i = 0; i < 6; ++i) {
    T = T * kStep;
    const Location location =
        right.Locate(T, HeadingPrior{T.yaw + 0.02, 0.001, HeadingFrame::kMap});
    Visitor::ExpectRight(location, T);
    found = found || location.Placed();
    EXPECT_FALSE(wrong.Locate(T, HeadingPrior{T.yaw + 2, 0.001, HeadingFrame::kMap}).Placed());
  }
  EXPECT_TRUE(found);
}

TEST_F(LocalizerTest, MeasuresAWrongScaleOfTheRigOnce) {
  // The camera is 4 cm higher than in its rig: 2 % of the distance to the ceiling.
  const calib::MountedCamera truth = UpCamera(250, 0.54);
  const calib::CeilingView view(truth, synthetic::kCeiling_m);
  Visitor visitor(*map_, UpCamera(250, 0.5));
  Pose2 T{1.5, 1.5, 0};
  int placed = 0;
  double last_error = 1;
  for (int i = 0; i < 30; ++i) {
    T = T * kStep;
    const Location location =
        visitor.Show(Seen(map_->ceiling, view, T, static_cast<std::uint32_t>(i) + 9));
    if (!location.Placed()) continue;
    ++placed;
    last_error = DistanceOf(location.pose.T_map_base, T);
    EXPECT_LT(last_error, kRight_m);
  }
  EXPECT_GE(placed, 27);
  EXPECT_LT(last_error, 0.002);
  ASSERT_TRUE(visitor.Get().Report().scale);
  EXPECT_NEAR(*visitor.Get().Report().scale, 2.1 / 2.06, 0.001);
}

TEST_F(LocalizerTest, BadCallsAreRefused) {
  Visitor visitor(*map_);
  EXPECT_THROW(visitor.Show(cv::Mat(100, 100, CV_8UC1)), InputError);
  const cv::Mat image = visitor.Uniform(1);
  EXPECT_THROW(visitor.Get().Locate({image, 1, std::nan(""), {}}), InputError);
  (void)visitor.Get().Locate({image, 1, 50, {}});
  EXPECT_THROW(visitor.Get().Locate({image, 2, 50, {}}), InputError);
  EXPECT_THROW(visitor.Get().Locate({image, 2, 51, HeadingPrior{0, 0}}), InputError);
  (void)visitor.Get().Locate({image, 2, 51, {}});                        // nothing was harmed
  EXPECT_THROW(Localizer(*map_->map, UpCamera(250, 2.7)), InputError);   // above the ceiling
  EXPECT_THROW(Localizer(*map_->map, UpCamera(5000, 0.5)), InputError);  // another scale
}

TEST_F(LocalizerTest, AGapInTimeIsNotBridgedByOneMatch) {
  Visitor visitor(*map_);
  Pose2 T{1.5, 1.5, 0};
  EXPECT_TRUE(visitor.Drive(T, {0, 0, 0}, 12).Placed());
  // Ten seconds later it may be anywhere, even at an identical place: the place is confirmed
  // anew.
  const calib::CeilingView view(UpCamera(250, 0.5), synthetic::kCeiling_m);
  const Location later = visitor.Get().Locate({Seen(map_->ceiling, view, T), 100, 11.2, {}});
  EXPECT_EQ(later.pose.status, TrackingStatus::kAmbiguous);
}

TEST_F(LocalizerTest, AHeadingThatTheMotionExcludesIsNotUsed) {
  Visitor visitor(*map_, UpCamera(250, 0.5));
  Pose2 T{1.5, 1.5, 0.3};
  for (int i = 0; i < 20; ++i) {
    T = T * kStep;
    const double off = i > 8 && i % 3 == 0 ? 1.5 : 0;  // beside steel
    const Location location =
        visitor.Locate(T, HeadingPrior{T.yaw + off, 1e-4, HeadingFrame::kMap});
    Visitor::ExpectRight(location, T);
    EXPECT_TRUE(i <= 5 || location.Placed()) << i;
  }
}

TEST_F(LocalizerTest, AWrongZeroOfHeadingsIsForgotten) {
  LocalizerParams params;
  params.give_up_heading_after = 6;
  Visitor visitor(*map_, UpCamera(250, 0.5), params);
  Pose2 T{1.2, 1.2, 0};
  for (int i = 0; i < 6; ++i) {
    T = T * kStep;
    visitor.Locate(T, HeadingPrior{T.yaw, 1e-4});
  }
  T = Pose2{3, 2.5, 1};  // ... and the compass now counts from elsewhere
  visitor.IsCarriedAway();
  bool found = false;
  for (int i = 0; i < 14; ++i) {
    T = T * kStep;
    const Location location = visitor.Locate(T, HeadingPrior{T.yaw + 2, 1e-4});
    Visitor::ExpectRight(location, T);
    found = found || location.Placed();
  }
  EXPECT_TRUE(found);
}

TEST(LocalizerParams, AreChecked) {
  LocalizerParams params;
  params.min_overlap = 1.5;
  EXPECT_THROW(params.Validate(), InputError);
  params = {};
  params.hypotheses.confirmations = 0;
  EXPECT_THROW(params.Validate(), InputError);
}

}  // namespace
}  // namespace ceilmap::localization
