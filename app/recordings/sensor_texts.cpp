#include "app/recordings/sensor_texts.hpp"

#include <fmt/format.h>

#include <iterator>

#include "calib/base/degrees.hpp"

namespace ceilmap::recordings {

std::string OdometryText(const std::vector<simulator::WheelSample>& samples,
                         simulator::WheelsKind kind) {
  const bool is_pose = kind == simulator::WheelsKind::kPose;
  std::string text = is_pose ? "timestamp,x,y,yaw_deg\n" : "timestamp,v,omega\n";
  const auto out = std::back_inserter(text);
  for (const simulator::WheelSample& sample : samples) {
    const Pose2& pose = sample.T_odom_base;
    if (is_pose) {
      fmt::format_to(out,
                     "{:.6f},{:.6f},{:.6f},{:.6f}\n",
                     sample.stamp_s,
                     pose.x,
                     pose.y,
                     pose.yaw / kRadPerDeg);
    } else {
      fmt::format_to(
          out, "{:.6f},{:.9f},{:.9f}\n", sample.stamp_s, sample.v_m_s, sample.omega_rad_s);
    }
  }
  return text;
}

std::string GyroText(const std::vector<simulator::GyroSample>& samples) {
  std::string text = "timestamp,omega_z\n";
  for (const simulator::GyroSample& sample : samples) {
    fmt::format_to(
        std::back_inserter(text), "{:.6f},{:.9f}\n", sample.stamp_s, sample.omega_z_rad_s);
  }
  return text;
}

}  // namespace ceilmap::recordings
