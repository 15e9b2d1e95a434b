#include "mapping/odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "calib/level_view.hpp"
#include "mapping/frame_acceptance.hpp"
#include "mapping/frame_matching.hpp"
#include "mapping/frame_prediction.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/recent_keyframes.hpp"
#include "mapping/repetition.hpp"
#include "mapping/segment_start.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::ImageMotion;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

namespace {

// Under a ceiling with depth a keyframe sees other sides of things soon, and its blocks change.
constexpr double kMinDepthOverlap = 0.82;
// A new keyframe is made when a smaller fraction of the compared blocks agrees.
constexpr double kMinInlierRatio = 0.5;
// A tilted frame is a poor keyframe: its image has blank borders and its position is less
// accurate. So the last level frame before it becomes a keyframe when less than `kLevelOverlap`
// of the last keyframe is in view, and the tilted frame itself only below `kMinTiltedOverlap`.
constexpr double kLevelOverlap = 0.9;
constexpr double kMinTiltedOverlap = 0.5;

/// The frame before the current one, kept because it may have to become a keyframe.
struct LastFrame {
  graph::FramePose pose;
  FrameSpectrum spectrum;
  cv::Mat image;
  graph::Edge edge;    // to the keyframe that placed it
  double overlap = 1;  // with it
  bool ambiguous = false;
};

}  // namespace

struct Odometry::Impl {
  Impl(const calib::CeilingView& ceiling_view, const Pose2& start, const OdometryParams& p)
      : view(ceiling_view),
        params(p),
        registrar(view.Size(), p.registration),
        prediction(view, start, params),
        recent(view, params) {}

  const calib::CeilingView& view;
  OdometryParams params;
  Registrar registrar;
  FramePrediction prediction;
  FrameAcceptance acceptance{view, prediction, registrar};
  RecentKeyframes recent;  // the latest one is the reference
  std::int64_t next_id = params.first_keyframe_id;
  std::optional<LastFrame> last;
  std::optional<Pose2> last_placed;  // kept during a loss
  FrameSpectrum unplaced;            // the frame before, which was not placed; empty: it was
  bool after_copy = false;           // the frame before repeated the one before it
  int consecutive_lost = 0;
  int steps = 1;                 // FramePrediction::StepsTo of the current frame
  double best_inlier_ratio = 0;  // of the frames that the reference placed

  [[nodiscard]] FrameBefore Before() const {
    const bool known = last && !after_copy;
    return {
        last_placed, known ? &last->spectrum : nullptr, known ? last->pose.T_map_base : Pose2{}};
  }
  void Place(const RecentKeyframe& reference,
             const graph::Edge& edge,
             graph::FramePose& pose) const;
  bool Start(const FrameSpectrum& spectrum, const cv::Mat& image, OdometryStep& step);
  void LearnStandard(const FrameSpectrum& spectrum, const OdometryStep& step);
  graph::Edge Measured(const RecentKeyframe& reference,
                       const Registration& registration,
                       const graph::FramePose& pose) const;
  void Sharpen(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge);
  bool TryReference(std::size_t index,
                    const FrameSpectrum& spectrum,
                    const std::optional<ExpectedPose>& expected,
                    OdometryStep& step,
                    graph::Edge& edge);
  bool Track(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge);
  bool Recover(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge);
  bool Restart(const FrameSpectrum& spectrum,
               const cv::Mat& image,
               const std::optional<wheels::RelativeMotion>& wheels,
               OdometryStep& step);
  void MakeKeyframe(const graph::FramePose& pose,
                    const FrameSpectrum& spectrum,
                    const cv::Mat& image,
                    const graph::Edge& edge,
                    bool ambiguous,
                    OdometryStep& step);
  void InflateByAcceptance(const graph::FramePose& pose, graph::Edge& edge) const;
  void Bridge(OdometryStep& step);
  [[nodiscard]] bool WantsKeyframe(const OdometryStep& step) const;
  void Remember(const OdometryStep& step,
                const FrameSpectrum& spectrum,
                const cv::Mat& image,
                const graph::Edge& edge);
};

void Odometry::Impl::Place(const RecentKeyframe& reference,
                           const graph::Edge& edge,
                           graph::FramePose& pose) const {
  const graph::FramePose& from = reference.keyframe.pose;
  pose.T_map_base = from.T_map_base * edge.T_from_to;
  pose.covariance = ComposeCovariance(
      from.T_map_base, from.covariance, edge.T_from_to, edge.information.inverse());
}

