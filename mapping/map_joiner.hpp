#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/loop_closer.hpp"
#include "mapping/match_gate.hpp"

namespace ceilmap::mapping {

struct JoinParams {
  int candidates_per_keyframe = 6;  ///< look-alikes that a keyframe is compared with
  int max_comparisons = 4000;       ///< without any knowledge of where the parts lie
  /// Keyframes of the second part that must be recognised, each for itself, ...
  int min_matches = 3;
  /// ... and their part of those which the parts' position to each other lets expect.
  double min_match_ratio = 0.5;
  /// Another position that is confirmed by this part of the best one's matches makes both
  /// ambiguous.
  double rival_ratio = 0.5;
  int max_checks = 40;  ///< keyframes that test a position at the most
  /// Two matches say the same when they agree to this, part of what an image spans ...
  double tolerance_ratio = 0.08;
  double tolerance_rad = 0.05;  ///< ... and this: maps are bent a little against each other.
  /// The parts were seen in one light, by one camera: their matches must fit as well as neighbours
  /// in each of them do (`standard`). False for recordings of different days.
  bool same_light = false;
  MatchGateParams standard = {.remembered = 30};
};

/// How two parts of a map lie to each other, or why that cannot be said.
struct JoinResult {
  enum class Verdict {
    kJoined,
    kNoOverlap,    ///< nothing, or too little, is seen in both
    kAmbiguous,    ///< several positions fit: the ceiling repeats itself
    kContradicts,  ///< some images agree, but most that should do not
  };
  Verdict verdict = Verdict::kNoOverlap;
  Pose2 T_a_b;  ///< p_a = T_a_b * p_b between the parts' map frames, when joined
  std::vector<graph::Edge>
      edges;           ///< from keyframes of a to keyframes of b, as measured, when joined
  int compared = 0;    ///< pairs of pictures
  int expected = 0;    ///< keyframes of b that should have been recognised under the best position
  int matched = 0;     ///< ... and were
  std::string reason;  ///< in words, for a person, empty when joined

  [[nodiscard]] bool ok() const { return verdict == Verdict::kJoined; }
};

/// Place descriptors of a keyframe (PlaceDescriber).
using DescriptorSource = std::function<cv::Mat(std::int64_t keyframe_id)>;

/// Finds how part b of a graph lies to part a, of which nothing is known beforehand. Keyframes of b
/// look for their like among those of a (PlaceIndex) and are registered with them; each match says
/// where b lies. Matches that say the same make a hypothesis, and every hypothesis must then
/// predict: images that overlap under it must agree, and those of its rivals must not. So a
/// ceiling that repeats itself ends as ambiguous, and another room as no overlap.
///
/// Where keyframes of both parts have headings of one compass (two parts of one recording), only
/// matches that it does not contradict propose anything.
///
/// @param closer  holds all keyframes of both parts and the edges within each; only its
/// comparisons are used, its graph stays as it is.
JoinResult JoinParts(LoopCloser& closer,
                     std::span<const std::int64_t> a,
                     std::span<const std::int64_t> b,
                     const DescriptorSource& descriptors,
                     const JoinParams& params = {});

}  // namespace ceilmap::mapping
