#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// How an estimate is brought into the frame of the truth before positions are compared.
enum class Alignment {
  kNone,   ///< not at all: both are in one frame already
  kFirst,  ///< the first matched poses coincide
  kSe2,    ///< the rigid planar motion with the least squared position error; no scale
};

struct EvaluationParams {
  Alignment align = Alignment::kSe2;
  double max_dt_s = 0.02;  ///< poses further apart in time are not compared, >= 0
};

/// Of absolute values.
struct ErrorStatistics {
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double p95 = 0;  ///< linear between the neighbouring ranks
  double max = 0;
};
/// @param errors  at least one.
ErrorStatistics Statistics(std::vector<double> errors);

/// Errors of an estimated trajectory in the plane.
struct TrajectoryErrors {
  std::int64_t matched = 0;
  std::int64_t expected = 0;  ///< poses of the truth
  double path_m = 0;          ///< length of the true path
  ErrorStatistics position_m;
  ErrorStatistics yaw_deg;
  /// Of the motion over each metre of the true path, free of any alignment; unset when the matched
  /// path is shorter.
  std::optional<ErrorStatistics> per_metre_m;
  std::optional<ErrorStatistics> per_metre_yaw_deg;

  [[nodiscard]] double Coverage() const {
    return expected > 0 ? static_cast<double>(matched) / static_cast<double>(expected) : 0;
  }
};

/// Compares poses nearest in time, each used once.
/// @param truth, estimate  stamps strictly increasing, at least one pose each.
/// @return unset when no two poses are within max_dt_s.
std::optional<TrajectoryErrors> EvaluateTrajectory(const std::vector<StampedPose>& truth,
                                                   const std::vector<StampedPose>& estimate,
                                                   const EvaluationParams& params = {});

}  // namespace ceilmap::evaluation
