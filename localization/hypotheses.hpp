#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "calib/base/weighted_pose.hpp"
#include "localization/chain_step.hpp"
#include "localization/heading_track.hpp"
#include "localization/motion_model.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::localization {

struct HypothesesParams {
  /// Frames in which a place must be recognised before it is accepted, >= 1.
  int confirmations = 3;
  /// A place is accepted when its evidence exceeds that of every other place by this, nats.
  double min_evidence = 4.5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Result of matching a frame with the map at one place.
struct MapMatch {
  PoseWithCovariance pose;  ///< measured
  double scale = 1;         ///< of the frame against the map, if estimated
  /// Other poses within the image explain it equally well: the match is no evidence against those.
  bool disambiguated_by_prior = false;
  double peak = 0;  ///< see registration::Registration
  int inliers = 0;
  int blocks = 0;
  /// It explains the image so well that it confirms a place again without further travel.
  bool distinct = false;
  /// An expected pose that an image of weak texture has corrected (MapMatcher::CorrectNear) ...
  bool corrected = false;
  /// ... and whether it is certain enough to be reported.
  bool sure = true;
  /// Of the frame (reference) against the map at that place.
  registration::Dissimilarity dissimilarity;
};

/// A place where the robot may be.
struct Hypothesis {
  PoseWithCovariance pose;
  /// True for a pose that was known a moment ago: one match confirms it, even on a periodic
  /// ceiling.
  bool trusted = false;
  /// The part of the pose's error, in standard deviations, that all steps since the latest match
  /// have in common: (x, y, yaw) in the map, contained in the pose's covariance.
  Eigen::Vector3d common_error = Eigen::Vector3d::Zero();
  /// The image since which the robot's own motion is measured: its pose is estimated with that of
  /// the robot, because errors of the steps since then are not independent. Nothing: not known.
  struct Keyframe {
    PoseWithCovariance pose;
    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  ///< covariance with Hypothesis::pose
    Eigen::Vector3d common_error = Eigen::Vector3d::Zero();
  };
  std::optional<Keyframe> keyframe;
  int matches = 0;
  int confirmations = 0;    ///< matches that were not disambiguated_by_prior
  int misses = 0;           ///< consecutive frames without a match
  int contradictions = 0;   ///< of them, those that show clear structure
  double evidence = 0;      ///< relative to the best place, nats, <= 0
  bool recognised = false;  ///< in the latest frame ...
  MapMatch match;           ///< ... as measured by the latest match
  double agreement = 0;     ///< inlier ratio of the latest match or correction
};

/// A multi-hypothesis tracker: several places where the robot may be, until one is clearly the
/// best.
///
/// It is not a particle filter. A correct match with the ceiling is accurate to a millimetre, and a
/// wrong match carries no information. The probability density therefore consists of a few narrow
/// peaks, which particles would miss. Each match costs milliseconds, so eight hypotheses are
/// affordable and a hundred particles are not. The tracker compares how well the places explain the
/// blocks of the same frame (registration::Evidence), summed over the frames.
class Hypotheses {
 public:
  /// @param span  Map units across an image.
  Hypotheses(double span, const HypothesesParams& params = {});

  void Clear();
  [[nodiscard]] const std::vector<Hypothesis>& All() const { return all_; }
  [[nodiscard]] bool Empty() const { return all_.empty(); }

  /// Standard deviation of the length of all steps that are measured by the ceiling, as a part of
  /// it: what is seen of a plain ceiling may all hang lower, or be higher, than the map says.
  static constexpr double kStepScaleSigma = 0.08;

  /// Applies a motion of the robot.
  /// @param unambiguous  False: the motion is ambiguous; no hypothesis is trusted any more.
  /// @param scale_sigma  Standard deviation of the length that all steps have in common.
  void Move(const Pose2& T_before_now,
            const Eigen::Matrix3d& covariance,
            bool unambiguous,
            double scale_sigma = kStepScaleSigma);
  /// Applies a motion that the ceiling shows.
  void Move(const ChainStep& step, bool unambiguous);
  /// Adds an unknown motion in any direction; standard deviations in map units and radians.
  /// Hypotheses with a standard deviation above half the span are dropped.
  void Spread(double sigma, double sigma_rad);

  /// Applies a yaw on the map, given by a compass, to the hypotheses that do not contradict it.
  void Turn(const HeadingPrior& yaw);

  /// Adds a pose known from before or from the user. It is trusted when its standard deviation is
  /// below a fifth of the span; otherwise it is a hypothesis like others.
  void Trust(const PoseWithCovariance& pose);
  /// Adds the place of a match, unless it is one of the existing hypotheses.
  void Add(const MapMatch& match);
  /// Their poses. The weights are the probabilities by the evidence, and sum to 1.
  [[nodiscard]] std::vector<WeightedPose> Places() const;
  /// True when a pose that was known is followed from frame to frame, though it may not be certain
  /// enough to be reported.
  [[nodiscard]] bool Follows() const { return Followed() != nullptr; }
  /// The hypothesis that is followed; null if there is none.
  [[nodiscard]] const Hypothesis* Followed() const;
  /// True when there is a hypothesis at this place.
  [[nodiscard]] bool Contains(const Pose2& T_map_base) const;

  /// Matches the frame at every hypothesis.
  /// @param match_at  Returns the match at a hypothesis, nothing when the place is not recognised.
  /// @param clear  The frame shows clear structure: a place that it does not show is a wrong one.
  /// @param usual_inliers  Inlier ratio, 0..1, of the last match while the robot was tracked; 0:
  /// not
  ///   known. A trusted place is confirmed by one match only if it has about as many.
  void MatchAll(const std::function<std::optional<MapMatch>(const Hypothesis&)>& match_at,
                bool clear = false,
                double usual_inliers = 0);
  /// The frame fits at another place too, where it tells no pose because it fits in several ways:
  /// it confirms no place that does not explain it better (registration::Evidence).
  /// Between MatchAll and Weigh. @param match  One of these ways.
  void FitsElsewhere(const MapMatch& match);
  /// After MatchAll and Add: compares the places of this frame with each other and drops unlikely
  /// hypotheses.
  void Weigh();
  /// The accepted hypothesis; null if there is none.
  [[nodiscard]] const Hypothesis* Accepted() const;
  /// True when any place was recognised in the latest frame.
  [[nodiscard]] bool AnyMatch() const;
  /// True when a good part of the latest frame agrees with the map at any place. A place that is
  /// known well is recognised even where nothing agrees.
  [[nodiscard]] bool AnyAgrees() const;

 private:
  [[nodiscard]] const Hypothesis& BestOfFrame() const;
  [[nodiscard]] bool Same(const Pose2& a, const Pose2& b) const;

  double span_;
  HypothesesParams params_;
  double travelled_ = 0;        // since the latest weighed frame, map units
  double since_confirmed_ = 0;  // since matches last confirmed places, map units
  std::vector<Hypothesis> all_;
};

}  // namespace ceilmap::localization
