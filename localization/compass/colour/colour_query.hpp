#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "calib/base/tilt.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::colour {

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

/// A compass that is asked for the heading of frames with a learned model: the interface of
/// ColourCompass (a Bayes filter) and Victoria2013Compass (the query of the paper).
class ColourQuery {
 public:
  virtual ~ColourQuery() = default;

  /// @return nothing for a frame that is skipped because too little of it is above the horizon, or
  ///   to which nothing in the model can be compared.
  /// @throws InputError on an image of another size or type, or a stamp that does not increase.
  ///   Never throws on image content.
  virtual std::optional<ColourHeading> Next(const ColourFrame& frame) = 0;
  /// Adds the frame of the last Next to the model, at a known or estimated pose; does nothing when
  /// the frame was skipped.
  virtual void Learn(const LearnedPose& pose) = 0;
  /// Returns to the initial state.
  virtual void Reset() = 0;
  [[nodiscard]] virtual const ColourModel& Model() const = 0;
  [[nodiscard]] virtual const ColourCounts& Counts() const = 0;

 protected:
  ColourQuery() = default;
  ColourQuery(const ColourQuery&) = default;
  ColourQuery(ColourQuery&&) = default;
  ColourQuery& operator=(const ColourQuery&) = default;
  ColourQuery& operator=(ColourQuery&&) = default;
};

}  // namespace ceilmap::colour