bool Odometry::Impl::Start(const FrameSpectrum& spectrum,
                           const cv::Mat& image,
                           OdometryStep& step) {
  step.registration = RegisterWithItself(spectrum, registrar);
  if (!step.registration.ok()) return false;
  std::optional<graph::Edge> by_wheels;
  if (recent.Size() > 0 && last_placed && prediction.WheelMotion()) {
    by_wheels =
        EdgeByWheels(recent.Latest().keyframe, *last_placed, *prediction.WheelMotion(), next_id);
  }
  recent.Clear();
  step.pose.T_map_base = prediction.Restart();
  step.pose.status = graph::TrackingStatus::kTracking;
  MakeKeyframe(step.pose, spectrum, image, {}, false, step);
  if (by_wheels) step.new_edges.push_back(*by_wheels);
  step.pose = step.new_keyframe->pose;
  return true;
}

/// Learns from a frame that was tracked continuously from the keyframe that placed it.
void Odometry::Impl::LearnStandard(const FrameSpectrum& spectrum, const OdometryStep& step) {
  const RecentKeyframe* const reference = recent.Find(step.pose.keyframe_id);
  if (reference == nullptr || prediction.CeilingHidden()) return;
  acceptance.Learn(*reference, spectrum, step.registration);
}

graph::Edge Odometry::Impl::Measured(const RecentKeyframe& reference,
                                     const Registration& registration,
                                     const graph::FramePose& pose) const {
  graph::Edge edge = MeasuredEdge(view, registration, reference.keyframe.id, -1, params.noise);
  InflateTiltCovariance(view, pose.tilt, edge);
  return edge;
}

/// Adds to an accepted edge what speaks against it.
void Odometry::Impl::InflateByAcceptance(const graph::FramePose& pose, graph::Edge& edge) const {
  InflateCovariance(prediction.InnovationSigma(pose.T_map_base, steps), 0, edge);
  // Errors of strongly encoded images that continued the motion: up to 5 px and 1.5 degrees.
  constexpr double kDoubtfulPx = 2;
  constexpr double kDoubtfulRad = 0.015;
  if (acceptance.IsDoubtful()) {
    InflateCovariance(kDoubtfulPx * view.MetresPerPixel(), kDoubtfulRad, edge);
  } else if (acceptance.MayLag()) {
    InflateCovariance(0, kDoubtfulRad, edge);
  }
}

/// A frame that becomes a keyframe is measured with all blocks.
void Odometry::Impl::Sharpen(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge) {
  const RecentKeyframe* const reference = recent.Find(step.pose.keyframe_id);
  if (reference == nullptr || reference->spectrum.Heights() != nullptr) return;
  constexpr double kSamePx = 1;
  constexpr double kSameRad = 0.005;
  const Registration exact =
      registrar.Register(reference->spectrum,
                         spectrum,
                         registration::MotionPrior{step.registration.motion, kSamePx, kSameRad});
  if (!exact.ok() || exact.disambiguated_by_prior) return;
  const ImageMotion& coarse = step.registration.motion;
  if (std::hypot(exact.motion.tx_px - coarse.tx_px, exact.motion.ty_px - coarse.ty_px) > kSamePx) {
    return;
  }
  step.registration = exact;
  edge = Measured(*reference, exact, step.pose);
  InflateByAcceptance(step.pose, edge);
  Place(*reference, edge, step.pose);
}

bool Odometry::Impl::TryReference(std::size_t index,
                                  const FrameSpectrum& spectrum,
                                  const std::optional<ExpectedPose>& expected,
                                  OdometryStep& step,
                                  graph::Edge& edge) {
  const RecentKeyframe& reference = recent[index];
  step.registration = MatchFrame(view, reference, spectrum, expected, registrar);
  if (!step.registration.ok()) return false;
  // After a loss the next frame would continue from an end of the blur.
  if (!last && IsHiddenByBlur(reference, spectrum, step.registration, registrar)) {
    step.registration.verdict = Verdict::kAmbiguous;
    return false;
  }
  edge = Measured(reference, step.registration, step.pose);
  Place(reference, edge, step.pose);
  const std::optional<int> accepted =
      acceptance.StepsTo({reference, spectrum, step.registration, step.pose.T_map_base}, Before());
  steps = accepted.value_or(1);
  if (!accepted) {
    step.registration.verdict = Verdict::kAmbiguous;
    return false;
  }
  InflateByAcceptance(step.pose, edge);
  Place(reference, edge, step.pose);
  step.pose.keyframe_id = reference.keyframe.id;
  if (index + 1 == recent.Size() && step.registration.blocks > 0) {
    best_inlier_ratio =
        std::max(best_inlier_ratio,
                 static_cast<double>(step.registration.inliers) / step.registration.blocks);
  }
  if (step.registration.heights) recent.SetHeights(index, step.registration.heights);
  return true;
}

