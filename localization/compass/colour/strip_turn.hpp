#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::colour {

/// How far the robot turned between two frames.
struct SeenTurn {
  double turn_rad =
      0;  ///< counter-clockwise. Off the axle the camera also moves: a little too much
  /// Way ahead as a part of the depth of what is seen (in metres when that is 1 m): what stands
  /// left moved to the left and what stands right to the right.
  double ahead = 0;
  /// Squared difference of what both frames show, as a part of what they vary: 0 agrees, 1 does
  /// not.
  double difference = 1;
};

/// The turn of a robot between frames of its forward camera, from a strip above the horizon in
/// which a column is an azimuth: a turn moves it sideways. Travel moves near things otherwise; the
/// best shift is that of most of the image.
class StripTurn {
 public:
  /// @param forward  see ScanLines.
  explicit StripTurn(const calib::MountedCamera& forward);

  /// Takes the next frame, CV_8UC3 of the camera's size.
  /// @return nothing for the first one, and when nothing agrees: more than half of the field of
  /// view
  ///   has changed, or there is nothing to see. About 0.5 ms.
  std::optional<SeenTurn> Next(const cv::Mat& bgr);
  /// The next frame is the first one.
  void Reset() { before_.release(); }

 private:
  double column_rad_ = 0;
  double ahead_per_rad_ = 0;  // of the shifts of both halves against each other
  calib::RemapTable table_;
  cv::Mat colours_;
  cv::Mat grey_;
  cv::Mat now_;     // CV_32FC1, rows without their means
  cv::Mat before_;  // the same of the frame before
};

}  // namespace ceilmap::colour
