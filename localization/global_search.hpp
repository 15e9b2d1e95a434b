#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "localization/heading_fusion.hpp"
#include "localization/hypotheses.hpp"
#include "localization/localizer.hpp"
#include "localization/map_matcher.hpp"
#include "localization/place_finder.hpp"
#include "localization/relative_odometry.hpp"
#include "localization/submap.hpp"
#include "localization/submap_evidence.hpp"
#include "localization/submap_search.hpp"
#include "localization/velocity_estimate.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::localization {

/// Searches the map for a robot whose pose is unknown or too uncertain, frame by frame: the part of
/// Localizer that maintains several hypotheses of the place.
class GlobalSearch {
 public:
  /// @param map, matcher  Must outlive the object.
  GlobalSearch(const store::MapReader& map, MapMatcher& matcher, const LocalizerParams& params);

  /// Discards all hypotheses and begins near `start`, or anywhere on the map.
  void Reset(const std::optional<PoseWithCovariance>& start = std::nullopt);
  /// Starts from a pose, and a velocity if given, that were known a moment ago, when the robot took
  /// this frame.
  void BeginAt(const PoseWithCovariance& pose,
               const LevelFrame& frame,
               const std::optional<Twist2>& velocity);
  /// Call when the view of `matcher` has changed.
  void ChangeView();

  /// Result of the search after one more frame.
  struct Result {
    graph::TrackingStatus status = graph::TrackingStatus::kLost;  ///< kRelocalized: pose found
    MapMatch match;                                               ///< that determined the pose
    int hypotheses = 0;                                           ///< places where the robot may be
    std::vector<WeightedPose> places;                             ///< these, weights sum to 1
    /// With a pose: the robot was not recognised by this frame alone. The search goes on from
    /// there.
    bool followed = false;
    /// Of a robot that is followed, whether or not its pose is certain enough to be reported.
    std::optional<PoseWithCovariance> followed_pose;
    /// The image shows clear structure, as the frame before, but not that of the place where the
    /// robot is expected.
    bool elsewhere = false;
    std::optional<StampedTwist2> velocity;  ///< mean since the frame before, at the middle
  };
  /// What is known of a frame beside its image.
  struct Known {
    std::optional<HeadingPrior> yaw;               ///< on the map, if a compass gives it
    std::optional<wheels::RelativeMotion> wheels;  ///< since the frame before
    /// By the wheels since the robot was seen last. For a while only places there are searched.
    std::optional<PoseWithCovariance> expected;
    /// Nothing that was seen since contradicts that pose: one match confirms it.
    bool trusted = false;
    double usual_inliers = 0;  ///< Hypotheses::MatchAll
  };
  Result Next(const LevelFrame& frame,
              const registration::FrameSpectrum& spectrum,
              const Known& known);

  [[nodiscard]] std::int64_t Searches() const { return searches_; }

 private:
  /// Standard deviation of the turn rate of a robot while it cannot be measured, rad/s.
  static constexpr double kTurnNoiseWhenLost = 1.0;

  void RestartSubmap();
  void StartChain(const PoseWithCovariance& pose, const LevelFrame& frame);
  [[nodiscard]] bool MayWait(double unplaced_s) const;
  void MoveAsNow();
  bool MoveOn(const LevelFrame& frame, double unplaced_s);
  void Bridge(double unplaced_s);
  void LearnVelocity(double duration_s);
  bool Move(const LevelFrame& frame,
            const std::optional<wheels::RelativeMotion>& wheels,
            Result& result);
  void MoveByWheels(const LevelFrame& frame,
                    const std::optional<ChainStep>& step,
                    const wheels::RelativeMotion& wheels,
                    double unplaced_s);
  [[nodiscard]] bool Wanted(const PlaceProposal& place, double stamp_s, const Known& known) const;
  std::optional<MapMatch> MatchNear(const Pose2& T_map_base,
                                    const registration::FrameSpectrum& spectrum,
                                    const std::optional<PoseWithCovariance>& expected);
  [[nodiscard]] bool StartAllows(const Pose2& T_map_base, double stamp_s) const;
  [[nodiscard]] bool WheelsAllow(const Pose2& T_map_base, const Known& known) const;
  [[nodiscard]] bool WheelsKnow(const Known& known) const;
  void Extend(const LevelFrame& frame);
  void SearchSubmap(const LevelFrame& frame, const Known& known, bool expected);
  void Relocalize(const LevelFrame& frame,
                  const registration::FrameSpectrum& spectrum,
                  const Known& known);

  MapMatcher& matcher_;
  LocalizerParams params_;
  RelativeOdometry chain_;
  PlaceFinder finder_;
  Hypotheses hypotheses_;
  Submap submap_;
  SubmapSearch submap_search_;
  SubmapEvidence submap_evidence_;
  bool new_keyframe_ = false;  // of the chain, in this frame
  double searched_at_ = 0;     // travel at the latest search of the submap
  std::int64_t searches_ = 0;
  std::optional<PoseWithCovariance> start_;
  VelocityEstimate velocity_;  // of the robot at the latest frame
  int predicted_ = 0;          // consecutive frames that were placed by it alone
  double waiting_s_ = 0;       // MayWait
  std::optional<PoseWithCovariance> moved_on_from_;  // of the followed one, where MoveOn moved it
  int frames_ = 0;                                   // since the search began
  std::optional<double> begin_s_;                    // stamp of the first frame of the search
  std::optional<double> last_placed_s_;              // stamp of the last frame placed by the chain
  int ambiguous_matches_ = 0;  // places of this frame with several matching poses
};

}  // namespace ceilmap::localization
