#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "localization/heading_fusion.hpp"
#include "localization/hypotheses.hpp"
#include "localization/localizer.hpp"
#include "localization/map_matcher.hpp"
#include "localization/place_finder.hpp"
#include "localization/relative_odometry.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::localization {

/// Looks for a robot of which nothing, or too little, is known, frame by frame: the part of
/// Localizer that holds several places to be possible.
class GlobalSearch {
 public:
  /// @param map, sight  must outlive the object.
  GlobalSearch(const store::MapReader& map, MapMatcher& sight, const LocalizerParams& params);

  /// Nothing is known any more; LocalizerParams::start neither.
  void Reset();
  /// The robot was at this pose a moment ago, when it saw this frame.
  void BeginAt(const PoseEstimate& pose, const LevelFrame& frame);
  /// The sight's view has changed.
  void ChangeView();

  /// What is known after one more frame.
  struct Result {
    graph::TrackingStatus status = graph::TrackingStatus::kLost;  ///< kRelocalized: it is sure
    MapMatch look;                                                ///< that made it sure
    int hypotheses = 0;                                           ///< places where the robot may be
  };
  /// @param yaw  of the robot on the map, where a compass says.
  Result Next(const LevelFrame& frame,
              const registration::FrameSpectrum& spectrum,
              const std::optional<HeadingPrior>& yaw);

  [[nodiscard]] std::int64_t Searches() const { return searches_; }

 private:
  bool Move(const LevelFrame& frame);
  [[nodiscard]] bool Wanted(const PlaceProposal& place,
                            double stamp_s,
                            const std::optional<HeadingPrior>& yaw) const;
  std::optional<MapMatch> MatchNear(const Pose2& T_map_base,
                                    const registration::FrameSpectrum& spectrum,
                                    const std::optional<PoseEstimate>& expected);
  void Relocalize(const LevelFrame& frame,
                  const registration::FrameSpectrum& spectrum,
                  const std::optional<HeadingPrior>& yaw);

  MapMatcher& sight_;
  LocalizerParams params_;
  RelativeOdometry chain_;
  PlaceFinder finder_;
  Hypotheses hypotheses_;
  std::int64_t searches_ = 0;
  bool use_start_;
  int frames_ = 0;                 // since the search began
  std::optional<double> begin_s_;  // of the search
  std::optional<double> seen_s_;   // of the last frame that the chain could place
  int ambiguous_looks_ = 0;        // places of this frame within which several poses explain it
};

}  // namespace ceilmap::localization
