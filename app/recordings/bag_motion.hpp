#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/bags/messages.hpp"
#include "app/files/odometry_csv.hpp"
#include "app/recordings/bag_source.hpp"

namespace ceilmap::recordings {

/// Reads the messages of a topic as their times are needed.
class BagSamples {
 public:
  BagSamples(std::unique_ptr<BagStream> stream, BagStamp stamp);
  virtual ~BagSamples() = default;

  /// Reads on until a sample later than `stamp_s` was added, or the bag has passed that time by
  /// more than a second.
  void ReadTo(double stamp_s);
  /// Problems so far, one line each.
  [[nodiscard]] std::vector<std::string> Warnings() const;
  /// "run.mcap:/odom", for messages.
  [[nodiscard]] std::string Name() const;

 protected:
  [[nodiscard]] const BagStream& Stream() const { return *stream_; }
  /// The stamp of a sample in seconds; nothing: it is not later than the sample before, and is left
  /// out.
  std::optional<double> StampOf(std::int64_t header_ns);
  void CountUnusable() { ++unusable_; }

 private:
  /// Adds the sample of a message. @throws bags::MessageError
  virtual void Add(const BagMessage& message) = 0;
  [[nodiscard]] virtual std::string Remark() const { return ""; }

  std::unique_ptr<BagStream> stream_;
  BagStamp stamp_;
  BagMessage message_;
  std::optional<double> last_s_;
  double log_ahead_s_ = 0;  // of the stamp of the last message
  int out_of_order_ = 0;
  std::int64_t unusable_ = 0;
};

/// The wheel odometry of a topic: nav_msgs/msg/Odometry, or the transform to base_link (or
/// base_footprint) from another frame in tf2_msgs/msg/TFMessage. Poses; where the messages have
/// none (a quaternion of zeros), the speeds of their twist.
class BagOdometry final : public BagSamples {
 public:
  /// @throws InputError as OpenTopic.
  BagOdometry(const std::string& bag, const BagTopic& topic);

  /// The samples so far.
  [[nodiscard]] const files::OdometryRecording& Recording() const { return recording_; }

 private:
  void Add(const BagMessage& message) override;
  [[nodiscard]] std::string Remark() const override;
  void AddOdometry(const bags::OdometryMessage& message);
  void AddTransform(const bags::TransformStamped& transform);

  files::OdometryRecording recording_;
  std::string parent_;  // of the transform
  std::string child_;
};

/// The turn rates of a topic, sensor_msgs/msg/Imu, about the vertical of base_link, on which
/// /tf_static states how the sensor is mounted.
class BagGyro final : public BagSamples {
 public:
  BagGyro(const std::string& bag, const BagTopic& topic);

  [[nodiscard]] const files::GyroRecording& Recording() const { return recording_; }

 private:
  void Add(const BagMessage& message) override;
  [[nodiscard]] std::string Remark() const override;

  std::string bag_;
  std::shared_ptr<OpenBags> bags_;
  files::GyroRecording recording_;
  std::optional<Eigen::Vector3d> up_imu_;  // the vertical of base in the axes of the sensor
  bool assumed_ = false;
  std::string frame_;
};

/// All of a topic, by a pass over the bag of its own. @return at least two samples.
/// @throws InputError
files::OdometryRecording ReadBagOdometry(const std::string& bag, const BagTopic& topic);

}  // namespace ceilmap::recordings
