#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/alignment.hpp"
#include "app/evaluation/pose_errors.hpp"
#include "app/evaluation/relative_errors.hpp"
#include "app/evaluation/statistics.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

struct EvaluationParams {
  Alignment align = Alignment::kSe2;
  /// The known transform from the estimate to the truth; `align` is not used then.
  std::optional<Similarity2> T_truth_estimate = std::nullopt;
  double max_dt_s = 0.02;  ///< poses further apart in time are not compared, >= 0
  SegmentParams segments = {};
  /// Number of expected poses; unset: as many as the truth has.
  std::optional<std::int64_t> expected = std::nullopt;
};

/// Errors of one pose of an estimate, in the plane and in the frame of the truth.
struct FrameError {
  std::size_t truth = 0;     ///< index of the pose in the truth
  std::size_t estimate = 0;  ///< index in the estimate
  double stamp_s = 0;        ///< of the truth
  double distance_m = 0;     ///< distance along the true path from its first pose
  Pose2 T_truth_base;        ///< the estimated pose, aligned
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();  ///< estimated minus true position
  double position_m = 0;                              ///< its length
  double along_m = 0;    ///< > 0: ahead of the true position, by the true yaw ...
  double across_m = 0;   ///< ... > 0: left of it
  double yaw_deg = 0;    ///< estimated minus true, in (-180, 180]
  double pitch_deg = 0;  ///< the same
  double roll_deg = 0;   ///< the same
  PoseError pose;        ///< in space
};

/// Errors of an estimated trajectory.
struct TrajectoryErrors {
  std::int64_t matched = 0;
  std::int64_t expected = 0;
  double path_m = 0;  ///< length of the true path over the floor
  Similarity2 T_truth_estimate;
  std::vector<FrameError> frames;  ///< by rising stamps

  ErrorStatistics position_m;
  ErrorStatistics yaw_deg;
  /// Errors of the motion over each metre of the true path, in the plane, starting at each pose;
  /// unset when the matched path is shorter.
  std::optional<ErrorStatistics> per_metre_m;
  std::optional<ErrorStatistics> per_metre_yaw_deg;

  bool tilted = false;       ///< the truth or the estimate is not always level and at height 0
  PoseErrorStatistics pose;  ///< in space, evo's APE
  /// evo's RPE; unset where no motion has the required length. Metres are measured along the
  /// estimate's path.
  std::optional<PoseErrorStatistics> per_frame;
  std::optional<PoseErrorStatistics> per_metre;            ///< consecutive motions
  std::optional<PoseErrorStatistics> per_metre_all_pairs;  ///< from every pose
  std::vector<SegmentErrors> segments;

  /// Fraction of the expected poses that the estimate contains.
  [[nodiscard]] double Coverage() const {
    return expected > 0 ? static_cast<double>(matched) / static_cast<double>(expected) : 0;
  }
};

/// Compares poses nearest in time, each used once.
/// @param truth, estimate  Stamps strictly increasing, at least one pose each.
/// @return unset when no two poses are within max_dt_s. Cost: n log n, about 700 bytes per pose.
std::optional<TrajectoryErrors> EvaluateTrajectory(const std::vector<StampedPose>& truth,
                                                   const std::vector<StampedPose>& estimate,
                                                   const EvaluationParams& params = {});

}  // namespace ceilmap::evaluation
