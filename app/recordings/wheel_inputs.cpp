#include "app/recordings/wheel_inputs.hpp"

#include <utility>

namespace ceilmap::recordings {

WheelInputs::WheelInputs(std::filesystem::path odometry, std::filesystem::path gyro)
    : odometry_file_(std::move(odometry)), gyro_file_(std::move(gyro)) {
  if (!odometry_file_.empty()) odometry_ = files::ReadOdometry(odometry_file_);
  if (!gyro_file_.empty()) gyro_ = files::ReadGyro(gyro_file_);
}

}  // namespace ceilmap::recordings
