#pragma once

#include <optional>

#include "localization/heading_track.hpp"

namespace ceilmap::localization {

struct HeadingParams {
  /// Drift of the estimated zero of relative headings: growth of its variance per second, rad^2/s,
  /// >= 0. The default corresponds to 1.5 degrees in a minute.
  double drift_rad2_per_s = 1e-5;
  /// Minimum standard deviation of a single heading, whatever its stated variance, rad, > 0. For
  /// headings with an unknown zero, the drift up to the moment when the zero was estimated cancels
  /// (TurnBetween); this noise does not.
  double noise_rad = kHeadingNoise;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Transforms measured headings into the map's frame. There they resolve the perceptual aliasing of
/// places (a ceiling of square tiles has the same appearance after every quarter turn). The zero of
/// relative headings is estimated as soon as the pose of the robot is known.
class HeadingFusion {
 public:
  /// @throws InputError for invalid parameters.
  explicit HeadingFusion(const HeadingParams& params = {});

  /// The robot's yaw on the map from the measured heading, with `frame` as measured; nothing while
  /// the zero is unknown. Pass
  /// every heading, in order of time: their variances determine the drift of the compass since the
  /// zero was estimated.
  std::optional<HeadingPrior> InMap(const HeadingPrior& measured, double stamp_s);
  /// Estimates the zero from a frame of known pose. Only the latest estimate is used: the errors of
  /// a compass are correlated from frame to frame, so a mean would not be as exact as its computed
  /// variance.
  void Learn(const HeadingPrior& measured,
             double yaw_map_rad,
             double yaw_variance_rad2,
             double stamp_s);
  /// Discards the zero. Headings in the map's frame do not change.
  void Forget();

 private:
  HeadingParams params_;
  HeadingSince since_;  // since the zero was estimated
  bool known_ = false;
  double yaw_rad_ = 0;  // on the map, when the zero was estimated
  double yaw_variance_rad2_ = 0;
  double stamp_s_ = 0;
};

}  // namespace ceilmap::localization
