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
  LoopCandidatesParams candidates;   ///< who is compared
  int comparisons_per_keyframe = 5;  ///< registrations at the most: bounds the work
  int closures_per_keyframe = 3;
  /// A closure is looked for only where the motion is known worse than this many times the
  /// variance of one measurement: others would cost time and tell nothing.
  double min_gain = 2;
  LoopVerifierParams judge;  ///< what is believed
  /// Where the prediction is less certain than this, a closure waits until another one, of another
  /// new image, says the same (LoopVerifier::Confirm).
  double confirm_px = 12;
  /// ... and is left out as ambiguous when another motion of the images agrees with this part of
  /// the best one's agreement.
  double max_rival_ratio = 0.7;
  int window = 30;          ///< latest keyframes that are moved when a closure is found
  int cached_spectra = 40;  ///< about 4 MB each for images of 640 x 480
  EdgeNoise noise;
  HeadingTrust heading;  ///< where keyframes have one
  registration::RegistrarParams registration;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Finds where the robot sees again what it has seen before. Candidates are the keyframes whose
/// images overlap the new one's by position, or, where the position has become too uncertain for
/// that, those that look alike (LoopCandidates). Each is checked by registration, and against what
/// the graph says already (LoopVerifier). On a periodic ceiling several motions fit: the prediction
/// decides where it is sharp enough for that (a few standard deviations within half a period), else
/// the pair is left out and counted as ambiguous.
///
/// Where keyframes have headings (FramePose::heading) the compass bounds what is not known of the
/// rotation between any two, however long and doubtful the way: what is a quarter turn off is left
/// out.
///
/// Bounded work per keyframe: a few registrations, and a pose graph over the last few keyframes.
/// Not thread-safe, but it may run in a thread of its own beside the odometry.
class LoopCloser {
 public:
  /// @param view  must outlive the closer. @param load  called when a keyframe's spectrum is not
  /// among those kept.
  LoopCloser(const calib::CeilingView& view,
             graph::ImageLoader load,
             const LoopCloserParams& params = {});
  ~LoopCloser();

  /// Takes a keyframe whose pose is one of a recording's odometry (or a map's), and the edges that
  /// tie it to earlier ones. Without edges it begins a segment of its own, at its pose.
  /// @param spectrum  of its image; empty: loaded when needed.
  /// @param descriptors  PlaceDescriber's of its image; empty: it is not found by its looks.
  void Add(const graph::Keyframe& keyframe,
           const registration::FrameSpectrum& spectrum = {},
           std::span<const graph::Edge> edges = {},
           const cv::Mat& descriptors = {});
  /// An edge between known keyframes, measured elsewhere.
  void Add(const graph::Edge& edge);
  /// Compares a keyframe with those around it, adds the closures that hold to the graph, and moves
  /// the latest keyframes accordingly.
  void Close(std::int64_t id);

  /// Registers two keyframes (reference: from).
  registration::Registration Compare(
      std::int64_t from,
      std::int64_t to,
      const std::optional<registration::MotionPrior>& prior = std::nullopt);
  /// How badly two keyframes disagree under a motion (Registrar::Compare).
  [[nodiscard]] registration::Dissimilarity DissimilarityOf(
      std::int64_t from, std::int64_t to, const registration::ImageMotion& motion);
  /// What is known of T_from_to as the prior of a registration. @param sigma  of x and y, map
  /// units.
  [[nodiscard]] registration::MotionPrior Prior(const Pose2& T_from_to,
                                                double sigma,
                                                double sigma_rad) const;
  /// What the compass alone says of the motion between two keyframes: a rotation, and no place.
  /// Nothing where it says nothing.
  [[nodiscard]] std::optional<registration::MotionPrior> CompassPrior(std::int64_t from,
                                                                      std::int64_t to) const;
  /// Is the edge's rotation another orientation than the compass says? False where it says nothing.
  [[nodiscard]] bool ContradictsCompass(const graph::Edge& edge) const;
  /// The loop closure that a registration measures.
  [[nodiscard]] graph::Edge ClosureEdge(const registration::Registration& measured,
                                        std::int64_t from,
                                        std::int64_t to) const;
  /// Part of an image that is seen from another pose too, 0..1.
  [[nodiscard]] double Overlap(const Pose2& T_from_to) const;
  /// Map units across an image's longer side.
  [[nodiscard]] double Span() const;

  [[nodiscard]] const graph::KeyframeGraph& Graph() const;
  [[nodiscard]] graph::KeyframeGraph& Graph();
  /// Closures still unconfirmed count as such.
  [[nodiscard]] graph::LoopCounts Counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mapping
