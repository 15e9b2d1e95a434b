#include "mapping/survey/alignment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "calib/base/error.hpp"

namespace ceilmap::survey {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Points spread over a hall of 60 x 40 m, in the coordinates of a UTM zone.
class Survey {
 public:
  explicit Survey(unsigned seed) : random_(seed) {
    std::uniform_real_distribution<double> yaw(-std::numbers::pi, std::numbers::pi);
    truth_ = {{691'000.25, 5'335'000.5, yaw(random_)}, 1};
  }

  [[nodiscard]] const Similarity2& Truth() const { return truth_; }
  void SetScale(double scale) { truth_.scale = scale; }

  std::vector<ControlPoint> Points(int count, double noise_m) {
    std::uniform_real_distribution<double> x(0, 60);
    std::uniform_real_distribution<double> y(0, 40);
    std::normal_distribution<double> noise(0, 1);
    std::vector<ControlPoint> points;
    for (int i = 0; i < count; ++i) {
      ControlPoint point;
      point.name = "P" + std::to_string(i);
      point.p_map = {x(random_), y(random_)};
      point.p_site =
          truth_ * point.p_map + noise_m * Eigen::Vector2d(noise(random_), noise(random_));
      points.push_back(point);
    }
    return points;
  }
  std::mt19937& Random() { return random_; }

 private:
  std::mt19937 random_;
  Similarity2 truth_;
};

/// Largest error over the hall.
double ErrorOf(const Similarity2& estimate, const Similarity2& truth) {
  double largest = 0;
  for (const double x : {0.0, 60.0}) {
    for (const double y : {0.0, 40.0}) {
      const Eigen::Vector2d corner(x, y);
      largest = std::max(largest, (estimate * corner - truth * corner).norm());
    }
  }
  return largest;
}

TEST(Align, ExactPointsGiveTheTransform) {
  Survey survey(1);
  const std::vector<ControlPoint> points = survey.Points(5, 0);
  const Alignment alignment = Align(points);
  EXPECT_LT(ErrorOf(alignment.site.S_site_map, survey.Truth()), 1e-8);
  EXPECT_EQ(alignment.used, 5);
  EXPECT_EQ(alignment.site.S_site_map.scale, 1);
  EXPECT_TRUE(alignment.checked);
  EXPECT_LT(alignment.leave_one_out_rms_m, 1e-8);
}

TEST(Align, AQuarterTurnByHand) {
  // The map's x axis is the site's y axis; the map's origin is at (10, 20).
  const Alignment alignment = Align({{"a", {0, 0}, {10, 20}, 0}, {"b", {3, 0}, {10, 23}, 0}});
  EXPECT_NEAR(alignment.site.S_site_map.motion.x, 10, 1e-12);
  EXPECT_NEAR(alignment.site.S_site_map.motion.y, 20, 1e-12);
  EXPECT_NEAR(alignment.site.S_site_map.motion.yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_FALSE(alignment.checked);
}

TEST(Align, FindsABlunderOfAMetreAmongSixPoints) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Survey survey(seed);
    std::vector<ControlPoint> points = survey.Points(6, 0.005);
    const std::size_t wrong = seed % 6;
    const double direction = 0.1 * seed;
    points[wrong].p_site += Eigen::Vector2d(std::cos(direction), std::sin(direction));
    const Alignment alignment = Align(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(alignment.site.points[i].used, i != wrong) << "seed " << seed << ", point " << i;
    }
    EXPECT_NEAR(alignment.site.points[wrong].residual_m.norm(), 1, 0.05);
    EXPECT_LT(ErrorOf(alignment.site.S_site_map, survey.Truth()), 0.05) << "seed " << seed;
  }
}

TEST(Align, StandardDeviationsHold) {
  double chi2 = 0;
  constexpr int kTrials = 400;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    Survey survey(seed);
    const Alignment alignment = Align(survey.Points(6, 0.02), {.sigma_m = 0.02});
    const SiteFrame& site = alignment.site;
    const Eigen::Vector2d off =
        site.S_site_map * site.centre_map - survey.Truth() * site.centre_map;
    const double yaw = WrapAngle(site.S_site_map.motion.yaw - survey.Truth().motion.yaw);
    chi2 += off.squaredNorm() / (site.sigma_position_m * site.sigma_position_m) +
            yaw * yaw / (site.sigma_yaw_rad * site.sigma_yaw_rad);
  }
  // At least: the ratio is never below 1, and its spread with nine degrees of freedom is large.
  EXPECT_GT(chi2 / (3 * kTrials), 0.6);
  EXPECT_LT(chi2 / (3 * kTrials), 1.2);
}

TEST(Align, AMapThatIsBentKeepsItsPoints) {
  Survey survey(3);
  const Alignment alignment = Align(survey.Points(8, 0.1));  // ten times the assumed 10 mm
  EXPECT_EQ(alignment.used, 8);
  EXPECT_GT(alignment.sigma_ratio, 5);
  EXPECT_GT(alignment.site.sigma_position_m, 0.02);
}

TEST(Align, LeftOutErrorIsThatOfAFitWithoutThePoint) {
  Survey survey(4);
  std::vector<ControlPoint> points = survey.Points(5, 0.01);
  const Alignment all = Align(points);
  const ControlPoint last = points.back();
  points.pop_back();
  const Alignment others = Align(points);
  EXPECT_NEAR(*all.site.points.back().leave_one_out_m,
              (last.p_site - others.site.S_site_map * last.p_map).norm(),
              1e-9);
  EXPECT_GT(all.leave_one_out_rms_m, all.rms_m);
}

TEST(Align, EstimatesTheScale) {
  Survey survey(5);
  survey.SetScale(0.0123);  // metres per pixel of a map without a rig
  const Alignment alignment =
      Align(survey.Points(6, 1e-5), {.estimate_scale = true, .sigma_m = 1e-4});
  EXPECT_NEAR(alignment.site.S_site_map.scale / 0.0123, 1, 1e-4);
  EXPECT_GT(alignment.site.sigma_scale, 0);
}

TEST(Align, WeightsPointsByTheirStandardDeviations) {
  const Alignment alignment =
      Align({{"a", {0, 0}, {0.02, 0}, 0.001}, {"b", {10, 0}, {10, 0}, 0.1}});
  EXPECT_NEAR(alignment.site.points[0].residual_m.x(), 0, 1e-5);
  EXPECT_NEAR(alignment.site.points[1].residual_m.x(), -0.02, 1e-5);
}

TEST(Align, NamesMillimetres) {
  Survey survey(6);
  survey.SetScale(1000);
  EXPECT_THAT([&] { Align(survey.Points(5, 1)); },
              ThrowsMessage<InputError>(HasSubstr("must be in metres")));
}

TEST(Align, NamesAMirroredAxis) {
  Survey survey(7);
  std::vector<ControlPoint> points = survey.Points(6, 0.005);
  for (ControlPoint& point : points) std::swap(point.p_site.x(), point.p_site.y());
  EXPECT_THAT([&] { Align(points); }, ThrowsMessage<InputError>(HasSubstr("mirrored")));
}

TEST(Align, RefusesPointsThatDoNotDetermineIt) {
  Survey survey(8);
  EXPECT_THAT([&] { Align(survey.Points(1, 0)); },
              ThrowsMessage<InputError>(HasSubstr("at least two")));
  EXPECT_THAT(
      [&] {
        Align({{"a", {1, 2}, {3, 4}, 0}, {"b", {1, 2}, {3, 4}, 0}});
      },
      ThrowsMessage<InputError>(HasSubstr("one place")));
  EXPECT_THAT(
      [&] {
        Align({{"a", {1, 2}, {3, 4}, 0}, {"b", {1.02, 2}, {3.02, 4}, 0}});
      },
      ThrowsMessage<InputError>(HasSubstr("too close together")));
  EXPECT_THAT(
      [&] {
        Align({{"a", {1, 2}, {3, 4}, 0}, {"a", {9, 2}, {11, 4}, 0}});
      },
      ThrowsMessage<InputError>(HasSubstr("'a'")));
}

TEST(Align, RefusesNumbersThatNoPointHas) {
  const auto refused = [](const ControlPoint& last) {
    return [last] { Align({{"a", {1, 2}, {3, 4}, 0}, {"b", {9, 2}, {11, 4}, 0}, last}); };
  };
  for (const double number : {1e302, -1.1e9, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(refused({"c", {1, number}, {3, 4}, 0}),
                ThrowsMessage<InputError>("point 'c': the coordinates must be within 1e+09"));
    EXPECT_THAT(refused({"c", {1, 2}, {number, 4}, 0}),
                ThrowsMessage<InputError>("point 'c': the coordinates must be within 1e+09"));
  }
  for (const double sigma : {-1.0, 1e-300, 1e300, std::nan("")}) {
    EXPECT_THAT(refused({"c", {5, 5}, {7, 7}, sigma}),
                ThrowsMessage<InputError>(HasSubstr("must be in 1e-06..1e+06, or 0")));
  }
}

TEST(Align, RefusesPointsWithoutAMajority) {
  // Two surveys of three points each that contradict each other.
  Survey survey(9);
  std::vector<ControlPoint> points = survey.Points(6, 0.002);
  std::uniform_real_distribution<double> far(5, 30);
  for (std::size_t i = 0; i < 4; ++i)
    points[i].p_site += Eigen::Vector2d(far(survey.Random()), far(survey.Random()));
  EXPECT_THAT([&] { Align(points); },
              ThrowsMessage<InputError>(HasSubstr("contradict each other")));
}

TEST(Align, TheOrderOfPointsDoesNotMatter) {
  Survey survey(10);
  std::vector<ControlPoint> points = survey.Points(150, 0.01);  // more pairs than are tested
  const Alignment first = Align(points);
  std::shuffle(points.begin(), points.end(), survey.Random());
  EXPECT_LT(ErrorOf(Align(points).site.S_site_map, first.site.S_site_map), 1e-8);
}

}  // namespace
}  // namespace ceilmap::survey
