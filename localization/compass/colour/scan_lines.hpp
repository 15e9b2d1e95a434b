#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/tilt.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::colour {

struct ScanLineParams {
  int lines = 10;  ///< a frame, >= 2
  /// Frames with less of their pixels above the horizon are skipped, [0, 1].
  double min_above_horizon = 0.6;
  double step_px =
      3;  ///< between samples of a line, > 0: neighbours that see the same tell nothing

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Scan lines of a forward camera: upright lines in the world, each at one azimuth, from the
/// horizon up to the edge of the image. Upright in the world is normal to the horizon in the
/// middle of the image; beside it, seen by a raised camera, such lines lean inwards. Robots that
/// drive on a floor see along each the same things wherever the line stands in the image.
class ScanLines {
 public:
  /// @param forward  looks within 60 deg of level. @param tilt  of the robot, where that is known.
  /// @throws InputError on a camera that cannot be.
  explicit ScanLines(const calib::MountedCamera& forward,
                     const ScanLineParams& params = {},
                     const Tilt& tilt = {});

  /// Part of the image's pixels that lie above the horizon.
  [[nodiscard]] double AboveHorizon() const { return above_horizon_; }
  /// Enough of them, and at least two lines.
  [[nodiscard]] bool Usable() const { return usable_; }
  /// Of each line, counter-clockwise from base's x axis, rad; falling: from left to right.
  [[nodiscard]] const std::vector<double>& Azimuths() const { return azimuths_; }
  /// Samples that a line has, from the horizon upwards: the first `Length(i)` of its row.
  [[nodiscard]] int Length(std::size_t line) const { return lengths_[line]; }

  /// @param bgr  CV_8UC3 of the camera's size. @param samples  CV_8UC3, a row per line; allocated
  ///   unless it fits. @throws InputError on another size or type.
  void Sample(const cv::Mat& bgr, cv::Mat& samples) const;

 private:
  cv::Size size_;
  double above_horizon_ = 0;
  bool usable_ = false;
  std::vector<double> azimuths_;
  std::vector<int> lengths_;
  calib::RemapTable table_;
};

}  // namespace ceilmap::colour
