#include "app/status_csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace ceilmap::app {

std::string_view StatusHeader() {
  return "timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,"
         "inliers\n";
}

std::string FormatStatusLine(const localization::Location& location) {
  const mapping::FramePose& pose = location.pose;
  const char* const status = mapping::ToString(pose.status);
  if (!location.Placed()) return fmt::format("{:.6f},{},,,,,,,,,,\n", pose.stamp_s, status);
  constexpr double kDegPerRad = 180 / std::numbers::pi;
  const auto sigma = [&](int i) { return std::sqrt(pose.covariance(i, i)); };
  // A level robot is exactly level.
  const auto tilt = [](double rad) {
    return rad == 0 ? std::string("0") : fmt::format("{:.5f}", kDegPerRad * rad);
  };
  return fmt::format("{:.6f},{},{:.6f},{:.6f},{:.5f},{},{},{:.6f},{:.6f},{:.5f},{:.3f},{}\n",
                     pose.stamp_s,
                     status,
                     pose.T_map_base.x,
                     pose.T_map_base.y,
                     kDegPerRad * pose.T_map_base.yaw,
                     tilt(pose.tilt.pitch_rad),
                     tilt(pose.tilt.roll_rad),
                     sigma(0),
                     sigma(1),
                     kDegPerRad * sigma(2),
                     location.peak,
                     location.inliers);
}

}  // namespace ceilmap::app