bool Odometry::Impl::Track(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge) {
  if (prediction.CeilingHidden()) {
    step.registration = RegisterWithItself(spectrum, registrar);
    if (step.registration.ok()) step.registration.verdict = Verdict::kNoMatch;
    return false;
  }
  // After a loss the pose is unknown without wheels.
  const std::optional<ExpectedPose> by_wheels = prediction.ByWheels();
  std::optional<ExpectedPose> expected = prediction.Next();
  const bool tilting = last && last->edge.to < 0 && last->pose.tilt.IsLevel() &&
                       !step.pose.tilt.IsLevel() && last->overlap < kLevelOverlap;
  if (tilting) Bridge(step);
  if (by_wheels && TryReference(recent.Size() - 1, spectrum, by_wheels, step, edge)) return true;
  // Without wheels, and where they slip, the robot moves on as before.
  if ((expected || !by_wheels) && TryReference(recent.Size() - 1, spectrum, expected, step, edge)) {
    return true;
  }
  if (by_wheels) expected = by_wheels;
  // Frames may be missing before this one, and it is far from where it is expected.
  if (expected && TryReference(recent.Size() - 1, spectrum, std::nullopt, step, edge)) return true;
  // The last placed frame has more overlap with this one than the reference has: it becomes the
  // keyframe.
  if (!last || last->edge.to >= 0 || step.registration.verdict == Verdict::kNoTexture) return false;
  Bridge(step);
  return TryReference(recent.Size() - 1, spectrum, expected, step, edge);
}

/// Makes the last frame a keyframe.
void Odometry::Impl::Bridge(OdometryStep& step) {
  const LastFrame bridge = *last;
  MakeKeyframe(bridge.pose, bridge.spectrum, bridge.image, bridge.edge, bridge.ambiguous, step);
  last->edge.to = recent.Latest().keyframe.id;
}

bool Odometry::Impl::WantsKeyframe(const OdometryStep& step) const {
  const Registration& r = step.registration;
  const bool level = step.pose.tilt.IsLevel();
  const double min_overlap =
      r.heights ? std::max(params.min_overlap, kMinDepthOverlap) : params.min_overlap;
  // Under a ceiling with weak texture never more than a part of the blocks agrees.
  const double usual = r.heights ? best_inlier_ratio : 1;
  return r.overlap < (level ? min_overlap : kMinTiltedOverlap) ||
         (level && r.inliers < kMinInlierRatio * usual * r.blocks);
}

bool Odometry::Impl::Recover(const FrameSpectrum& spectrum, OdometryStep& step, graph::Edge& edge) {
  // The robot's position is unknown, so only an unambiguous match is accepted; without a compass,
  // in any orientation. Encoded images no longer contain what makes a match unambiguous.
  Registration tracked = step.registration;
  if (tracked.verdict == Verdict::kNoTexture || !prediction.MayBeNear()) return false;
  std::optional<ExpectedPose> expected = prediction.AfterLoss();
  if (!expected && spectrum.IsEncoded()) expected = prediction.Continued();
  for (std::size_t i = recent.Size(); i-- > 0;) {
    if (TryReference(i, spectrum, expected, step, edge)) {
      step.pose.status = graph::TrackingStatus::kRelocalized;
      return true;
    }
    if (step.registration.verdict == Verdict::kAmbiguous) tracked = step.registration;
  }
  step.registration = tracked;
  return false;
}

bool Odometry::Impl::Restart(const FrameSpectrum& spectrum,
                             const cv::Mat& image,
                             const std::optional<wheels::RelativeMotion>& wheels,
                             OdometryStep& step) {
  if (step.registration.verdict == Verdict::kNoTexture) return false;
  const std::optional<ExpectedPose> by_wheels = prediction.ByWheels();
  const bool left = by_wheels && LeavesBehind(view, recent.Latest().keyframe, *by_wheels);
  const bool waits = ++consecutive_lost < params.restart_after && !left;
  if (waits || step.new_keyframe) return false;
  const std::optional<Pose2> motion = wheels ? std::optional(wheels->T_before_now) : std::nullopt;
  if (!Persists(view, unplaced, spectrum, motion, registrar)) return false;
  const Registration failed = step.registration;
  if (Start(spectrum, image, step)) return true;
  step.registration = failed;
  return false;
}

