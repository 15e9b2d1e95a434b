#include "localization/compass/colour/victoria2013_compass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"
#include "localization/compass/colour/feature_similarity.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "tests/localization/compass/colour/coloured_room.hpp"

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

constexpr int kFrames = 90;
constexpr double kBinRad = 2 * pi / 180;

class Victoria2013Test : public testing::Test {
 protected:
  /// A model of a turn at the origin.
  static const ColourModel& Learn() {
    static const ColourModel model = Victoria2013Test::LearnRooms(false);
    return model;
  }
  /// Also of another room, in the cell about (2.4, 1.3).
  static ColourModel LearnRooms(bool second_room) {
    LearnParams params;
    params.kind = ModelKind::kVictoria2013;
    params.grid = GridGeometry{-3, -2, 6, 4, 5, 3};
    ColourLearner learner(forward_, params);
    for (int i = 0; i < kFrames; ++i) {
      const Pose2 pose{0, 0, WrapAngle(2 * pi * i / kFrames)};
      learner.Add(room_.Render(forward_, pose), 0.1 * i, {pose});
    }
    for (int i = 0; second_room && i < kFrames; ++i) {
      const Pose2 pose{0, 0, WrapAngle(2 * pi * i / kFrames)};
      LearnedPose stated{{2.4, 1.3, pose.yaw}};
      learner.Add(other_.Render(forward_, pose), 10 + 0.1 * i, stated);
    }
    return learner.Finish();
  }

  /// Largest error of a turn of steps of 4 deg from 0.7 rad on.
  double WorstError(Victoria2013Compass& compass) const {
    double worst = 0;
    for (int i = 0; i < kFrames; ++i) {
      const Pose2 pose{0, 0, WrapAngle(0.7 + 2 * pi * i / kFrames)};
      const auto heading = compass.Next({room_.Render(forward_, pose), 100 + 0.1 * i, {}, kCentre});
      worst = std::max(worst, std::abs(WrapAngle(heading.value().heading_rad - pose.yaw)));
    }
    return worst;
  }

  inline static const PlaceHypothesis kCentre[] = {{{0, 0}}};
  inline static const ColouredRoom room_{1};
  inline static const ColouredRoom other_{9};
  inline static const calib::MountedCamera forward_ = ForwardCamera();
};

TEST_F(Victoria2013Test, FindsTheHeadingOfEachFrameByItself) {
  Victoria2013Compass compass(Learn(), forward_, {}, PreviousHeading::kNone);
  EXPECT_LT(WorstError(compass), 3 * kBinRad);
  EXPECT_EQ(compass.Counts().used, kFrames);
}

TEST_F(Victoria2013Test, ThePreviousHeadingTurnsWithTheRobot) {
  Victoria2013Compass compass(Learn(), forward_);
  EXPECT_LT(WorstError(compass), 2 * kBinRad);
}

// The factor 1 / diff(alpha) of a previous heading that does not turn pulls back.
TEST_F(Victoria2013Test, AHeldHeadingLagsBehind) {
  Victoria2013Compass held(Learn(), forward_, {}, PreviousHeading::kHeld);
  EXPECT_GT(WorstError(held), 3 * kBinRad);
}

// The header's definition, computed anew for the frame: the sum of similarities of each heading.
TEST_F(Victoria2013Test, MaximisesTheSumOfSimilarities) {
  const ColourModel model = Learn();
  const cv::Mat image = room_.Render(forward_, {0.5, 0.3, 1.2});
  const PlaceHypothesis place[] = {{{0.5, 0.3}, 5}};
  Victoria2013Compass compass(model, forward_);
  compass.Next({image, 50, {}, place});
  const ScanLines lines(forward_);
  cv::Mat samples;
  lines.Sample(image, samples);
  LineFeatures features;
  CountTransitions(samples, lines, ColourClasses(model.classes), features);
  double newest = 0;
  for (const AngleBin& bin : model.cells[7].bins) newest = std::max(newest, bin.stamp_s);
  double best = 0;
  int best_step = 0;
  for (int h = 0; h < model.bins; ++h) {
    double score = 0;
    for (std::size_t i = 0; i < lines.Azimuths().size(); ++i) {
      const int b = BinOf(h * kBinRad + lines.Azimuths()[i], model.bins);
      const AngleBin& bin = model.cells[7].bins[static_cast<std::size_t>(b)];
      const Eigen::VectorXf line = features.row(static_cast<Eigen::Index>(i)).transpose();
      const double difference = FeatureDifference(line, bin.transitions);
      score += 1 / std::hypot(0.5, 0.3) / std::max(difference, SimilarityLimits{}.difference) *
               FadedCertainty(bin, newest, model.fading_s);
    }
    if (score > best) {
      best = score;
      best_step = h;
    }
  }
  ASSERT_EQ(compass.Orientations().size(), 1U);
  EXPECT_EQ(compass.Orientations()[0].cell, 7);
  EXPECT_NEAR(compass.Orientations()[0].score, best, 1e-9 * best);
  EXPECT_NEAR(compass.Orientations()[0].heading_rad, WrapAngle(best_step * kBinRad), 1e-9);
}

