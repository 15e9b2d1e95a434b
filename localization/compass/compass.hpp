#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"
#include "calib/wheels/relative_motion.hpp"

namespace ceilmap::compass {

/// A panorama as all compasses in this library take it. It shows the full circle with one column
/// per 360/W deg. Azimuth decreases from left to right and is 0 (the robot's front) in column W/2:
/// objects to the left of the robot appear to the left of objects ahead. CV_8UC1 or CV_8UC3 (BGR),
/// 8 to kMaxColumns wide, of one size and type in a run.
struct PanoramaFrame {
  cv::Mat panorama;
  double stamp_s = 0;  ///< must increase
  /// Displacement of the camera since the previous panorama, where it is known (from the ceiling
  /// map or wheel odometry): x forward and y to the left of the robot at this panorama, in any unit
  /// that stays the same. Its direction determines at which azimuths travel moves the content and
  /// at which only a turn does. An error of a tenth is harmless. Empty: the robot is assumed to
  /// drive forward or backward on arcs, as with a differential drive.
  std::optional<Eigen::Vector2d> travel = std::nullopt;
  /// Turn of the robot since the previous panorama, by wheels or a gyro, where it is known
  /// (WheelTurns). Used by FftCompass; the published methods know only panoramas.
  std::optional<wheels::RelativeTurn> turn = std::nullopt;
};

/// Result of a compass at a frame.
struct HeadingEstimate {
  /// Relative to the first frame's heading, counter-clockwise seen from above, in (-pi, pi].
  double heading_rad = 0;
  /// Variance of heading_rad, rad^2. It grows with each change of reference and decreases when an
  /// old reference is observed again. Zero at the first frame.
  double variance_rad2 = 0;
  /// 0: the panorama gives no information (it is uniform, no shift fits, or the shift contradicts
  /// the known turn); the heading is held, or turned as PanoramaFrame::turn says, and its variance
  /// has grown. 1: the panoramas agree perfectly.
  double confidence = 0;
  /// By the panorama alone, also where it was dropped because it contradicts the known turn. Its
  /// variance: of the comparison with the reference. For WheelTurns; only FftCompass sets it.
  std::optional<HeadingPrior> seen = std::nullopt;
};

/// Distance of the last panorama to its reference for every shift, as plotted in the papers.
struct DistanceProfile {
  /// Euclidean distance, grey levels, indexed by the number of columns by which the reference's
  /// content moved to the right: 0 .. W-1.
  std::vector<double> distance;
  /// The accepted shift, in [-W/2, W/2), with its fraction. Where none was accepted: any shift that
  /// was tried.
  double shift_columns = 0;
  std::int64_t reference_frame = 0;  ///< counted from 0, in the order of calls to Next
};

/// A visual compass: heading from a sequence of panoramas.
class Compass {
 public:
  virtual ~Compass() = default;

  /// Processes the next frame.
  /// @return nothing for frames that the method skips by design ("Fx n").
  /// @throws InputError on a panorama of another size or type than before, or of one that no
  ///   compass accepts, and on stamps that do not increase. Never throws on image content.
  virtual std::optional<HeadingEstimate> Next(const PanoramaFrame& frame) = 0;

  /// Profile of the last frame that was not skipped; empty before the second one. Computed on
  /// request.
  [[nodiscard]] virtual DistanceProfile Profile() const = 0;
  /// Number of times a panorama became the reference.
  [[nodiscard]] virtual std::int64_t References() const = 0;

 protected:
  Compass() = default;
  Compass(const Compass&) = default;
  Compass& operator=(const Compass&) = default;
};

}  // namespace ceilmap::compass
