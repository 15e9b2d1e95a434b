#pragma once

#include <optional>

#include "calib/rig.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/robot/heading_source.hpp"

namespace ceilmap::robot {

/// Headings in the frame of the learned poses (HeadingFrame::kMap), by the colours that the forward
/// camera sees. The position of the robot improves them once it is known.
class ColourHeading : public HeadingSource {
 public:
  /// @throws InputError when the rig has no forward camera, or model and camera do not fit.
  ColourHeading(colour::ColourModel model, const calib::Rig& rig);
  explicit ColourHeading(colour::ColourCompass compass);

  /// @param image  CV_8UC3 (BGR).
  /// @return nothing while several headings are possible.
  std::optional<HeadingPrior> At(double stamp_s,
                                 const Image* image,
                                 const std::optional<wheels::RelativeTurn>& turn) override;
  void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) override;
  [[nodiscard]] HeadingReport Report() const override;

 private:
  void Process(const Image& image);

  colour::ColourCompass compass_;
  std::optional<double> image_s_;                 // time of the last image
  std::optional<colour::ColourHeading> heading_;  // its heading
  std::optional<colour::PlaceHypothesis> place_;  // last known position ...
  double placed_s_ = 0;                           // ... and its time
  HeadingReport report_;
};

}  // namespace ceilmap::robot
