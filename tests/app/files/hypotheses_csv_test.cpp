#include "app/files/hypotheses_csv.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

using robot::TrackingStatus;

robot::Estimate Ambiguous(double stamp_s) {
  robot::Estimate estimate;
  estimate.stamp_s = stamp_s;
  estimate.status = TrackingStatus::kAmbiguous;
  estimate.places = {{{1, -2, std::numbers::pi / 2}, 0.75}, {{3, 4, 0}, 0.25}};
  return estimate;
}

TEST(HypothesesCsv, HasALineForEachPlaceWhileAmbiguous) {
  EXPECT_EQ(FormatHypotheses(Ambiguous(12.5)),
            "12.500000,1.000000,-2.000000,90.00000,0.75\n"
            "12.500000,3.000000,4.000000,0.00000,0.25\n");
  robot::Estimate known = Ambiguous(1);
  known.status = TrackingStatus::kTracking;
  EXPECT_EQ(FormatHypotheses(known), "");
}

TEST(HypothesesCsv, IsReadBackByTimes) {
  const std::string text = std::string(HypothesesHeader()) + FormatHypotheses(Ambiguous(1)) +
                           FormatHypotheses(Ambiguous(2));
  const auto all = HypothesesIn(ParseCsv(text, "h.csv"));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].stamp_s, 2);
  ASSERT_EQ(all[1].places.size(), 2U);
  EXPECT_EQ(all[1].places[1].pose.y, 4);
  EXPECT_EQ(all[1].places[1].weight, 0.25);
  EXPECT_NEAR(all[0].places[0].pose.yaw, std::numbers::pi / 2, 1e-6);
}

TEST(HypothesesCsv, RefusesWhatCannotBe) {
  const auto read = [](const char* lines) {
    return HypothesesIn(ParseCsv(std::string(HypothesesHeader()) + lines, "h.csv"));
  };
  EXPECT_THROW(read(""), InputError);
  EXPECT_THROW(read("1,0,0,0,0\n"), InputError);
  EXPECT_THROW(read("1,0,0,0,1\n0.5,0,0,0,1\n"), InputError);
  EXPECT_THROW(read("1,0,nan,0,1\n"), InputError);
}

}  // namespace
}  // namespace ceilmap::files
