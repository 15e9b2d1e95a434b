#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/tilt.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::colour {

struct ScanLineParams {
  int lines = 10;  ///< per frame, >= 2
  /// Frames with a smaller fraction of their pixels above the horizon are skipped, [0, 1].
  double min_above_horizon = 0.6;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Scan lines of a forward camera: vertical lines in the world, each at one azimuth, from the
/// horizon up to the edge of the image. In the middle of the image they are perpendicular to the
/// horizon; towards the sides, in a camera that is pitched up, they lean inwards. For a robot that
/// drives on a floor, a line shows the same objects at any position in the image.
class ScanLines {
 public:
  /// @param forward  Its optical axis is within 60 deg of horizontal.
  /// @param tilt  Tilt of the robot, where it is known.
  /// @throws InputError on an invalid camera.
  explicit ScanLines(const calib::MountedCamera& forward,
                     const ScanLineParams& params = {},
                     const Tilt& tilt = {});

  /// Fraction of the image's pixels that lie above the horizon.
  [[nodiscard]] double AboveHorizon() const { return above_horizon_; }
  /// Whether this fraction is sufficient, with at least two lines.
  [[nodiscard]] bool Usable() const { return usable_; }
  /// Azimuth of each line, counter-clockwise from base's x axis, rad; decreasing, i.e. from left to
  /// right.
  [[nodiscard]] const std::vector<double>& Azimuths() const { return azimuths_; }
  /// Number of samples of a line, from the horizon upwards: the first `Length(i)` of its row.
  [[nodiscard]] int Length(std::size_t line) const { return lengths_[line]; }

  /// @param bgr  CV_8UC3 of the camera's size.
  /// @param samples  CV_8UC3, a row per line; allocated unless it already has the right size.
  /// @throws InputError on another size or type.
  void Sample(const cv::Mat& bgr, cv::Mat& samples) const;

 private:
  cv::Size size_;
  double above_horizon_ = 0;
  bool usable_ = false;
  std::vector<double> azimuths_;
  std::vector<int> lengths_;
  calib::RemapTable table_;
};

/// Scan lines of the tilt asked for last: they are made anew only when it changes.
class ScanLinesByTilt {
 public:
  /// As ScanLines.
  ScanLinesByTilt(calib::MountedCamera forward, const ScanLineParams& params);

  /// @return copy it to keep the lines beyond the next call. @throws as ScanLines.
  const std::shared_ptr<const ScanLines>& For(const Tilt& tilt);
  /// Those of the last For, which must have been called.
  [[nodiscard]] const ScanLines& Latest() const { return *lines_; }

 private:
  calib::MountedCamera forward_;
  ScanLineParams params_;
  Tilt tilt_;
  std::shared_ptr<const ScanLines> lines_;
};

}  // namespace ceilmap::colour
