#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "localization/heading_track.hpp"
#include "localization/motion_model.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::localization {

struct HypothesesParams {
  int most = 8;  ///< hypotheses carried along, those with least evidence are dropped, >= 2
  /// Frames in which a place must be recognised before it is believed, >= 1.
  int confirmations = 3;
  int max_misses = 3;  ///< frames in a row in which a place is not recognised, >= 1
  /// A place is believed when the images speak for it and against every other by so many nats.
  double min_evidence = 4.5;
  /// What a frame in which a place is not recognised, but others are, says against it; nats.
  double miss_evidence = 2;
  /// Looks at the same spot tell the same again: only this part of the image's span and more of
  /// travel makes a look count in full.
  double look_ratio = 0.08;
  /// A look at the same spot confirms a place again only when it agrees as well as this, 0..1.
  double min_peak_at_rest = 0.5;
  double max_sigmas = 5;  ///< a place further from where it was expected is another one

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// What a frame says of a hypothesis.
struct MapMatch {
  PoseEstimate pose;  ///< measured
  double scale = 1;   ///< of the frame against the map, where that is estimated
  /// Other poses within the image explain it as well: it says nothing against those.
  bool disambiguated_by_prior = false;
  double peak = 0;  ///< see registration::Registration
  int inliers = 0;
  int blocks = 0;
  /// Of the frame (reference) against the map at that place.
  registration::Dissimilarity dissimilarity;
};

/// A place where the robot may be.
struct Hypothesis {
  PoseEstimate pose;
  /// Comes from what was sure a moment ago: one look confirms it, even where the ceiling repeats
  /// itself.
  bool trusted = false;
  int looks = 0;
  int confirmations = 0;    ///< looks that were not disambiguated_by_prior
  int misses = 0;           ///< frames in a row without a look
  double evidence = 0;      ///< nats against the best one of each frame, <= 0
  bool recognised = false;  ///< in the latest frame ...
  MapMatch look;            ///< ... as the latest look says
};

/// Several places where the robot may be, until one is clearly the best: a multi-hypothesis
/// tracker.
///
/// Not a particle filter: a look at the ceiling is exact to a millimetre when it is right and means
/// nothing when it is wrong, so the belief consists of a few sharp peaks that particles would miss,
/// and each look costs milliseconds, so that a hundred particles are out of reach while eight
/// hypotheses are not. What is compared is which place explains the blocks of the same frame
/// better (registration::Evidence), summed over the frames.
class Hypotheses {
 public:
  /// @param span  map units across an image.
  Hypotheses(double span, const HypothesesParams& params = {});

  void Clear();
  [[nodiscard]] const std::vector<Hypothesis>& All() const { return all_; }
  [[nodiscard]] bool Empty() const { return all_.empty(); }

  /// The robot has moved.
  /// @param sure  false: the motion may be another one; nothing is trusted any more.
  void Move(const Pose2& T_before_now, const Eigen::Matrix3d& covariance, bool sure);
  /// The robot may have moved in any direction; standard deviations in map units and radians.
  /// Hypotheses that become vaguer than half the span are dropped.
  void Spread(double sigma, double sigma_rad);

  /// The robot's yaw on the map is known, from a compass: narrows those that do not contradict it.
  void Turn(const HeadingPrior& yaw);

  /// A pose that is known, from before or from whoever switched the robot on. It is trusted where
  /// it is known to a fifth of the span; else it is a hint like others.
  void Trust(const PoseEstimate& pose);
  /// A new place, unless it is one of those already known, with the look that found it.
  void Add(const MapMatch& look);
  /// Is there one at this place?
  [[nodiscard]] bool Knows(const Pose2& T_map_base) const;

  /// Looks at every hypothesis. @param look_at  what the frame says of it, nothing when the place
  /// is not recognised.
  void MatchAll(const std::function<std::optional<MapMatch>(const Hypothesis&)>& look_at);
  /// After MatchAll and Add: weighs the places of this frame against each other and drops what
  /// has become unlikely.
  void Weigh();
  /// The hypothesis that is sure, if one is.
  [[nodiscard]] const Hypothesis* Sure() const;
  /// Was any place recognised in the latest frame?
  [[nodiscard]] bool AnyMatch() const;

 private:
  [[nodiscard]] const Hypothesis& BestOfFrame() const;
  [[nodiscard]] bool Same(const Pose2& a, const Pose2& b) const;

  double span_;
  HypothesesParams params_;
  double travelled_ = 0;        // since the latest frame that was weighed, map units
  double since_confirmed_ = 0;  // since looks last confirmed places anew
  std::vector<Hypothesis> all_;
};

}  // namespace ceilmap::localization
