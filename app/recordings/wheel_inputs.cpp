#include "app/recordings/wheel_inputs.hpp"

#include <utility>

namespace ceilmap::recordings {

WheelInputs::WheelInputs(const std::filesystem::path& odometry,
                         const std::filesystem::path& gyro,
                         const BagTopic& odometry_topic,
                         const BagTopic& gyro_topic)
    : odometry_name_(odometry.string()), gyro_name_(gyro.string()) {
  if (!odometry.empty() && IsBag(odometry_name_)) {
    odometry_bag_ = std::make_unique<BagOdometry>(odometry_name_, odometry_topic);
    odometry_name_ = odometry_bag_->Name();
  } else if (!odometry.empty()) {
    odometry_ = files::ReadOdometry(odometry);
  }
  if (!gyro.empty() && IsBag(gyro_name_)) {
    gyro_bag_ = std::make_unique<BagGyro>(gyro_name_, gyro_topic);
    gyro_name_ = gyro_bag_->Name();
  } else if (!gyro.empty()) {
    gyro_ = files::ReadGyro(gyro);
  }
}

std::vector<std::string> WheelInputs::BagWarnings() const {
  std::vector<std::string> warnings;
  if (odometry_bag_) warnings = odometry_bag_->Warnings();
  if (gyro_bag_) {
    for (std::string& warning : gyro_bag_->Warnings()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

}  // namespace ceilmap::recordings
