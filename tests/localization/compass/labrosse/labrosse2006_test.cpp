#include "localization/compass/labrosse/labrosse2006.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/fields_of_view.hpp"
#include "localization/compass/labrosse/methods.hpp"
#include "localization/compass/labrosse/shift_minimum.hpp"
#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::labrosse {
namespace {

double ErrorDeg(const std::optional<compass::HeadingEstimate>& estimate, double heading_rad) {
  return WrapAngle(estimate.value().heading_rad - heading_rad) / kRadPerDeg;
}

/// A world that turns into another one: 0 the first, 1 the second.
cv::Mat Mixed(const compass::Waves& first,
              const compass::Waves& second,
              double part,
              double heading_rad) {
  return (1 - part) * first.At(heading_rad) + part * second.At(heading_rad);
}

TEST(Labrosse2006, FollowsRandomTurnsBetweenTheColumns) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(-4 * kRadPerDeg, 4 * kRadPerDeg);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const int columns : {180, 360}) {
      const compass::Waves world(8, columns, type, random());
      Labrosse2006 compass;
      double heading = 0;
      for (int i = 0; i < 30; ++i) {
        const auto estimate = compass.Next({world.At(heading), 0.1 * i});
        EXPECT_NEAR(ErrorDeg(estimate, heading), 0, 0.1 * 360 / columns) << columns << " " << i;
        if (i > 0) {
          EXPECT_GT(estimate->confidence, 0.6);
        }
        heading += turn(random);
      }
      // Nothing but the heading changes: the first panorama serves all along.
      EXPECT_EQ(compass.References(), 1);
    }
  }
}

/// Distance of two panoramas at a shift, over the columns with a weight, from the definition.
double DistanceAt(const cv::Mat& reference,
                  const cv::Mat& current,
                  const std::vector<float>& weights,
                  int shift) {
  const cv::Mat shifted = compass::Rolled(reference, shift);
  double squared = 0;
  for (int u = 0; u < current.cols; ++u) {
    if (weights[static_cast<std::size_t>(u)] == 0) continue;
    squared += cv::norm(current.col(u), shifted.col(u), cv::NORM_L2SQR);
  }
  return std::sqrt(squared);
}

// Eq. 7 to 12 by hand, for panoramas that agree in part.
TEST(Labrosse2006, AmplitudeAndMinimumAreThoseOfThePaper) {
  constexpr int kColumns = 90;
  const compass::Waves first(6, kColumns, CV_8UC3, 21);
  const compass::Waves second(6, kColumns, CV_8UC3, 22);
  const auto weights = compass::FieldsOfView{}.ColumnWeights(kColumns);
  for (const double part : {0.02, 0.1, 0.2, 0.3}) {
    const cv::Mat reference = first.At(0);
    const cv::Mat current = Mixed(first, second, part, 5.5 * kRadPerDeg);
    const auto d = [&](int shift) { return DistanceAt(reference, current, weights, shift); };
    const auto own = [&](int shift) { return DistanceAt(reference, reference, weights, shift); };
    int at = 0;
    for (const int shift : {1, 2}) {
      if (d(shift) < d(at)) at = shift;
    }
    const double own_linear = std::abs(own(-1) - own(1)) / 2;
    const double own_shift = (own(-1) - own(1)) / (2 * std::max(own(-1), own(1)));
    const auto between = [](const auto& distance, double shift) {
      const int column = static_cast<int>(std::floor(shift));
      return std::lerp(distance(column), distance(column + 1), shift - column);
    };
    const double pixel = (d(at + kColumns / 2) - d(at)) / own(kColumns / 2);
    const double p = pixel <= 0.5 ? 0 : (pixel - 0.5) / 0.5;
    const SubPixelMinimum minimum = BlendedMinimum({d(at - 1), d(at), d(at + 1)}, p);
    const double amplitude = (between(d, at + minimum.shift + kColumns / 2) - minimum.distance) /
                             (between(own, own_shift + kColumns / 2) + own_linear);
    Labrosse2006 compass({.threshold = 0});
    (void)compass.Next({reference, 0});
    const auto found = compass.Next({current, 1});
    EXPECT_NEAR(found->confidence, amplitude, 1e-6) << part;
    EXPECT_NEAR(found->heading_rad / (2 * std::numbers::pi) * kColumns, at + minimum.shift, 1e-6);
  }
}

