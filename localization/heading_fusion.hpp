#pragma once

#include <optional>

#include "localization/heading_track.hpp"

namespace ceilmap::localization {

struct HeadingParams {
  /// False: headings are of the map (a compass that was taught there). True: their zero is unknown,
  /// e.g. the first frame's heading; it is learnt as soon as the robot's pose is known.
  bool unknown_zero = true;
  /// How fast the zero wanders off: variance it gains in a second, rad^2/s, >= 0. The default
  /// means 1.5 degrees in a minute.
  double drift_rad2_per_s = 1e-5;
  /// What a single heading is off at the least, whatever its variance claims, rad, > 0. Of headings
  /// with an unknown zero, the drift up to the moment when it was learnt cancels
  /// (TurnBetween); this does not.
  double noise_rad = kHeadingNoise;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Brings measured headings into the map's frame, so that they can tell places apart that look
/// the same (a ceiling of square tiles looks alike after every quarter turn).
class HeadingFusion {
 public:
  /// @throws InputError for impossible parameters.
  explicit HeadingFusion(const HeadingParams& params = {});

  /// The robot's yaw on the map by the measured heading; nothing while the zero is unknown. Every
  /// heading should come here, in order of time: their variances tell how far the compass has
  /// drifted since the zero was learnt.
  std::optional<HeadingPrior> InMap(const HeadingPrior& measured, double stamp_s);
  /// Learns the zero from a frame whose pose is known. Only the latest one counts: errors of a
  /// compass last from frame to frame, so a mean would not be better than it looks.
  void Learn(const HeadingPrior& measured,
             double yaw_map_rad,
             double yaw_variance_rad2,
             double stamp_s);
  /// The zero is not known any more. Headings of the map stay what they are.
  void Forget();

 private:
  HeadingParams params_;
  HeadingSince since_;  // the zero was learnt
  bool known_ = false;
  double yaw_rad_ = 0;  // on the map, then
  double yaw_variance_rad2_ = 0;
  double stamp_s_ = 0;
};

}  // namespace ceilmap::localization
