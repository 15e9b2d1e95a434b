#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/loop_closer.hpp"

namespace ceilmap::mapping {

/// Light and camera of the recordings of two parts of a map.
enum class JoinLight {
  /// Other days or cameras.
  kOther,
  /// The same: matches must fit as well as those of neighbours within each part do (MatchGate).
  kSame,
};

/// The relative pose of two parts of a map, or why it cannot be determined.
struct JoinResult {
  enum class Verdict {
    kJoined,
    kNoOverlap,    ///< the parts have no common area, or one that is too small
    kAmbiguous,    ///< several relative poses fit: the ceiling is repetitive
    kContradicts,  ///< some images agree, but most of those that should agree do not
  };
  Verdict verdict = Verdict::kNoOverlap;
  Pose2 T_a_b;  ///< p_a = T_a_b * p_b between the parts' map frames, when joined
  std::vector<graph::Edge>
      edges;           ///< from keyframes of a to keyframes of b, as measured, when joined
  int compared = 0;    ///< pairs of images
  int expected = 0;    ///< keyframes of b that should be recognized under the best relative pose
  int matched = 0;     ///< ... and were recognized
  std::string reason;  ///< readable message; empty when joined

  [[nodiscard]] bool ok() const { return verdict == Verdict::kJoined; }
};

/// Place descriptors of a keyframe (PlaceDescriber).
using DescriptorSource = std::function<cv::Mat(std::int64_t keyframe_id)>;

/// Finds the relative pose of part b and part a of a graph without a prior. Keyframes of b retrieve
/// similar keyframes of a (PlaceIndex) and are registered with them; each match gives a relative
/// pose. Matches that agree form a hypothesis. Every hypothesis is then tested by its predictions:
/// images that overlap under it must agree, and those that overlap under its rivals must not. A
/// repetitive ceiling therefore ends as ambiguous, and another room as no overlap.
///
/// Where keyframes of both parts have headings of one compass (two parts of one recording), a match
/// forms a hypothesis only if the compass does not contradict it.
///
/// @param closer  holds all keyframes of both parts and the edges within each part. Only its
/// comparisons are used; its graph is not changed.
JoinResult JoinParts(LoopCloser& closer,
                     std::span<const std::int64_t> a,
                     std::span<const std::int64_t> b,
                     const DescriptorSource& descriptors,
                     JoinLight light = JoinLight::kOther);

}  // namespace ceilmap::mapping
