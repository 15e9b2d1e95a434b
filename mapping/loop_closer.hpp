#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/heading_trust.hpp"
#include "mapping/loop_candidates.hpp"
#include "mapping/loop_verifier.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mapping {

struct LoopCloserParams {
  LoopCandidatesParams candidates;   ///< selection of the keyframes to compare
  int comparisons_per_keyframe = 5;  ///< largest number of registrations; bounds the work
  int closures_per_keyframe = 3;
  LoopVerifierParams judge;  ///< acceptance of closures
  EdgeNoise noise;
  HeadingTrust heading;  ///< used where keyframes have headings
  registration::RegistrarParams registration;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Detects loop closures: keyframes that show the same part of the ceiling as an earlier one.
/// Candidates are the keyframes whose images overlap the new one's by position, or, where the
/// position has become too uncertain for that, those of similar appearance (LoopCandidates). Each
/// candidate is checked by registration and for consistency with the graph (LoopVerifier). On a
/// periodic ceiling several motions fit. The prediction selects one of them where it is accurate
/// enough (a few standard deviations within half a period). Otherwise the pair is rejected and
/// counted as ambiguous.
///
/// Where keyframes have headings (FramePose::heading), the compass bounds the uncertainty of the
/// rotation between any two keyframes, whatever the length and uncertainty of the path between
/// them. Matches with an error of a quarter turn are rejected.
///
/// Work per keyframe is bounded: a few registrations, and a pose graph over the last few keyframes.
/// Not thread-safe; it may run in its own thread in parallel with the odometry.
class LoopCloser {
 public:
  /// @param view  must outlive the closer. @param load  called when a keyframe's image is not in
  /// the cache.
  LoopCloser(const calib::CeilingView& view,
             graph::ImageLoader load,
             const LoopCloserParams& params = {});
  ~LoopCloser();

  /// Adds a keyframe with its pose from a recording's odometry (or from a map), and the edges that
  /// connect it with earlier keyframes. Without edges it begins its own segment at its pose.
  /// @param spectrum  of its image; empty: loaded when needed.
  /// @param descriptors  PlaceDescriber's of its image; empty: place recognition does not find it.
  void Add(const graph::Keyframe& keyframe,
           const registration::FrameSpectrum& spectrum = {},
           std::span<const graph::Edge> edges = {},
           const cv::Mat& descriptors = {});
  /// Heights of a keyframe, refined by later frames. Measures the keyframe's edges to earlier ones
  /// again with them, backwards, as further edges.
  void SetHeights(std::int64_t id, std::shared_ptr<const heights::HeightField> heights);
  /// An edge between known keyframes, measured elsewhere.
  void Add(const graph::Edge& edge);
  /// Compares a keyframe with its candidates, adds the accepted closures to the graph, and moves
  /// the latest keyframes accordingly.
  void Close(std::int64_t id);

  /// Registers two keyframes (reference: from).
  registration::Registration Compare(
      std::int64_t from,
      std::int64_t to,
      const std::optional<registration::MotionPrior>& prior = std::nullopt);
  /// Dissimilarity of two keyframes' images under a motion (Registrar::Compare).
  [[nodiscard]] registration::Dissimilarity DissimilarityOf(
      std::int64_t from, std::int64_t to, const registration::ImageMotion& motion);
  /// A predicted T_from_to as the prior of a registration. @param sigma  standard deviation of x
  /// and y, map units.
  [[nodiscard]] registration::MotionPrior Prior(const Pose2& T_from_to,
                                                double sigma,
                                                double sigma_rad) const;
  /// The motion between two keyframes as given by the compass alone: a rotation, with the position
  /// unknown. Nothing where the compass gives no turn.
  [[nodiscard]] std::optional<registration::MotionPrior> CompassPrior(std::int64_t from,
                                                                      std::int64_t to) const;
  /// Whether the edge's rotation is a different orientation from the one that the compass measured.
  /// False where the compass gives no turn.
  [[nodiscard]] bool ContradictsCompass(const graph::Edge& edge) const;
  /// The loop closure that a registration measures.
  [[nodiscard]] graph::Edge ClosureEdge(const registration::Registration& measured,
                                        std::int64_t from,
                                        std::int64_t to) const;
  /// Fraction of an image that is also visible from another pose, 0..1.
  [[nodiscard]] double Overlap(const Pose2& T_from_to) const;
  /// Map units across an image's longer side.
  [[nodiscard]] double Span() const;

  [[nodiscard]] const graph::KeyframeGraph& Graph() const;
  [[nodiscard]] graph::KeyframeGraph& Graph();
  /// Numbers of closures; those that still wait for confirmation count as unconfirmed.
  [[nodiscard]] graph::LoopCounts Counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
