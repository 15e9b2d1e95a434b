#pragma once

#include <vector>

#include "app/evaluation/statistics.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// Errors of poses in space by the definitions of evo (github.com/MichaelGrupp/evo), which follow
/// Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems". An error is itself a
/// pose E, which is the identity if there is no error.

/// A true pose and its estimate in the same frame.
struct PosePair {
  StampedPose truth;
  StampedPose estimate;
};

/// Deviation of a pose E from the identity.
struct PoseError {
  double translation_m = 0;  ///< length of E's translation ("translation part")
  double angle_rad = 0;      ///< angle of E's rotation, in [0, pi] ("rotation angle")

  /// Frobenius norm of R - I, R the rotation of E ("rotation part").
  [[nodiscard]] double RotationPart() const;
  /// Frobenius norm of E - I ("full transformation").
  [[nodiscard]] double Full() const;
};

/// E = estimate^-1 truth: the absolute pose error (APE). Quaternions need not be of unit length.
PoseError AbsoluteError(const PosePair& pair);

/// E = (truth_i^-1 truth_j)^-1 (estimate_i^-1 estimate_j): the relative pose error (RPE) of the
/// motion from i to j.
PoseError RelativeError(const PosePair& i, const PosePair& j);

struct PoseErrorStatistics {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
  ErrorStatistics rotation_block;
  ErrorStatistics full;
};
/// @param errors  At least one.
PoseErrorStatistics Statistics(const std::vector<PoseError>& errors);

}  // namespace ceilmap::evaluation