// Faster than the probes reach, once the turn is known.
TEST(Labrosse2006, ExpectsTheTurnToGoOn) {
  const compass::Waves world(8, 360, CV_8UC1, 2);
  const auto last_error = [&](Labrosse2006Variant variant) {
    Labrosse2006 compass({.threshold = 1, .variant = variant});
    double error = 0;
    double heading = 0;
    for (int i = 0; i < 20; ++i) {
      error =
          std::max(error, std::abs(ErrorDeg(compass.Next({world.At(heading), 0.1 * i}), heading)));
      heading += 2.5 * i * kRadPerDeg;
    }
    return error;
  };
  EXPECT_LT(last_error(Labrosse2006Variant::kProbes), 0.5);
  EXPECT_GT(last_error(Labrosse2006Variant::kPublished), 5);
}

TEST(Labrosse2006, ChangesTheReferenceBelowTheThreshold) {
  const compass::Waves first(8, 360, CV_8UC3, 3);
  const compass::Waves second(8, 360, CV_8UC3, 4);
  std::int64_t references = 1;
  for (const double threshold : {0.0, 0.5, 0.6055, 0.8, 1.0}) {
    Labrosse2006 compass({.threshold = threshold});
    std::int64_t reference = 0;
    for (int i = 0; i <= 20; ++i) {
      const double heading = 3.3 * kRadPerDeg * i;
      const auto estimate = compass.Next({Mixed(first, second, i / 30.0, heading), 0.1 * i});
      EXPECT_NEAR(ErrorDeg(estimate, heading), 0, threshold > 0 ? 0.8 : 2);
      if (i == 0) continue;
      const std::int64_t before = reference;
      reference = compass.Profile().reference_frame;
      // Either the reference stays and the minimum is deep, or the frame before took over.
      if (reference == before) {
        EXPECT_TRUE(estimate->confidence >= threshold || reference == i - 1);
      } else {
        EXPECT_EQ(reference, i - 1);
        EXPECT_GT(estimate->variance_rad2, 0);
      }
    }
    EXPECT_GE(compass.References(), references);
    references = compass.References();
    if (threshold == 0) {
      EXPECT_EQ(compass.References(), 1);
    }
    if (threshold == 0.6055) {
      EXPECT_GT(compass.References(), 2);
      EXPECT_LT(compass.References(), 18);
    }
    if (threshold == 1) {
      EXPECT_EQ(compass.References(), 20);
    }
  }
}

TEST(Labrosse2006, FixedSkipsUseEveryNthFrame) {
  const compass::Waves world(8, 360, CV_8UC1, 5);
  for (const int skip : {0, 1, 4}) {
    Labrosse2006 compass({.skip = skip});
    for (int i = 0; i < 21; ++i) {
      const double heading = 1.7 * kRadPerDeg * i;
      const auto estimate = compass.Next({world.At(heading), 0.1 * i});
      ASSERT_EQ(estimate.has_value(), i % (skip + 1) == 0) << skip << " " << i;
      if (!estimate) continue;
      EXPECT_NEAR(ErrorDeg(estimate, heading), 0, 0.5);
      if (i > 0) {
        EXPECT_EQ(compass.Profile().reference_frame, i - skip - 1);
      }
    }
    EXPECT_EQ(compass.References(), 20 / (skip + 1));
  }
}

