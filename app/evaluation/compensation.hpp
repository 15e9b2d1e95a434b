#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/statistics.hpp"
#include "calib/base/pose2.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// The benefit of tilt compensation, as tabulated by Matsumoto et al. 2010 ("Visual compensation in
/// localization of a robot on a ceiling map"): the largest errors along and across the path before
/// and after compensation, and their ratio.
///
/// Two trajectories of one run are aligned to the truth by one planar motion, which is fitted to
/// the level part of BEFORE. An alignment over all frames would hide part of the errors of tilted
/// frames. Trajectories of two runs have maps of their own: each is aligned by its own level part.

struct CompensationParams {
  double max_dt_s = 0.02;        ///< poses further apart in time are not compared, >= 0
  double level_below_deg = 0.2;  ///< limit of the true pitch and roll of a level frame, absolute
                                 ///< values, > 0
};

/// Alignment of BEFORE with the truth.
struct LevelAlignment {
  std::int64_t matched = 0;  ///< poses of BEFORE with a true pose
  std::int64_t level = 0;    ///< those of them at which the robot is level
  /// p_truth = T_truth_before * p_before; unset with fewer than two level frames.
  std::optional<Pose2> T_truth_before;
};

/// @param truth, before  Stamps strictly increasing, at least one pose each. This holds for all
///   functions below.
LevelAlignment AlignLevelFrames(const std::vector<StampedPose>& truth,
                                const std::vector<StampedPose>& before,
                                const CompensationParams& params = {});

/// An aligned position and its error.
struct PlacedError {
  Eigen::Vector2d p_truth = Eigen::Vector2d::Zero();  ///< metres, in the frame of the truth
  double along_m = 0;                                 ///< > 0: ahead of the true position ...
  double across_m = 0;                                ///< ... left of it, by the true yaw
};

struct TiltDegrees {
  double pitch_deg = 0;  ///< > 0: nose down
  double roll_deg = 0;   ///< > 0: left side up
};

/// One frame of the truth with the errors of both trajectories.
struct CompensatedFrame {
  double stamp_s = 0;
  Eigen::Vector2d p_truth = Eigen::Vector2d::Zero();
  TiltDegrees true_tilt;
  std::optional<PlacedError> before;
  std::optional<PlacedError> after;
  std::optional<TiltDegrees> tilt;  ///< estimated; set where `after` is
};

/// Errors of one trajectory's aligned positions; the maxima are of absolute values.
struct PathErrors {
  std::int64_t matched = 0;
  std::int64_t expected = 0;  ///< poses of the truth
  double max_along_m = 0;
  double max_across_m = 0;
  double max_m = 0;  ///< distance from the true position
  double rmse_m = 0;
};

/// AFTER divided by BEFORE, for each field of PathErrors.
struct CompensationRatio {
  double max_along = 0;
  double max_across = 0;
  double max = 0;
  double rmse = 0;
};

struct Compensation {
  PathErrors before;
  PathErrors after;
  CompensationRatio ratio;
  ErrorStatistics pitch_deg;             ///< estimated minus true
  ErrorStatistics roll_deg;              ///< the same
  std::vector<CompensatedFrame> frames;  ///< one for each pose of the truth
};

/// @param T_truth_before  From AlignLevelFrames.
/// @param T_truth_after  The same for `after` where it is of another run; unset: T_truth_before.
/// @return unset when `before` or `after` has no pose within max_dt_s of a true one.
std::optional<Compensation> CompareCompensation(
    const std::vector<StampedPose>& truth,
    const std::vector<StampedPose>& before,
    const std::vector<StampedPose>& after,
    const Pose2& T_truth_before,
    const CompensationParams& params = {},
    const std::optional<Pose2>& T_truth_after = std::nullopt);

/// Largest absolute pitch and roll of a trajectory.
TiltDegrees LargestTilt(const std::vector<StampedPose>& poses);

}  // namespace ceilmap::evaluation
