#pragma once

#include <filesystem>

#include "app/bags/mcap_writer.hpp"

namespace ceilmap::integration {

struct RecordingBagOptions {
  double start_s = 0;  ///< added to all stamps
  bags::McapOptions file = {};
};

/// Writes the recording of a robot as a bag of ROS 2: the folder's up.mp4, forward.mp4 and omni.mp4
/// (those that are there) with frames.csv, odometry.csv (otherwise truth.tum) and gyro.csv, and
/// rig.yaml. Topics: /up/image_raw and /forward/image_raw (mono8, the pixels that the program reads
/// of the videos), /omni/image_raw (bgr8), camera_info beside each, /odom, /tf, /tf_static, /imu.
/// Messages are recorded 20 ms after their stamps.
void WriteRecordingBag(const std::filesystem::path& folder,
                       const std::filesystem::path& bag,
                       const RecordingBagOptions& options = {});

}  // namespace ceilmap::integration
