#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/evaluation/consistency.hpp"
#include "app/evaluation/heading_errors.hpp"
#include "app/files/status_csv.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::files {

/// Content of a file of poses or headings, in any of the program's formats.
struct Estimate {
  std::vector<StampedPose> poses;                        ///< empty: headings only
  std::vector<evaluation::PoseCovariance> covariances;   ///< of each pose; empty: unknown
  std::vector<evaluation::StampedHeading> headings;      ///< of the poses, if available
  std::map<std::string, std::int64_t> frames_of_status;  ///< of a status file, with its spelling
  std::vector<FrameStatus> placed;                       ///< of a status file, for each pose
  std::vector<FrameStatus> unplaced;  ///< of a status file, frames without a pose
  std::vector<std::string> warnings;  ///< about a damaged bag, one line each

  /// The same with stamps of another clock.
  void Delay(double offset_s);
};

/// Reads a trajectory (TUM lines), or, if the name ends in `.csv`, depending on its columns, a
/// status file of `localize` or the headings of `heading`, or the poses of a bag (ReadBagEstimate).
/// @return at least one heading; stamps strictly increasing.
/// @throws InputError naming file and line.
Estimate ReadEstimate(const std::filesystem::path& file);

}  // namespace ceilmap::files
