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

/// The output of `localize --status` for every frame, with or without a pose:
/// `timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg,peak,inliers`,
/// lengths in metres. Without a pose, the fields after `status` are empty.
std::string_view StatusHeader();
std::string FormatStatusLine(const robot::Estimate& estimate);

/// Status of one frame.
struct FrameStatus {
  double stamp_s = 0;
  graph::TrackingStatus status = graph::TrackingStatus::kTracking;
};

/// The status of a name. Names of other programs are reduced to whether the frame has a pose.
graph::TrackingStatus StatusNamed(const std::string& word, bool placed);

/// Content of a status file, for comparisons.
struct StatusRecord {
  std::vector<StampedPose> poses;  ///< of the frames that have one, at height 0
  /// Covariances of (x, y, yaw) of the poses, metres and radians: only the variances, because the
  /// file has no others.
  std::vector<Eigen::Matrix3d> covariances;
  std::vector<FrameStatus> placed;             ///< of each pose
  std::vector<FrameStatus> unplaced;           ///< of the frames that have none
  std::map<std::string, std::int64_t> frames;  ///< number of frames by status, as spelt in the file
};

/// Columns may have any order; `peak` and `inliers` may be missing.
/// @return stamps strictly increasing; possibly no poses.
/// @throws InputError naming file and line.
StatusRecord ReadStatus(const std::filesystem::path& file);

/// The same from a table.
StatusRecord StatusIn(const CsvTable& table);

}  // namespace ceilmap::files
