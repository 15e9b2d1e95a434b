#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/files/odometry_csv.hpp"
#include "app/recordings/bag_motion.hpp"

namespace ceilmap::recordings {

/// The recordings of wheels and gyro; each may be missing.
class WheelInputs {
 public:
  WheelInputs() = default;
  /// @param odometry, gyro  files::ReadOdometry, files::ReadGyro, or bags; empty: there is none.
  /// @param odometry_topic, gyro_topic  of bags, which are read as far as their samples are needed.
  /// @throws InputError naming file and line.
  WheelInputs(const std::filesystem::path& odometry,
              const std::filesystem::path& gyro,
              const BagTopic& odometry_topic = {},
              const BagTopic& gyro_topic = {});

  /// Passes on the samples up to a moment after `stamp_s`: their clock may be late.
  /// @param add  takes each kind of sample.
  template <typename Sink>
  void ReadTo(double stamp_s, const Sink& add) {
    const double until_s = stamp_s + kAheadS;
    if (odometry_bag_) odometry_bag_->ReadTo(until_s);
    if (gyro_bag_) gyro_bag_->ReadTo(until_s);
    PassOn(Odometry().poses, next_pose_, until_s, add);
    PassOn(Odometry().speeds, next_speed_, until_s, add);
    PassOn(Gyro().samples, next_gyro_, until_s, add);
  }

  /// Of a bag, as far as it was read.
  [[nodiscard]] const files::OdometryRecording& Odometry() const {
    return odometry_bag_ ? odometry_bag_->Recording() : odometry_;
  }
  [[nodiscard]] const files::GyroRecording& Gyro() const {
    return gyro_bag_ ? gyro_bag_->Recording() : gyro_;
  }
  /// Names of the files, with the topics of bags; empty: there is none.
  [[nodiscard]] const std::string& OdometryName() const { return odometry_name_; }
  [[nodiscard]] const std::string& GyroName() const { return gyro_name_; }
  /// Problems of bags, one line each.
  [[nodiscard]] std::vector<std::string> BagWarnings() const;

 private:
  static constexpr double kAheadS = 0.5;

  template <typename Samples, typename Sink>
  static void PassOn(const Samples& samples, std::size_t& next, double until_s, const Sink& add) {
    for (; next < samples.size() && samples[next].stamp_s <= until_s; ++next) add(samples[next]);
  }

  std::string odometry_name_;
  std::string gyro_name_;
  std::unique_ptr<BagOdometry> odometry_bag_;  // in place of odometry_
  std::unique_ptr<BagGyro> gyro_bag_;          // in place of gyro_
  files::OdometryRecording odometry_;
  files::GyroRecording gyro_;
  std::size_t next_pose_ = 0;
  std::size_t next_speed_ = 0;
  std::size_t next_gyro_ = 0;
};

}  // namespace ceilmap::recordings
