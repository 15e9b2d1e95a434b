#include "app/status_csv.hpp"

#include <gtest/gtest.h>

namespace ceilmap::app {
namespace {

using mapping::TrackingStatus;

TEST(StatusCsv, APlacedFrame) {
  localization::Location location;
  location.pose.status = TrackingStatus::kRelocalized;
  location.pose.stamp_s = 12.5;
  location.pose.T_map_base = {1, -2.25, std::acos(-1.0) / 4};
  location.pose.covariance.diagonal() << 1e-6, 4e-6, 1e-8;
  location.peak = 0.71;
  location.inliers = 40;
  EXPECT_EQ(FormatStatusLine(location),
            "12.500000,relocalized,1.000000,-2.250000,45.00000,0,0,0.001000,0.002000,0.00573,0.710,"
            "40\n");
}

TEST(StatusCsv, AFrameWithoutAPoseHasNoNumbersAndAsManyFields) {
  localization::Location location;
  location.pose.stamp_s = 3;
  const std::string_view header = StatusHeader();
  for (const TrackingStatus status : {TrackingStatus::kLost, TrackingStatus::kAmbiguous}) {
    location.pose.status = status;
    location.pose.T_map_base = {1, 2, 3};
    const std::string line = FormatStatusLine(location);
    EXPECT_EQ(line, std::string("3.000000,") + mapping::ToString(status) + ",,,,,,,,,,\n");
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
}

}  // namespace
}  // namespace ceilmap::app
