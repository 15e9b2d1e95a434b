#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"
#include "tests/faults/recording.hpp"
#include "tests/support/child_process.hpp"

namespace ceilmap::faults {

/// What stands under a map's name after a run.
enum class MapState {
  kOld,  ///< bit by bit what stood there before
  kNew,  ///< another map, which opens and contains all poses of its metadata
  kLost  ///< neither
};

/// What the program did, and how right it was.
struct Outcome {
  int exit_code = 0;
  /// Its message after a failure; "" after success.
  std::string message;
  /// Exit code 0, 1 or 2; when it is not 0, one line on stderr gives the reason.
  bool orderly = false;
  int shots = 0;      ///< images of the recording
  int placed = 0;     ///< that got a pose
  double rmse_m = 0;  ///< of these, against where their images were taken
  double largest_m = 0;
  /// Accepted although wrong: an error of more than 0.05 m or 0.02 rad, and by more than four of
  /// the standard deviations that are claimed.
  int wrong = 0;
  MapState map = MapState::kOld;

  [[nodiscard]] double Coverage() const;
  /// No crash, no wrong pose, no map lost.
  [[nodiscard]] bool Survived() const { return orderly && wrong == 0 && map != MapState::kLost; }
};

/// What the run left, judged as all runs are.
Outcome OutcomeOf(const support::ProcessResult& result, const Recording& shots);

/// A pose that the program accepted.
struct Estimate {
  double stamp_s = 0;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance;
};

/// The trajectory of a map file, without the poses that wheels alone predict; so is the next.
std::vector<Estimate> PosesOfMap(const std::filesystem::path& map);
/// The poses of a file of --status.
std::vector<Estimate> PosesOfStatus(const std::filesystem::path& file);

/// T_room_map, by least squares over the positions of the estimates, weighted by their stated
/// variance (at least 5 mm): a part that is known to be uncertain must not move a sure one.
Pose2 FitMap(const std::vector<Estimate>& estimates, const Recording& shots);
/// Adds the estimates' errors to the outcome. A pose at a stamp that no image has is as wrong as
/// can be.
void Score(const std::vector<Estimate>& estimates,
           const Recording& shots,
           const Pose2& T_room_map,
           Outcome& outcome);

}  // namespace ceilmap::faults
