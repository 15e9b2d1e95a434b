#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::colour {

/// The measured turn of the robot between two frames.
struct MeasuredTurn {
  double turn_rad = 0;  ///< counter-clockwise. Slightly too large if the camera is off the axle,
                        ///< because it also moves
  /// Distance travelled forward as a ratio of the depth of the scene (in metres when that is 1 m):
  /// objects on the left moved to the left, and objects on the right to the right.
  double ahead = 0;
  /// Squared difference of the content common to both frames, as a ratio of its variance: 0 for
  /// agreement, 1 for no agreement.
  double difference = 1;
};

/// The turn of a robot between frames of its forward camera, from a strip above the horizon in
/// which each column is one azimuth: a turn moves the strip sideways. Travel moves near objects
/// differently; the best shift is that of most of the image.
class StripTurn {
 public:
  /// @param forward  As for ScanLines.
  explicit StripTurn(const calib::MountedCamera& forward);

  /// Processes the next frame, CV_8UC3 of the camera's size.
  /// @return nothing for the first frame, and when nothing agrees: more than half of the field of
  ///   view has changed, or there is no texture. Takes about 0.5 ms.
  std::optional<MeasuredTurn> Next(const cv::Mat& bgr);
  /// Makes the next frame the first one.
  void Reset() { before_.release(); }

 private:
  double column_rad_ = 0;
  double ahead_per_rad_ = 0;  // from the relative shift of both halves
  calib::RemapTable table_;
  cv::Mat colours_;
  cv::Mat grey_;
  cv::Mat now_;     // CV_32FC1, rows with their means subtracted
  cv::Mat before_;  // the same of the previous frame
};

}  // namespace ceilmap::colour
