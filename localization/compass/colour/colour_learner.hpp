#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// Where a frame was taken, and how well that is known.
struct LearnedPose {
  Pose2 T_map_base;
  Tilt tilt = {};
  double sigma_m = 0.02;    ///< of the place, > 0
  double sigma_rad = 0.01;  ///< of the yaw, > 0
};

struct LearnParams {
  ModelKind kind = ModelKind::kVictoria;
  ColourClassParams classes = {};
  ScanLineParams lines = {};
  int bins = 180;
  /// Unset: 6 x 4 m about the middle of the learned places, 5 x 3 cells.
  std::optional<GridParams> grid = std::nullopt;
  /// Unset: measured from how much the turns that are seen exceed those of the robot (a camera off
  /// its axle), else ColourModel's.
  std::optional<double> depth_m = std::nullopt;
  double fading_s = 600;
  /// See ColourCompassParams; depth is measured where it is 0.05 or more.
  double camera_ahead_of_axle_m = 0;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// What became of frames.
struct LearnCounts {
  std::int64_t used = 0;
  std::int64_t below_horizon = 0;  ///< too little of them above it
};

/// Learns a model from frames at known poses. Keeps the samples of all scan lines, some 4 kB a
/// frame, until the colours are classed.
class ColourLearner {
 public:
  /// @throws InputError on parameters or a camera that cannot be.
  ColourLearner(const calib::MountedCamera& forward, const LearnParams& params = {});
  ~ColourLearner();
  ColourLearner(ColourLearner&&) noexcept;
  ColourLearner& operator=(ColourLearner&&) noexcept;

  /// @param bgr  CV_8UC3 of the camera's size. @param stamp_s  must increase.
  /// @return false for a frame that is skipped: too little above the horizon.
  /// @throws InputError on an image of another size or type.
  bool Add(const cv::Mat& bgr, double stamp_s, const LearnedPose& pose);

  [[nodiscard]] const LearnCounts& Counts() const;

  /// @throws InputError when no frame could be used, or they show too few colours.
  [[nodiscard]] ColourModel Finish() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Puts what a frame shows into a model, as both learning and updating do: each line goes to the
/// two bins that it lies between, of the cell that the robot is in.
/// @param features  of the frame, by the model's classes. @param azimuths  of its lines.
void Observe(const LineFeatures& features,
             const std::vector<double>& azimuths,
             double stamp_s,
             const LearnedPose& pose,
             ColourModel& model);

}  // namespace ceilmap::colour
