#include "tests/faults/motion.hpp"

#include <fmt/format.h>

#include "app/files/tum.hpp"

namespace ceilmap::faults {

Motion RecordMotion(const simulator::Scene& scene, const Recording& shots) {
  Motion motion;
  if (scene.wheels) motion.wheels = simulator::MakeWheels(scene, shots.back().stamp_s);
  if (scene.gyro) motion.gyro = simulator::MakeGyro(scene, shots.back().stamp_s);
  return motion;
}

std::string OdometryText(const Motion& motion, OdometryForm form) {
  if (form == OdometryForm::kTum) {
    std::vector<StampedPose> poses;
    poses.reserve(motion.wheels.size());
    for (const simulator::WheelSample& sample : motion.wheels) {
      poses.push_back(ToStampedPose(sample.stamp_s, sample.T_odom_base));
    }
    return files::FormatTum(poses);
  }
  std::string text = "timestamp,v,omega\n";
  for (const simulator::WheelSample& sample : motion.wheels) {
    text += fmt::format("{:.6f},{:.6f},{:.6f}\n", sample.stamp_s, sample.v_m_s, sample.omega_rad_s);
  }
  return text;
}

std::string GyroText(const Motion& motion) {
  std::string text = "timestamp,omega_z\n";
  for (const simulator::GyroSample& sample : motion.gyro) {
    text += fmt::format("{:.6f},{:.6f}\n", sample.stamp_s, sample.omega_z_rad_s);
  }
  return text;
}

}  // namespace ceilmap::faults