TEST(Labrosse2006, HoldsTheHeadingWithoutTexture) {
  const compass::Waves world(8, 360, CV_8UC3, 6);
  const cv::Mat grey(8, 360, CV_8UC3, cv::Scalar(40, 90, 90));
  const cv::Mat noise = compass::RandomPanorama(8, 360, CV_8UC3, 7) / 128 + grey;
  for (const std::optional<int> skip : {std::optional<int>(), std::optional<int>(0)}) {
    Labrosse2006 compass({.skip = skip});
    double stamp = 0;
    EXPECT_EQ(compass.Next({grey, stamp})->confidence, 0);
    EXPECT_EQ(compass.Next({world.At(0), ++stamp})->heading_rad, 0);
    const auto seen = compass.Next({world.At(4 * kRadPerDeg), ++stamp});
    EXPECT_NEAR(ErrorDeg(seen, 4 * kRadPerDeg), 0, 0.1);
    double variance = seen->variance_rad2;
    for (const cv::Mat& blind : {noise, grey, noise}) {
      const auto held = compass.Next({blind, stamp += 0.1});
      EXPECT_EQ(held->heading_rad, seen->heading_rad);
      EXPECT_EQ(held->confidence, 0);
      EXPECT_GT(held->variance_rad2, variance);
      variance = held->variance_rad2;
    }
    const auto again = compass.Next({world.At(15 * kRadPerDeg), stamp + 0.1});
    EXPECT_NEAR(ErrorDeg(again, 15 * kRadPerDeg), 0, 0.2);
    EXPECT_LT(again->variance_rad2, variance);
    EXPECT_GT(again->confidence, 0.6);
  }
}

// One frame that fits nothing costs nothing; new surroundings are a new beginning.
TEST(Labrosse2006, GoesOnInNewSurroundings) {
  const compass::Waves world(8, 360, CV_8UC3, 8);
  const compass::Waves elsewhere(8, 360, CV_8UC3, 9);
  Labrosse2006 compass;
  (void)compass.Next({world.At(0), 0});
  (void)compass.Next({world.At(3 * kRadPerDeg), 1});
  EXPECT_EQ(compass.Next({compass::RandomPanorama(8, 360, CV_8UC3, 10), 2})->confidence, 0);
  EXPECT_NEAR(ErrorDeg(compass.Next({world.At(9 * kRadPerDeg), 3}), 9 * kRadPerDeg), 0, 0.2);
  const cv::Mat strange = compass::RandomPanorama(8, 360, CV_8UC3, 11);
  const auto lost = compass.Next({strange, 4});
  EXPECT_EQ(lost->confidence, 0);
  const auto found = compass.Next({compass::Rolled(strange, 5), 5});
  EXPECT_NEAR(found->heading_rad, lost->heading_rad + 5 * kRadPerDeg, 0.1 * kRadPerDeg);
  EXPECT_NEAR(found->confidence, 1, 0.02);
  EXPECT_GE(found->variance_rad2, lost->variance_rad2);
}

// A frame that fitted nothing does not become the reference while the old one still matches
// something, less than the threshold asks for: what the robot turned meanwhile would be lost.
TEST(Labrosse2006, ReturnsToAPoorReference) {
  const compass::Waves world(8, 360, CV_8UC3, 15);
  const compass::Waves later(8, 360, CV_8UC3, 16);
  Labrosse2006 compass;
  (void)compass.Next({world.At(0), 0});
  EXPECT_EQ(compass.Next({compass::RandomPanorama(8, 360, CV_8UC3, 17), 1})->confidence, 0);
  const auto poor = compass.Next({Mixed(world, later, 0.45, 5 * kRadPerDeg), 2});
  EXPECT_LT(poor->confidence, 0.6);
  EXPECT_GT(poor->confidence, 0.1);
  EXPECT_NEAR(ErrorDeg(poor, 5 * kRadPerDeg), 0, 0.8);
  EXPECT_EQ(compass.References(), 1);
}

// What lies in the fields of view turns by 5 columns, the rest by 2.
TEST(Labrosse2006, FieldsOfViewFollowTheTravel) {
  const cv::Mat world = compass::Waves(8, 360, CV_8UC3, 12).At(0);
  const auto towards = [](double direction) {
    return Eigen::Vector2d(0.1 * std::cos(direction), 0.1 * std::sin(direction));
  };
  for (const double travel : {0.0, 90 * kRadPerDeg, -30 * kRadPerDeg, 200 * kRadPerDeg}) {
    const auto weights =
        compass::FieldsOfView::FrontAndBack(travel, 60 * kRadPerDeg).ColumnWeights(360);
    cv::Mat turned = compass::Rolled(world, 2);
    const cv::Mat inside = compass::Rolled(world, 5);
    for (int u = 0; u < 360; ++u) {
      if (weights[static_cast<std::size_t>(u)] > 0) inside.col(u).copyTo(turned.col(u));
    }
    Labrosse2006 follows;
    Labrosse2006 whole({.field_of_view_rad = 2 * std::numbers::pi});
    Labrosse2006 across;
    (void)follows.Next({world, 0});
    (void)whole.Next({world, 0});
    (void)across.Next({world, 0});
    EXPECT_NEAR(ErrorDeg(follows.Next({turned, 1, towards(travel)}), 5 * kRadPerDeg), 0, 0.01);
    EXPECT_NEAR(
        ErrorDeg(across.Next({turned, 1, towards(travel + 90 * kRadPerDeg)}), 2 * kRadPerDeg),
        0,
        0.01);
    EXPECT_LT(std::abs(ErrorDeg(whole.Next({turned, 1, towards(travel)}), 2 * kRadPerDeg)), 1.5);
  }
}

