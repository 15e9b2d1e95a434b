#pragma once

#include <memory>
#include <optional>

#include "calib/rig.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/colour_query.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

struct ColourCompassParams {
  ScanLineParams lines = {};
  /// Exposure relative to that of the model: standard deviation of the logarithm of pixel values,
  /// >= 0 (0: the exposure is the same); and its drift, per sqrt(s), >= 0.
  double exposure_sigma = 0.15;
  /// Distance of the camera ahead of the axle about which the robot turns: the rig's `a` plus the
  /// camera's own position. Turns on the spot move the camera, so that the measured turns are too
  /// large.
  double camera_ahead_of_axle_m = 0;
  /// Whether the parallax between the robot's position and the learned position is modelled. The
  /// published method does not model it: all objects are infinitely far away.
  bool parallax = true;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Absolute heading from colours, with a model that was learned once: Sturm & Visser 2006 or
/// ViCTORiA, extended for robots that are not at the learned position.
///
/// A Bayes filter over yaw and position. Prediction: the turn between two frames is measured on a
/// strip of the images (StripTurn). Correction: the colour transitions of each line are compared
/// with those learned in the line's direction. From a position other than the learned one, objects
/// appear in other directions. With one depth for all objects a displacement changes each direction
/// by a known angle (a cylinder of that radius). Positions can therefore be distinguished, and the
/// heading is not biased by the displacement.
class ColourCompass final : public ColourQuery {
 public:
  /// @throws InputError on an empty model or invalid parameters.
  ColourCompass(ColourModel model,
                const calib::MountedCamera& forward,
                const ColourCompassParams& params = {});
  ~ColourCompass() override;
  ColourCompass(ColourCompass&&) noexcept;
  ColourCompass& operator=(ColourCompass&&) noexcept;

  /// @return nothing for a frame that is skipped because too little of it is above the horizon.
  /// @throws InputError on an image of another size or type, or a stamp that does not increase.
  ///   Never throws on image content.
  std::optional<ColourHeading> Next(const ColourFrame& frame) override;
  void Learn(const LearnedPose& pose) override;
  void Reset() override;
  [[nodiscard]] const ColourModel& Model() const override;
  [[nodiscard]] const ColourCounts& Counts() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::colour
