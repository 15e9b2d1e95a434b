#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/colour/colour_model.hpp"
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

/// A possible position of the robot, in the frame of the learned poses.
struct PlaceHypothesis {
  Eigen::Vector2d place;
  double weight = 1;  ///< > 0; the weights need not sum to 1
};

struct ColourFrame {
  cv::Mat bgr;         ///< CV_8UC3 of the camera's size
  double stamp_s = 0;  ///< must increase
  Tilt tilt = {};
  /// Possible positions of the robot; empty: unknown, the position is estimated together with the
  /// heading.
  std::span<const PlaceHypothesis> places = {};
};

struct ColourHeading {
  double heading_rad = 0;    ///< counter-clockwise from the learned x axis, in (-pi, pi]
  double variance_rad2 = 0;  ///< of the estimated distribution
  /// Probability mass within 3 sigma of the heading, times the probability that the frames show the
  /// learned surroundings at all. Below 0.9 the heading may be wrong, or the place may never have
  /// been learned.
  double confidence = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< mean of the estimated distribution; a rough
                                                    ///< position
};

struct ColourCounts {
  std::int64_t used = 0;
  std::int64_t below_horizon = 0;
  std::int64_t without_turn = 0;  ///< used, but the turn since the previous frame was not measured
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
class ColourCompass {
 public:
  /// @throws InputError on an empty model or invalid parameters.
  ColourCompass(ColourModel model,
                const calib::MountedCamera& forward,
                const ColourCompassParams& params = {});
  ~ColourCompass();
  ColourCompass(ColourCompass&&) noexcept;
  ColourCompass& operator=(ColourCompass&&) noexcept;

  /// @return nothing for a frame that is skipped because too little of it is above the horizon.
  /// @throws InputError on an image of another size or type, or a stamp that does not increase.
  ///   Never throws on image content.
  std::optional<ColourHeading> Next(const ColourFrame& frame);

  /// Adds the frame of the last Next to the model, at a known or estimated pose; does nothing when
  /// the frame was skipped.
  void Learn(const LearnedPose& pose);

  /// Returns to the initial state.
  void Reset();

  [[nodiscard]] const ColourModel& Model() const;
  [[nodiscard]] const ColourCounts& Counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::colour
