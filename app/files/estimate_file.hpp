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

/// What a file says of a drive, whichever of the program's formats it has.
struct Estimate {
  std::vector<StampedPose> poses;                        ///< empty: it has headings only
  std::vector<evaluation::PoseCovariance> covariances;   ///< of each pose; empty: not known
  std::vector<evaluation::StampedHeading> headings;      ///< of the poses, where there are some
  std::map<std::string, std::int64_t> frames_of_status;  ///< of a status file, as it spells them
  std::vector<FrameStatus> placed;                       ///< of it, of each pose
  std::vector<FrameStatus> unplaced;                     ///< of it, frames without a pose

  /// The same by another clock.
  void Delay(double offset_s);
};

/// Reads a trajectory (TUM lines), or, by its ending `.csv` and its columns, a status file of
/// `localize` or the headings of `heading`.
/// @return at least one heading; stamps strictly increasing.
/// @throws InputError naming file and line.
Estimate ReadEstimate(const std::filesystem::path& file);

}  // namespace ceilmap::files
