#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>

#include "localization/compass/compass.hpp"
#include "localization/compass/parallax_fit.hpp"
#include "localization/compass/sector_shifts.hpp"

namespace ceilmap::compass {

struct FftCompassParams {
  /// Of each of the two fields of view, ahead and behind, in which the turn is looked for at first,
  /// in (0, 2 pi]; 2 pi: the whole view.
  double field_of_view_rad = std::numbers::pi / 3;
  /// That panoramas are averaged to beforehand, >= 1: a dozen tell as much as many.
  int rows = 15;
  SectorParams sectors;
  ParallaxParams parallax;
  /// The reference gives way when travel has moved things at the sides by more than this on
  /// average, rad, > 0, ...
  double max_parallax_rad = 0.07;
  /// ... or when fewer sectors agree, [0, 1].
  double min_inlier_ratio = 0.6;
  /// Below this a turn is not believed, [0, 1].
  double min_believed_ratio = 0.35;
  /// What a turn between two references is off by beyond what the fit says, rad, >= 0.
  double reference_sigma_rad = 0.001;
  /// References that a new one is measured against, the latest first, >= 1: drift falls.
  int recent_references = 3;
  /// References that are kept, to be recognised when the robot comes back, >= 4. About 0.2 MB each.
  int kept_references = 120;
  /// Old references that look most like a new one and are compared with it, >= 0.
  int revisits = 2;
  /// While nothing can be measured: standard deviation of the rate at which the robot may turn,
  /// rad/s, > 0.
  double unseen_rate_rad_s = 0.5;
  /// After so many frames in a row that fit no reference the robot has been carried into unknown
  /// surroundings, and a new reference begins there, >= 1.
  int restart_after = 5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Heading from panoramas, Labrosse's compass made better (localization/compass/README.md has what
/// each part is worth):
///
/// 1. Squared distances to the reference for all shifts at once (ShiftDistances), with fields of
///    view ahead and behind: the least one is the turn, roughly. Lines without their means, so that
///    light that changes evenly changes nothing.
/// 2. Shifts of 36 sectors around it (SectorMatcher), and the turn and travel that explain them
///    (FitParallax): what travel does to the sides is no bias any more but told apart. What moves
///    by itself is an outlier.
/// 3. References: a panorama is measured against one that stays until travel has changed the view.
///    A new reference is measured against several old ones, also against those that were seen long
///    ago and look alike; a graph of headings (HeadingGraph) takes the drift out again.
///
/// Memory and time per frame are bounded. Any width from 48 columns; 1080 are worth it.
class FftCompass : public Compass {
 public:
  explicit FftCompass(const FftCompassParams& params = {});
  ~FftCompass() override;
  FftCompass(FftCompass&&) noexcept;
  FftCompass& operator=(FftCompass&&) noexcept;

  std::optional<HeadingEstimate> Next(const PanoramaFrame& frame) override;
  [[nodiscard]] DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override;
  /// Of those, how many were measured against a place seen long before.
  [[nodiscard]] std::int64_t Revisits() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compass