// Blue against red of the same brightness.
TEST(Labrosse2006, UsesColours) {
  const cv::Mat blue = compass::Waves(8, 360, CV_8UC1, 13).At(0);
  cv::Mat colours;
  cv::merge(std::vector<cv::Mat>{blue, cv::Mat(blue.size(), CV_8UC1, cv::Scalar(80)), 255 - blue},
            colours);
  cv::Mat sum;
  cv::transform(colours, sum, cv::Matx13f(1, 1, 1));
  Labrosse2006 colour;
  Labrosse2006 grey;
  (void)colour.Next({colours, 0});
  (void)grey.Next({sum, 0});
  const auto seen = colour.Next({compass::Rolled(colours, 6), 1});
  EXPECT_NEAR(ErrorDeg(seen, 6 * kRadPerDeg), 0, 0.01);
  EXPECT_NEAR(seen->confidence, 1, 0.02);
  EXPECT_EQ(grey.Next({compass::Rolled(sum, 6), 1})->confidence, 0);
}

TEST(Labrosse2006, ShowsItsDistances) {
  const compass::Waves world(5, 90, CV_8UC3, 14);
  Labrosse2006 compass;
  (void)compass.Next({world.At(0), 0});
  EXPECT_TRUE(compass.Profile().distance.empty());
  const cv::Mat current = world.At(-9.3 * kRadPerDeg);
  (void)compass.Next({current, 1});
  const compass::DistanceProfile profile = compass.Profile();
  const auto weights = compass::FieldsOfView{}.ColumnWeights(90);
  ASSERT_EQ(profile.distance.size(), 90U);
  for (int shift = 0; shift < 90; ++shift) {
    EXPECT_NEAR(profile.distance[static_cast<std::size_t>(shift)],
                DistanceAt(world.At(0), current, weights, shift),
                1e-9);
  }
  EXPECT_NEAR(profile.shift_columns, -9.3 / 4, 0.1);
  EXPECT_EQ(profile.reference_frame, 0);
}

std::string ErrorOf(const Labrosse2006Params& params) {
  try {
    params.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Labrosse2006, RefusesUnusableParameters) {
  EXPECT_EQ(ErrorOf({}), "no error");
  EXPECT_EQ(ErrorOf({.field_of_view_rad = 7}),
            "labrosse2006: field_of_view_rad = 7, must be in (0, 2 pi]");
  EXPECT_EQ(ErrorOf({.threshold = 1.5}), "labrosse2006: threshold = 1.5, must be in [0, 1]");
  EXPECT_EQ(ErrorOf({.skip = -1}), "labrosse2006: skip = -1, must be >= 0");
}

TEST(MakeCompass, MakesEachMethod) {
  const auto make = [](Method method) { return MakeCompass({.method = method}); };
  EXPECT_NE(dynamic_cast<compass::FftCompass*>(make(Method::kFft).get()), nullptr);
  EXPECT_NE(dynamic_cast<Labrosse2006*>(make(Method::kLabrosse2006).get()), nullptr);
  EXPECT_NE(dynamic_cast<Labrosse2004*>(make(Method::kLabrosse2004).get()), nullptr);
  // Only the parameters of the selected method are checked.
  CompassParams params{.method = Method::kLabrosse2004};
  params.labrosse2006.threshold = 2;
  EXPECT_NO_THROW(MakeCompass(params));
  params.method = Method::kLabrosse2006;
  EXPECT_THROW(MakeCompass(params), InputError);
}

}  // namespace
}  // namespace ceilmap::labrosse
