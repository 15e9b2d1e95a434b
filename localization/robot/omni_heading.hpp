#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/mirror_view.hpp"
#include "calib/rig.hpp"
#include "localization/compass/compass.hpp"
#include "localization/compass/travel_forecast.hpp"
#include "localization/robot/heading_source.hpp"

namespace ceilmap::robot {

/// Relative headings from the camera under a convex mirror, by a visual compass.
class OmniHeading : public HeadingSource {
 public:
  /// The compass of this library that is best without a known path (compass::FftCompass).
  /// @throws InputError when the rig has no camera 'omni' or its panorama is not in the image.
  explicit OmniHeading(const calib::Rig& rig);
  /// @param position  of the mirror on the robot, base frame, m.
  OmniHeading(calib::MirrorView view,
              std::unique_ptr<compass::Compass> compass,
              const Eigen::Vector2d& position);

  /// Adds the possible turn between the times of frame and image to the variance.
  std::optional<HeadingPrior> At(double stamp_s,
                                 const Image* image,
                                 const std::optional<wheels::RelativeTurn>& turn) override;
  void Locate(double stamp_s, const std::optional<Pose2>& T_map_base) override;
  [[nodiscard]] HeadingReport Report() const override;

 private:
  void Process(const Image& image, const std::optional<wheels::RelativeTurn>& turn);

  calib::MirrorView view_;
  std::unique_ptr<compass::Compass> compass_;
  compass::TravelForecast travel_;
  cv::Mat panorama_;
  std::optional<double> image_s_;                     // time of the last image
  std::optional<compass::HeadingEstimate> estimate_;  // the last one ...
  double estimate_s_ = 0;                             // ... and its time
  double turn_rate_rad_s_ = 0;                        // before it
  HeadingReport report_;
};

}  // namespace ceilmap::robot
