#pragma once

#include <cstddef>
#include <filesystem>

#include "app/files/odometry_csv.hpp"

namespace ceilmap::recordings {

/// The recordings of wheels and gyro; each may be missing.
class WheelInputs {
 public:
  WheelInputs() = default;
  /// @param odometry, gyro  files::ReadOdometry, files::ReadGyro; empty: there is none.
  /// @throws InputError naming file and line.
  WheelInputs(std::filesystem::path odometry, std::filesystem::path gyro);

  /// Passes on the samples up to a moment after `stamp_s`: their clock may be late.
  /// @param add  takes each kind of sample.
  template <typename Sink>
  void ReadTo(double stamp_s, const Sink& add) {
    const double until_s = stamp_s + kAheadS;
    PassOn(odometry_.poses, next_pose_, until_s, add);
    PassOn(odometry_.speeds, next_speed_, until_s, add);
    PassOn(gyro_.samples, next_gyro_, until_s, add);
  }

  [[nodiscard]] const files::OdometryRecording& Odometry() const { return odometry_; }
  [[nodiscard]] const files::GyroRecording& Gyro() const { return gyro_; }
  [[nodiscard]] const std::filesystem::path& OdometryFile() const { return odometry_file_; }
  [[nodiscard]] const std::filesystem::path& GyroFile() const { return gyro_file_; }

 private:
  static constexpr double kAheadS = 0.5;

  template <typename Samples, typename Sink>
  static void PassOn(const Samples& samples, std::size_t& next, double until_s, const Sink& add) {
    for (; next < samples.size() && samples[next].stamp_s <= until_s; ++next) add(samples[next]);
  }

  std::filesystem::path odometry_file_;
  std::filesystem::path gyro_file_;
  files::OdometryRecording odometry_;
  files::GyroRecording gyro_;
  std::size_t next_pose_ = 0;
  std::size_t next_speed_ = 0;
  std::size_t next_gyro_ = 0;
};

}  // namespace ceilmap::recordings