TEST_F(Victoria2013Test, EachCellWithAFifthOfTheHypothesesAnswers) {
  const ColourModel model = LearnRooms(true);
  Victoria2013Compass compass(model, forward_, {}, PreviousHeading::kNone);
  const Eigen::Vector2d here(0, 0);
  const Eigen::Vector2d there(2.4, 1.3);
  const PlaceHypothesis even[] = {{here}, {there}};
  const auto answer = [&](const cv::Mat& image, double stamp_s, const auto& places) {
    return compass.Next({image, stamp_s, {}, places}).value();
  };
  const cv::Mat image = room_.Render(forward_, {0, 0, 1});
  const ColourHeading heading = answer(image, 1, even);
  EXPECT_EQ(compass.Orientations().size(), 2U);
  EXPECT_NEAR(heading.heading_rad, 1, 2 * kBinRad);
  EXPECT_NEAR((heading.place - here).norm(), 0, 1e-9) << "the room that the frame shows";
  EXPECT_NEAR((answer(other_.Render(forward_, {0, 0, 1}), 2, even).place - there).norm(), 0, 1e-9);
  // p(l): the number of hypotheses counts.
  const PlaceHypothesis uneven[] = {{here, 0.3}, {there, 0.7}};
  const double before = compass.Orientations()[0].score;
  answer(other_.Render(forward_, {0, 0, 1}), 3, uneven);
  EXPECT_NEAR(compass.Orientations()[0].score, 1.4 * before, 1e-9 * before);
  const PlaceHypothesis few[] = {{here, 9}, {there, 1}};
  answer(image, 4, few);
  EXPECT_EQ(compass.Orientations().size(), 1U);
  EXPECT_NEAR((answer(image, 5, std::span<const PlaceHypothesis>()).heading_rad), 1, 2 * kBinRad)
      << "place unknown: all cells";
  EXPECT_EQ(compass.Orientations().size(), 2U);
}

TEST_F(Victoria2013Test, DaysLaterTheModelIsTheSame) {
  const ColourModel model = Learn();
  const cv::Mat image = room_.Render(forward_, {0, 0, 1});
  Victoria2013Compass soon(model, forward_);
  Victoria2013Compass late(model, forward_);
  const auto a = soon.Next({image, 10, {}, kCentre});
  const auto b = late.Next({image, 1e7, {}, kCentre});
  EXPECT_EQ(a.value().heading_rad, b.value().heading_rad);
  EXPECT_EQ(a->confidence, b->confidence);
}

TEST_F(Victoria2013Test, UpdatesByReplacement) {
  Victoria2013Compass compass(Learn(), forward_, {}, PreviousHeading::kNone);
  for (int i = 0; i < kFrames; ++i) {  // all walls were painted anew
    const Pose2 pose{0, 0, WrapAngle(2 * pi * i / kFrames)};
    compass.Next({other_.Render(forward_, pose), 100 + 0.1 * i, {}, kCentre});
    compass.Learn({pose});
  }
  const auto heading = compass.Next({other_.Render(forward_, {0, 0, 2}), 200, {}, kCentre});
  EXPECT_NEAR(heading.value().heading_rad, 2, 2 * kBinRad);
  EXPECT_GT(heading->confidence, 0.9);
}

TEST_F(Victoria2013Test, AnotherRoomIsNotCertain) {
  Victoria2013Compass compass(Learn(), forward_);
  EXPECT_GT(compass.Next({room_.Render(forward_, {0, 0, 1}), 1, {}, kCentre})->confidence, 0.9);
  EXPECT_LT(compass.Next({other_.Render(forward_, {0, 0, 1}), 2, {}, kCentre})->confidence, 0.9);
}

TEST_F(Victoria2013Test, FramesBelowTheHorizonAreSkipped) {
  Victoria2013Compass compass(Learn(), forward_);
  EXPECT_FALSE(compass.Next({room_.Render(forward_, {}), 1, {.pitch_rad = 0.5}, kCentre}));
  compass.Learn({});  // of nothing
  EXPECT_TRUE(compass.Next({room_.Render(forward_, {}), 2, {}, kCentre}));
  EXPECT_EQ(compass.Counts().below_horizon, 1);
  EXPECT_EQ(compass.Counts().used, 1);
}

TEST_F(Victoria2013Test, RefusesWhatCannotBe) {
  ColourModel model = Learn();
  Victoria2013Compass compass(model, forward_);
  compass.Next({room_.Render(forward_, {}), 1});
  EXPECT_THROW(compass.Next({room_.Render(forward_, {}), 1}), InputError) << "stamps increase";
  EXPECT_THROW(compass.Next({cv::Mat(240, 320, CV_8UC1), 2}), InputError);
  EXPECT_THROW(Victoria2013Compass(model, forward_, {.exposure_sigma = -1}), InputError);
  for (Cell& cell : model.cells) cell.bins.assign(180, {});
  EXPECT_THROW(Victoria2013Compass(model, forward_), InputError) << "empty";
  model.kind = ModelKind::kSturm;
  model.cells.resize(1);
  EXPECT_THROW(Victoria2013Compass(model, forward_), InputError) << "no grid";
}

}  // namespace
}  // namespace ceilmap::colour