void Odometry::Impl::MakeKeyframe(const graph::FramePose& pose,
                                  const FrameSpectrum& spectrum,
                                  const cv::Mat& image,
                                  const graph::Edge& edge,
                                  bool ambiguous,
                                  OdometryStep& step) {
  if (recent.Size() > 0) {
    step.refined_heights = recent.Latest().spectrum.SharedHeights();
    step.refined_id = recent.Latest().keyframe.id;
  }
  step.new_keyframe =
      recent.Add({next_id++, pose, image, ambiguous}, spectrum, edge, registrar, step.new_edges);
  step.new_spectrum = recent.Latest().spectrum;
  best_inlier_ratio = 0;
}

void Odometry::Impl::Remember(const OdometryStep& step,
                              const FrameSpectrum& spectrum,
                              const cv::Mat& image,
                              const graph::Edge& edge) {
  prediction.Placed(step.pose.T_map_base, steps);
  last_placed = step.pose.T_map_base;
  consecutive_lost = 0;
  unplaced = {};
  if (!last) last.emplace();
  last->pose = step.pose;
  last->spectrum = spectrum;
  image.copyTo(last->image);
  last->edge = edge;
  last->overlap = step.registration.overlap;
  last->ambiguous = step.registration.disambiguated_by_prior;
  last->edge.to = step.new_keyframe && step.new_keyframe->pose.frame_index == step.pose.frame_index
                      ? step.new_keyframe->id
                      : -1;
}

Odometry::Odometry(const calib::CeilingView& view,
                   const Pose2& origin,
                   const OdometryParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(view, origin, params);
}
Odometry::~Odometry() = default;

OdometryStep Odometry::Process(const cv::Mat& image,
                               std::int64_t frame_index,
                               double stamp_s,
                               const FrameContext& context,
                               const FrameSpectrum& analyzed) {
  Impl& me = *impl_;
  OdometryStep step;
  step.pose.frame_index = frame_index;
  step.pose.stamp_s = stamp_s;
  step.pose.tilt = context.tilt;
  step.pose.heading = context.heading;
  if (context.repeated > kMaxRepeated) {
    me.prediction.Skip(context.wheels);
    me.after_copy = true;
    step.pose.status = graph::TrackingStatus::kAmbiguous;
    return step;
  }
  const FrameSpectrum spectrum =
      analyzed.empty()
          ? me.registrar.Analyze(image,
                                 context.tilt.IsLevel() ? cv::Mat() : calib::ContentMask(image),
                                 context.encoding)
          : analyzed;
  step.coding_loss = spectrum.CodingLoss();
  me.prediction.Begin(stamp_s, context.heading, context.wheels);
  graph::Edge edge;
  bool placed = false;
  if (me.recent.Size() == 0) {
    placed = me.Start(spectrum, image, step);
  } else {
    placed = me.Track(spectrum, step, edge) || me.Recover(spectrum, step, edge) ||
             me.Restart(spectrum, image, context.wheels, step);
    if (placed && !step.new_keyframe && me.WantsKeyframe(step)) {
      me.Sharpen(spectrum, step, edge);
      me.LearnStandard(spectrum, step);
      me.MakeKeyframe(
          step.pose, spectrum, image, edge, step.registration.disambiguated_by_prior, step);
      step.pose = step.new_keyframe->pose;
    }
  }
  if (!placed) {
    step.pose.status = step.registration.verdict == Verdict::kAmbiguous
                           ? graph::TrackingStatus::kAmbiguous
                           : graph::TrackingStatus::kLost;
    me.last.reset();
    me.after_copy = false;
    me.unplaced = spectrum;
    me.prediction.Lost();
    return step;
  }
  step.tie = edge;
  me.after_copy = false;
  me.Remember(step, spectrum, image, edge);
  return step;
}

void Odometry::Continue(const Twist2& velocity) {
  impl_->prediction.Continue(velocity);
}

OdometryStep Odometry::Close() {
  OdometryStep step;
  if (impl_->last && impl_->last->edge.to < 0) {
    const LastFrame frame = *impl_->last;
    impl_->MakeKeyframe(frame.pose, frame.spectrum, frame.image, frame.edge, frame.ambiguous, step);
    impl_->last->edge.to = step.new_keyframe->id;
  }
  return step;
}

}  // namespace ceilmap::mapping
