#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ceilmap::compass {

/// A panorama as all compasses here take it: the full circle, one column per 360/W deg, and azimuth
/// falls from left to right, 0 (the robot's front) in column W/2: what stands left of the robot is
/// at the left of what stands ahead. CV_8UC1 or CV_8UC3 (BGR), 8 to kMaxColumns wide, of one size
/// and type in a run.
struct PanoramaFrame {
  cv::Mat panorama;
  double stamp_s = 0;  ///< must increase
  /// Way of the camera since the panorama before, where it is known (from the ceiling, or wheels):
  /// x ahead and y to the left of the robot at this one, in any unit that stays the same. Its
  /// direction tells where travel moves what is seen and where only a turn does; a tenth off does
  /// no harm. Nothing: the robot is taken to drive ahead or back, on arcs, as with two driven
  /// wheels.
  std::optional<Eigen::Vector2d> travel = std::nullopt;
};

/// What a compass says at a frame.
struct HeadingEstimate {
  /// Counter-clockwise seen from above, from the first frame's, in (-pi, pi].
  double heading_rad = 0;
  /// Of heading_rad, rad^2: grows with each change of reference, and falls when an old reference is
  /// seen again. Zero at the first frame.
  double variance_rad2 = 0;
  /// 0: the panorama told nothing (uniform, or no shift fits), the heading is held as predicted
  /// and its variance has grown; 1: the panoramas agree perfectly.
  double confidence = 0;
};

/// Distance of the last panorama to its reference for every shift, as the papers plot it.
struct DistanceProfile {
  /// Euclidean distance, grey levels, by columns that the reference's content moved to the right: 0
  /// .. W-1.
  std::vector<double> distance;
  /// The one that was taken, in [-W/2, W/2), with fraction; where none was believed, any that was
  /// tried.
  double shift_columns = 0;
  std::int64_t reference_frame = 0;  ///< counted from 0, in the order of calls to Next
};

/// A visual compass: heading from a sequence of panoramas.
class Compass {
 public:
  virtual ~Compass() = default;

  /// Takes the next frame.
  /// @return nothing for frames that the method skips by design ("Fx n").
  /// @throws InputError on a panorama of another size or type than before, or one that no
  ///   compass can take, and on stamps that do not increase. Never throws on image content.
  virtual std::optional<HeadingEstimate> Next(const PanoramaFrame& frame) = 0;

  /// Of the last frame that was not skipped; empty before the second one. Computed when asked for.
  [[nodiscard]] virtual DistanceProfile Profile() const = 0;
  /// How often a panorama became the reference.
  [[nodiscard]] virtual std::int64_t References() const = 0;

 protected:
  Compass() = default;
  Compass(const Compass&) = default;
  Compass& operator=(const Compass&) = default;
};

}  // namespace ceilmap::compass
