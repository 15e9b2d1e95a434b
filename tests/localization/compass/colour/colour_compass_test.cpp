#include "localization/compass/colour/colour_compass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"
#include "tests/localization/compass/colour/coloured_room.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

constexpr int kTurnFrames = 90;

/// Pose of base on a turn about an axle `a` behind it that stands at a place.
Pose2 OnTurn(const Eigen::Vector2d& axle, double yaw, double a) {
  return {axle.x() + a * std::cos(yaw), axle.y() + a * std::sin(yaw), WrapAngle(yaw)};
}

class ColourCompassTest : public testing::Test {
 protected:
  ColourModel Learn(LearnParams params = {}, double axle_behind_m = 0) const {
    params.camera_ahead_of_axle_m = axle_behind_m;
    ColourLearner learner(forward_, params);
    for (int i = 0; i < kTurnFrames; ++i) {
      const Pose2 pose = OnTurn({0, 0}, 2 * pi * i / kTurnFrames, axle_behind_m);
      EXPECT_TRUE(learner.Add(room_.Render(forward_, pose), 0.1 * i, {pose}));
    }
    return learner.Finish();
  }

  /// A turn at another place in other light: largest error after the first frames, rad.
  double WorstError(ColourCompass& compass,
                    const Eigen::Vector2d& axle,
                    int first = 15,
                    bool honest = true,
                    double light = 0.9) const {
    double worst = 0;
    for (int i = 0; i < kTurnFrames; ++i) {
      const Pose2 pose = OnTurn(axle, 0.7 + 2 * pi * i / kTurnFrames, 0);
      const auto heading = compass.Next({room_.Render(forward_, pose, light), 100 + 0.1 * i});
      const double error = std::abs(WrapAngle(heading.value().heading_rad - pose.yaw));
      if (honest) {
        EXPECT_LT(error, 4 * std::sqrt(heading->variance_rad2) + 0.02) << "accepted, frame " << i;
      }
      if (i >= first) worst = std::max(worst, error);
    }
    return worst;
  }

  ColouredRoom room_;
  calib::MountedCamera forward_ = ForwardCamera();
};

TEST_F(ColourCompassTest, FindsTheHeadingAtLearnedPlaces) {
  ColourCompass compass(Learn(), forward_);
  EXPECT_LT(WorstError(compass, {0, 0}), 0.05);
  EXPECT_EQ(compass.Counts().used, kTurnFrames);
  EXPECT_EQ(compass.Counts().without_turn, 0);
}

TEST_F(ColourCompassTest, OtherLightDoesNotMatter) {
  const ColourModel model = Learn();
  for (const double light : {0.78, 1.25}) {
    ColourCompass compass(model, forward_);
    EXPECT_LT(WorstError(compass, {0, 0}, 15, true, light), 0.05) << light;
    ColourCompass same(model, forward_, {.exposure_sigma = 0});
    WorstError(same, {0, 0}, 15, false, light);
    const Pose2 next = OnTurn({0, 0}, 0.7, 0);
    const auto heading = compass.Next({room_.Render(forward_, next, light), 109});
    const auto without = same.Next({room_.Render(forward_, next, light), 109});
    EXPECT_GT(heading->confidence, 0.9);
    EXPECT_LT(without->confidence, heading->confidence) << "exposure counts here at all";
  }
}

TEST_F(ColourCompassTest, AnotherRoomIsNotRecognized) {
  const ColouredRoom other(9);
  ColourCompass compass(Learn(), forward_);
  for (int i = 0; i < kTurnFrames; ++i) {
    const Pose2 pose = OnTurn({0, 0}, 2 * pi * i / kTurnFrames, 0);
    const auto heading = compass.Next({other.Render(forward_, pose), 0.1 * i});
    if (i > 15) {
      EXPECT_LT(heading->confidence, 0.9) << i;
    }
  }
  // Back at the learned place, the confidence is high again.
  std::optional<ColourHeading> heading;
  for (int i = 0; i < 30; ++i) {
    const Pose2 pose = OnTurn({0, 0}, 1 + 2 * pi * i / kTurnFrames, 0);
    heading = compass.Next({room_.Render(forward_, pose), 100 + 0.1 * i});
  }
  EXPECT_GT(heading->confidence, 0.9);
}

