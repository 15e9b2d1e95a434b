#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/base/twist2.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

/// The images of the robot's cameras at one time.
struct TiltFrame {
  cv::Mat up;       ///< CV_8UC1, as the camera took it
  cv::Mat forward;  ///< the same; empty: no image
  double stamp_s = 0;
  /// Of the robot, for an upward camera with a rolling shutter (CeilingView::Rectify).
  Twist2 velocity = {};
  registration::Encoding encoding = {};  ///< of the upward image
};

/// The measurement on which a frame's tilt is based.
enum class TiltSource {
  kNone,     ///< nothing was measured: the tilt is the prediction
  kForward,  ///< the forward camera
  kCeiling,
  kBoth
};

struct TiltEstimate {
  /// With its covariance. Both are exactly zero for a frame that the ceiling shows to be level, and
  /// for the first one, which is assumed to be.
  Tilt tilt;
  TiltSource source = TiltSource::kNone;
  /// Pitch and roll by one camera alone, before fusion.
  std::optional<TiltAngles> by_forward;
  std::optional<TiltAngles> by_ceiling;
  /// The upward image, rectified and analysed, for those who register it next (mapping::Mapper,
  /// localization::Localizer).
  registration::AnalyzedImage up;
};

/// Counts and computing time of the estimation.
struct TiltReport {
  std::int64_t frames = 0;
  std::int64_t level = 0;
  std::int64_t by_ceiling = 0;  ///< frames measured by the ceiling
  std::int64_t by_forward = 0;
  std::int64_t without_forward = 0;  ///< frames without a forward image
  std::int64_t forward_refused = 0;  ///< forward measurements rejected (something moved)
  std::int64_t unknown = 0;          ///< frames without any measurement
  std::int64_t keyframes = 0;
  std::int64_t corrected = 0;  ///< keyframes that were not level (Correct)
  double largest_rad = 0;      ///< largest tilt
  double ceiling_ms = 0;
  double forward_ms = 0;
};

/// An earlier image, rectified anew.
struct CorrectedImage {
  double stamp_s = 0;
  registration::AnalyzedImage up;
  Twist2 velocity;  ///< of base, with which it was rectified
};

}  // namespace ceilmap::compensation
