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
  /// Width of each of the two fields of view, ahead and behind, in which the initial estimate of
  /// the turn is searched, in (0, 2 pi]; 2 pi: the whole view.
  double field_of_view_rad = std::numbers::pi / 3;
  /// Number of recent references that a new one is measured against, the latest first, >= 1. More
  /// references reduce drift.
  int recent_references = 3;
  /// Number of references that are kept for recognition when the robot returns, >= 4. About 0.2 MB
  /// each.
  int kept_references = 120;
  /// Number of old references, most similar to a new one, that are compared with it, >= 0.
  int revisits = 2;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Heading from panoramas, an improvement of Labrosse's compass. localization/compass/README.md
/// states what each part contributes.
///
/// 1. Squared distances to the reference for all shifts at once (ShiftDistances), within fields of
///    view ahead and behind. The minimum is the initial estimate of the turn. Each line is taken
///    without its mean, so that a uniform change of illumination has no effect.
/// 2. Shifts of 36 sectors around this estimate (SectorMatcher), and the turn and travel that
///    explain them (FitParallax). The effect of travel on the sides is estimated instead of causing
///    a bias. Objects that move independently are outliers.
/// 3. References: a panorama is measured against a reference that is kept until travel has changed
///    the view. A new reference is measured against several old ones, including references from
///    long ago that are similar. A graph of headings (HeadingGraph) corrects the drift.
/// 4. Where the turn between frames is known (PanoramaFrame::turn): it predicts each frame, is an
///    edge of the graph between references, and goes on where nothing is seen. A frame that
///    contradicts it is dropped. Wheels that slipped are found out by five frames that all
///    contradict them by the same angle.
///
/// Memory and time per frame are bounded. Any width from 48 columns; 1080 columns are recommended.
class FftCompass : public Compass {
 public:
  explicit FftCompass(const FftCompassParams& params = {});
  ~FftCompass() override;
  FftCompass(FftCompass&&) noexcept;
  FftCompass& operator=(FftCompass&&) noexcept;

  std::optional<HeadingEstimate> Next(const PanoramaFrame& frame) override;
  [[nodiscard]] DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override;
  /// Number of references that were measured against a place observed long before.
  [[nodiscard]] std::int64_t Revisits() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compass
