#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// The pose at which a frame was taken, and its uncertainty.
struct LearnedPose {
  Pose2 T_map_base;
  Tilt tilt = {};
  double sigma_m = 0.02;    ///< of the position, > 0
  double sigma_rad = 0.01;  ///< of the yaw, > 0
  /// Positions where the robot may be as well, that of the pose among them; empty: it is known, to
  /// sigma_m.
  std::vector<PlaceHypothesis> places = {};
};

struct LearnParams {
  ModelKind kind = ModelKind::kVictoria;
  ColourClassParams classes = {};
  ScanLineParams lines = {};
  int bins = 180;
  /// Unset: 6 x 4 m centred on the learned positions, 5 x 3 cells.
  std::optional<GridGeometry> grid = std::nullopt;
  /// Unset: estimated from the ratio by which measured turns exceed those of the robot (with a
  /// camera off its axle), otherwise the default of ColourModel.
  std::optional<double> depth_m = std::nullopt;
  double fading_s = 600;
  /// See ColourCompassParams; the depth is estimated where this is 0.05 or more.
  double camera_ahead_of_axle_m = 0;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Number of frames by result.
struct LearnCounts {
  std::int64_t used = 0;
  std::int64_t below_horizon = 0;  ///< skipped: too little of the image is above the horizon
};

/// Learns a model from frames at known poses. Stores the samples of all scan lines, about 4 kB per
/// frame, until the colours are classified.
class ColourLearner {
 public:
  /// @throws InputError on invalid parameters or an invalid camera.
  ColourLearner(const calib::MountedCamera& forward, const LearnParams& params = {});
  ~ColourLearner();
  ColourLearner(ColourLearner&&) noexcept;
  ColourLearner& operator=(ColourLearner&&) noexcept;

  /// @param bgr  CV_8UC3 of the camera's size.
  /// @param stamp_s  Must increase.
  /// @return false for a frame that is skipped because too little of it is above the horizon.
  /// @throws InputError on an image of another size or type.
  bool Add(const cv::Mat& bgr, double stamp_s, const LearnedPose& pose);

  [[nodiscard]] const LearnCounts& Counts() const;

  /// @throws InputError when no frame could be used, or when they contain too few colours.
  [[nodiscard]] ColourModel Finish() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Adds the content of a frame to a model, both for learning and for updating: each line is added
/// to the two bins nearest to it, in the cell that contains the robot. ModelKind::kVictoria2013: by
/// Replace.
/// @param features  Features of the frame, by the model's classes.
/// @param azimuths  Azimuths of its lines.
void Observe(const LineFeatures& features,
             const std::vector<double>& azimuths,
             double stamp_s,
             const LearnedPose& pose,
             ColourModel& model);

/// The update of ViCTORiA (Methenitis et al. 2013, section 3.4): each line is a feature of the one
/// bin that contains its direction, and replaces the feature there if m(f_new) > m(f_old), both at
/// `stamp_s` (FadedCertainty). m(f_new) = p(l) p(alpha); the paper states no formula for the two.
/// Here they are 1 / (1 + (sigma / scale)^2), with a scale of 0.5 m and of a bin's width. Where the
/// robot may be at several places, p(l) is the share of their weights in the cell ("the number of
/// hypotheses, in a grid cell").
void Replace(const LineFeatures& features,
             const std::vector<double>& azimuths,
             double stamp_s,
             const LearnedPose& pose,
             ColourModel& model);

}  // namespace ceilmap::colour