TEST_F(ColourCompassTest, AsSturmAndVisserHaveIt) {
  ColourCompass compass(Learn({.kind = ModelKind::kSturm}), forward_);
  double worst = 0;
  for (int i = 0; i < kTurnFrames; ++i) {
    const Pose2 pose = OnTurn({0, 0}, 0.7 + 2 * pi * i / kTurnFrames, 0);
    const auto heading = compass.Next({room_.Render(forward_, pose), 100 + 0.1 * i});
    if (i > 5) worst = std::max(worst, std::abs(WrapAngle(heading->heading_rad - pose.yaw)));
  }
  EXPECT_LT(worst, 0.05);
}

TEST_F(ColourCompassTest, FindsOutThatItIsElsewhere) {
  ColourModel model = Learn();
  model.depth_m = room_.Radius();
  const Eigen::Vector2d elsewhere(1.2, -0.8);
  ColourCompass compass(model, forward_);
  EXPECT_LT(WorstError(compass, elsewhere, 45), 0.12);
  ColourCompass published(model, forward_, {.parallax = false});
  EXPECT_GT(WorstError(published, elsewhere, 45, false), 0.2) << "all things infinitely far";
}

TEST_F(ColourCompassTest, APlaceThatIsGivenIsTaken) {
  ColourModel model = Learn();
  model.depth_m = room_.Radius();
  ColourCompass compass(model, forward_);
  const PlaceHypothesis places[] = {{{1.2, -0.8}, 3}};
  for (int i = 0; i < 20; ++i) {
    const Pose2 pose{1.2, -0.8, 0.3 + 0.05 * i};
    const auto heading = compass.Next({room_.Render(forward_, pose), 0.1 * i, {}, places});
    if (i > 3) {
      EXPECT_NEAR(WrapAngle(heading->heading_rad - pose.yaw), 0, 0.06) << i;
    }
  }
}

// A localizer that does not know on which side of the room the robot is: the frames decide. From
// the other place alone the heading would differ by the parallax.
TEST_F(ColourCompassTest, OfTwoPlacesTheOneThatFitsCounts) {
  ColourModel model = Learn();
  model.depth_m = room_.Radius();
  ColourCompass compass(model, forward_);
  const PlaceHypothesis places[] = {{{1.2, -0.8}, 1}, {{-1.2, 0.8}, 1}};
  for (int i = 0; i < 20; ++i) {
    const Pose2 pose{1.2, -0.8, 0.3 + 0.05 * i};
    const auto heading = compass.Next({room_.Render(forward_, pose), 0.1 * i, {}, places});
    if (i > 10) {
      EXPECT_NEAR(WrapAngle(heading->heading_rad - pose.yaw), 0, 0.1) << i;
    }
  }
}

// A hypothesis in a cell with less than a fifth of the weight is not asked: it changes nothing.
TEST_F(ColourCompassTest, APlaceOfLittleWeightIsNotAsked) {
  ColourCompass compass(Learn(), forward_);
  compass.Next({room_.Render(forward_, {2.4, 1.3, 0.5}), 1});
  compass.Learn({{2.4, 1.3, 0.5}});  // a second cell
  ColourCompass alone(compass.Model(), forward_);
  ColourCompass both(compass.Model(), forward_);
  const PlaceHypothesis one[] = {{{0, 0}, 1}};
  const PlaceHypothesis two[] = {{{0, 0}, 9}, {{2.4, 1.3}, 1}};
  const PlaceHypothesis equal[] = {{{0, 0}, 1}, {{2.4, 1.3}, 1}};
  const cv::Mat image = room_.Render(forward_, {0, 0, 0.7});
  const double expected = alone.Next({image, 10, {}, one})->variance_rad2;
  EXPECT_NEAR(both.Next({image, 10, {}, two})->heading_rad,
              ColourCompass(compass.Model(), forward_).Next({image, 10, {}, one})->heading_rad,
              1e-4);
  both.Reset();
  EXPECT_GT(both.Next({image, 11, {}, equal})->variance_rad2, expected + 1e-4) << "a half is";
}

TEST_F(ColourCompassTest, ColoursAreClassifiedAsInThePaperOfTheMethod) {
  // Number of classes with a covariance: those of a mixture of Gaussians.
  const auto gaussians = [this](ModelKind kind, Clustering clustering = Clustering::kOfMethod) {
    LearnParams params{.kind = kind};
    params.classes.clustering = clustering;
    ColourLearner learner(forward_, params);
    for (int i = 0; i < 4; ++i) learner.Add(room_.Render(forward_, {0, 0, 1.5 * i}), i, {});
    int full = 0;
    for (const ColourClass& one : learner.Finish().classes) full += one.covariance[0] == 1 ? 0 : 1;
    return full;
  };
  EXPECT_EQ(gaussians(ModelKind::kSturm), 8);
  EXPECT_EQ(gaussians(ModelKind::kVictoria), 0) << "k-means";
  EXPECT_EQ(gaussians(ModelKind::kVictoria2013), 0);
  EXPECT_EQ(gaussians(ModelKind::kSturm, Clustering::kMeans), 0) << "as wanted";
}

