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
  /// How far apart features are by a line that is right, as a part of the most that they can be:
  /// below it nothing is gained, > 0.
  double line_noise = 0.005;
  /// Part of the lines that show something else than what was learned in their direction: people,
  /// things that came or went, [0, 1).
  double changed_fraction = 0.3;
  /// How different the exposure may be from that of the model, standard deviation of the logarithm
  /// of pixel values, >= 0 (0: it is the same); and how much that drifts, per sqrt(s), >= 0.
  double exposure_sigma = 0.15;
  double exposure_drift = 0.01;
  /// What all lines of a frame are worth together: neighbours see the same things, > 0.
  double effective_lines = 5;
  /// A frame that shows what the one before did says nothing new: it counts in full after a turn of
  /// so much, rad > 0, ...
  double fresh_turn_rad = 0.3;
  /// ... and at the least as this part of one, (0, 1].
  double min_fresh = 0.1;
  /// Of the turn between frames: what is seen of it, rad >= 0 and a part of it >= 0.
  double turn_sigma_rad = 0.004;
  double turn_sigma_ratio = 0.02;
  /// Where no turn can be seen (dark, no overlap): standard deviation of the rate at which the
  /// robot may turn, rad/s, > 0.
  double unseen_rate_rad_s = 0.6;
  /// Of the camera ahead of the axle that the robot turns about: `a` of the rig and its own place.
  /// Turns on the spot move it, which makes them seem larger.
  double camera_ahead_of_axle_m = 0;
  /// Of the way of a robot whose place is not known, beside what is seen of it: a part of that >=
  /// 0, and m/sqrt(s) >= 0.
  double way_sigma_ratio = 0.3;
  double way_sigma_m = 0.1;
  /// The same where nothing is seen of it.
  double unseen_way_sigma_m = 1;
  /// Places that may be as far from a learned one, as a part of the depth, [0, 0.9].
  double reach = 0.75;
  /// What a cylinder cannot tell of a room: standard deviation of the heading per displacement from
  /// the learning place, as a part of the depth, >= 0, rad; for places that are found out, and for
  /// those that are given.
  double model_sigma_rad = 0.2;
  double model_sigma_known_rad = 0.06;
  /// Cells that hold at least this part of the places that the robot may be at are asked
  /// (ViCTORiA), [0, 1]; only for places that are given.
  double min_cell_ratio = 0.2;
  /// Does the parallax between the place of the robot and that of learning count? As published it
  /// does not: all things are infinitely far.
  bool parallax = true;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// A place where the robot may be, in the frame of the learned poses.
struct PlaceHypothesis {
  Eigen::Vector2d place;
  double weight = 1;  ///< > 0; their sum need not be 1
};

struct ColourFrame {
  cv::Mat bgr;         ///< CV_8UC3 of the camera's size
  double stamp_s = 0;  ///< must increase
  Tilt tilt = {};
  /// Where the robot may be; empty: not known, it is found out together with the heading.
  std::span<const PlaceHypothesis> places = {};
};

struct ColourHeading {
  double heading_rad = 0;    ///< counter-clockwise from the learned x axis, in (-pi, pi]
  double variance_rad2 = 0;  ///< of the belief
  /// Part of the belief that is within 3 sigma of the heading, times the probability that the
  /// frames show what was learned at all: below 0.9 it may be another, or a place never seen.
  double confidence = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< mean of the belief; as rough as it is
};

struct ColourCounts {
  std::int64_t used = 0;
  std::int64_t below_horizon = 0;
  std::int64_t without_turn = 0;  ///< used, but the turn since the frame before was not seen
};

/// Absolute heading by colours, from a model that was learned once: Sturm & Visser 2006 or
/// ViCTORiA, and better than both where the robot is not at the learning place.
///
/// A Bayes filter over yaw and place. Frames predict: the turn between two is measured on a strip
/// of them (StripTurn). Lines correct: each compares its colour transitions with those learned in
/// the direction that it looks to. Seen from another place than that of learning, things stand in
/// other directions; with one depth for all of them a displacement turns each direction by a known
/// angle (a cylinder of that radius), so places are told apart, and the heading is not pulled to
/// and fro.
class ColourCompass {
 public:
  /// @throws InputError on a model without anything in it, or parameters that cannot be.
  ColourCompass(ColourModel model,
                const calib::MountedCamera& forward,
                const ColourCompassParams& params = {});
  ~ColourCompass();
  ColourCompass(ColourCompass&&) noexcept;
  ColourCompass& operator=(ColourCompass&&) noexcept;

  /// @return nothing for a frame that is skipped: too little above the horizon.
  /// @throws InputError on an image of another size or type, or a stamp that does not
  ///   increase. Never throws on what the image shows.
  std::optional<ColourHeading> Next(const ColourFrame& frame);

  /// Puts the frame of the last Next into the model, at a pose that is known, or believed; nothing
  /// when it was skipped.
  void Learn(const LearnedPose& pose);

  /// As just switched on.
  void Reset();

  [[nodiscard]] const ColourModel& Model() const;
  [[nodiscard]] const ColourCounts& Counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::colour
