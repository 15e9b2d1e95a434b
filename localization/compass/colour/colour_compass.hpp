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
  /// Expected dissimilarity of the features of a correct line, as a ratio of the largest possible
  /// dissimilarity; smaller differences do not raise the likelihood, > 0.
  double line_noise = 0.005;
  /// Expected fraction of the lines that differ from what was learned in their direction (people,
  /// objects added or removed), [0, 1).
  double changed_fraction = 0.3;
  /// Exposure relative to that of the model: standard deviation of the logarithm of pixel values,
  /// >= 0 (0: the exposure is the same); and its drift, per sqrt(s), >= 0.
  double exposure_sigma = 0.15;
  double exposure_drift = 0.01;
  /// Number of independent lines that all lines of a frame together are equivalent to, because
  /// neighbouring lines observe the same objects, > 0.
  double effective_lines = 5;
  /// A frame that shows the same content as the previous one contains no new information. A frame
  /// has full weight after a turn of this angle, rad > 0, ...
  double fresh_turn_rad = 0.3;
  /// ... and at least this fraction of the full weight otherwise, (0, 1].
  double min_fresh = 0.1;
  /// Standard deviation of the measured turn between frames: a constant, rad >= 0, and a ratio of
  /// the turn, >= 0.
  double turn_sigma_rad = 0.004;
  double turn_sigma_ratio = 0.02;
  /// Standard deviation of the robot's turn rate where no turn can be measured (darkness, no
  /// overlap), rad/s, > 0.
  double unseen_rate_rad_s = 0.6;
  /// Distance of the camera ahead of the axle about which the robot turns: the rig's `a` plus the
  /// camera's own position. Turns on the spot move the camera, so that the measured turns are too
  /// large.
  double camera_ahead_of_axle_m = 0;
  /// Standard deviation of the distance travelled by a robot with unknown position, in addition to
  /// the measured motion: a ratio of that motion, >= 0, and m/sqrt(s), >= 0.
  double way_sigma_ratio = 0.3;
  double way_sigma_m = 0.1;
  /// The same where the motion cannot be measured, m/sqrt(s).
  double unseen_way_sigma_m = 1;
  /// Largest distance of a possible position from a learned one, as a ratio of the depth, [0, 0.9].
  double reach = 0.75;
  /// Error of the cylinder as a model of the room: standard deviation of the heading per
  /// displacement from the learned position (as a ratio of the depth), >= 0, rad; for estimated
  /// positions, and for given positions.
  double model_sigma_rad = 0.2;
  double model_sigma_known_rad = 0.06;
  /// Only cells that contain at least this fraction of the total weight of the possible positions
  /// are compared (ViCTORiA), [0, 1]. Used for given positions only.
  double min_cell_ratio = 0.2;
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