TEST_F(ColourCompassTest, TurnsGiveTheDepth) {
  const ColourModel model = Learn({}, 0.2);
  // From the camera on: the wall is 0.2 m nearer on one side than from the axle.
  EXPECT_NEAR(model.depth_m, room_.Radius(), 0.5);
  EXPECT_EQ(Learn({.depth_m = 7}, 0.2).depth_m, 7);
}

TEST_F(ColourCompassTest, LearnsAlong) {
  const ColouredRoom other(9);  // all walls were painted anew
  ColourCompass compass(Learn({.fading_s = 5}), forward_);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < kTurnFrames; ++i) {
      const Pose2 pose{0, 0, WrapAngle(2 * pi * i / kTurnFrames)};
      compass.Next({other.Render(forward_, pose), 100 + 0.1 * (i + kTurnFrames * round)});
      compass.Learn({pose});
    }
  }
  compass.Reset();
  double worst = 0;
  for (int i = 0; i < 30; ++i) {
    const Pose2 pose{0, 0, WrapAngle(2 + 0.06 * i)};
    const auto heading = compass.Next({other.Render(forward_, pose), 200 + 0.1 * i});
    if (i > 10) worst = std::max(worst, std::abs(WrapAngle(heading->heading_rad - pose.yaw)));
  }
  EXPECT_LT(worst, 0.05);
}

TEST_F(ColourCompassTest, ANewCellIsAnotherPlaceToBeAt) {
  ColourCompass compass(Learn(), forward_);
  const Pose2 pose{2, 1, 0.5};
  compass.Next({room_.Render(forward_, pose), 1});
  compass.Learn({pose});
  int cells = 0;
  for (const Cell& cell : compass.Model().cells) cells += cell.empty() ? 0 : 1;
  EXPECT_EQ(cells, 2);
  EXPECT_TRUE(compass.Next({room_.Render(forward_, pose), 1.1}));
}

TEST_F(ColourCompassTest, FramesBelowTheHorizonAreSkipped) {
  ColourCompass compass(Learn(), forward_);
  compass.Next({room_.Render(forward_, {}), 1});
  Tilt down;
  down.pitch_rad = 0.5;
  EXPECT_FALSE(compass.Next({room_.Render(forward_, {}), 2, down}));
  compass.Learn({});  // of nothing
  EXPECT_TRUE(compass.Next({room_.Render(forward_, {}), 3}));
  EXPECT_EQ(compass.Counts().below_horizon, 1);
  EXPECT_EQ(compass.Counts().used, 2);
  ColourLearner learner(forward_);
  EXPECT_FALSE(learner.Add(room_.Render(forward_, {}), 0, {{}, down}));
  EXPECT_THROW(static_cast<void>(learner.Finish()), InputError);
}

TEST_F(ColourCompassTest, AImageThatShowsNothingIsNoHeading) {
  ColourCompass compass(Learn(), forward_);
  for (int i = 0; i < 20; ++i) {
    const auto heading = compass.Next({cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(20)), 0.1 * i});
    EXPECT_GT(heading.value().variance_rad2, 0.3) << i;
    EXPECT_LT(heading->confidence, 0.9) << i;
  }
}

TEST_F(ColourCompassTest, RefusesWhatCannotBe) {
  const ColourModel model = Learn();
  ColourCompass compass(model, forward_);
  compass.Next({room_.Render(forward_, {}), 1});
  EXPECT_THROW(compass.Next({room_.Render(forward_, {}), 1}), InputError) << "stamps increase";
  EXPECT_THROW(compass.Next({cv::Mat(240, 320, CV_8UC1), 2}), InputError);
  ColourModel empty = model;
  for (Cell& cell : empty.cells) cell.bins.assign(180, {});
  EXPECT_THROW(ColourCompass(empty, forward_), InputError);
  EXPECT_THROW(ColourCompass(model, forward_, {.exposure_sigma = -1}), InputError);
  EXPECT_THROW(ColourLearner(forward_, {.bins = 10}), InputError);
}

}  // namespace
}  // namespace ceilmap::colour
