#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "app/files/csv.hpp"
#include "calib/base/stamped_pose.hpp"
#include "localization/robot/estimate.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::files {

/// What `localize --status` tells of every frame, placed or not:
/// `timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,inliers`,
/// lengths in metres. Where there is no pose, the fields after `status` are empty.
std::string_view StatusHeader();
std::string FormatStatusLine(const robot::Estimate& estimate);

/// Whether a frame was placed.
struct FrameStatus {
  double stamp_s = 0;
  graph::TrackingStatus status = graph::TrackingStatus::kTracking;
};

/// What such a file tells, for comparisons.
struct StatusRecord {
  std::vector<StampedPose> poses;  ///< of the frames that have one, at height 0
  /// Of (x, y, yaw) of each of them, metres and radians: the variances, all that the file has.
  std::vector<Eigen::Matrix3d> covariances;
  std::vector<FrameStatus> placed;             ///< of each pose
  std::vector<FrameStatus> unplaced;           ///< of the frames that have none
  std::map<std::string, std::int64_t> frames;  ///< how many, by status as the file spells it
};

/// Columns may stand in any order, `peak` and `inliers` may be missing.
/// @return stamps strictly increasing; perhaps no poses.
/// @throws InputError naming file and line.
StatusRecord ReadStatus(const std::filesystem::path& file);

/// The same of a table that was read.
StatusRecord StatusIn(const CsvTable& table);

}  // namespace ceilmap::files
