#include "mapping/odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "calib/error.hpp"
#include "calib/level_view.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;
using registration::Verdict;

namespace {

/// A keyframe that new frames can still be registered against.
struct ActiveKeyframe {
  Keyframe keyframe;
  FrameSpectrum spectrum;
};

/// The frame before the current one, kept in case that it has to become a keyframe.
struct LastFrame {
  FramePose pose;
  FrameSpectrum spectrum;
  cv::Mat picture;
  Edge edge;           // to the keyframe that placed it
  double overlap = 1;  // with it
  bool ambiguous = false;
};

}  // namespace

struct Odometry::Impl {
  Impl(const calib::CeilingView& ceiling_view, const Pose2& start, const OdometryParams& p)
      : view(ceiling_view), origin(start), params(p), registrar(view.Size(), p.registration) {}

  const calib::CeilingView& view;
  Pose2 origin;
  OdometryParams params;
  Registrar registrar;
  std::deque<ActiveKeyframe> active;  // oldest first; the last one is the reference
  std::int64_t next_id = params.first_keyframe_id;
  std::optional<LastFrame> last;
  std::optional<FramePose> before_last;
  Pose2 T_last_seen = origin;  // where a segment begins that nothing connects
  int lost_in_a_row = 0;
  std::optional<Pose2> predicted;             // where this frame was expected, at an even speed
  std::optional<double> prediction_error_px;  // the largest one lately, fading

  Pose2 Predict(double stamp_s);
  double PriorSigma() const;
  void LearnFromPrediction(const Pose2& T_map_base);
  MotionPrior PriorFor(const ActiveKeyframe& reference, const Pose2& T_map_base) const;
  void Place(const ActiveKeyframe& reference, const Edge& edge, FramePose& pose) const;
  bool Start(const FrameSpectrum& spectrum, const cv::Mat& picture, OdometryStep& step);
  bool TryReference(std::size_t index,
                    const FrameSpectrum& spectrum,
                    const std::optional<Pose2>& expected,
                    OdometryStep& step,
                    Edge& edge);
  bool Track(const FrameSpectrum& spectrum, OdometryStep& step, Edge& edge);
  bool Recover(const FrameSpectrum& spectrum, OdometryStep& step, Edge& edge);
  bool Restart(const FrameSpectrum& spectrum, const cv::Mat& picture, OdometryStep& step);
  void MakeKeyframe(const FramePose& pose,
                    const FrameSpectrum& spectrum,
                    const cv::Mat& picture,
                    const Edge& edge,
                    bool ambiguous,
                    OdometryStep& step);
  void Bridge(OdometryStep& step);
  [[nodiscard]] cv::Mat Stored(const cv::Mat& picture) const;
  [[nodiscard]] bool WantsKeyframe(const OdometryStep& step) const;
  void TieToOlder(const FrameSpectrum& spectrum,
                  FramePose& pose,
                  const Edge& edge,
                  std::vector<Edge>& edges);
  void Remember(const OdometryStep& step,
                const FrameSpectrum& spectrum,
                const cv::Mat& picture,
                const Edge& edge);
};

Pose2 Odometry::Impl::Predict(double stamp_s) {
  predicted.reset();
  if (!before_last) return last->pose.T_map_base;
  const double step_s = last->pose.stamp_s - before_last->stamp_s;
  const double ahead_s = stamp_s - last->pose.stamp_s;
  // After a gap the speed is not known any more: the robot may have stopped or turned.
  if (step_s <= 0 || ahead_s > 3 * step_s) return last->pose.T_map_base;
  const Pose2 step = before_last->T_map_base.Inverse() * last->pose.T_map_base;
  predicted = last->pose.T_map_base * Interpolate(step, ahead_s / step_s);
  return *predicted;
}

/// Robots move evenly from frame to frame: on a periodic ceiling that tells one period from the
/// next, even short ones.
double Odometry::Impl::PriorSigma() const {
  const double most = params.prior_sigma_part * std::max(view.Size().width, view.Size().height);
  if (!prediction_error_px) return most;
  const double sigma = params.prior_sigma_errors * *prediction_error_px;
  return std::min(most, std::max(sigma, params.min_prior_sigma_px));
}

void Odometry::Impl::LearnFromPrediction(const Pose2& T_map_base) {
  if (!predicted) return;
  constexpr double kKept = 0.9;  // a frame: forgotten after a second or two
  const double error_px =
      (predicted->Translation() - T_map_base.Translation()).norm() / view.MetresPerPixel();
  prediction_error_px = std::max(error_px, kKept * prediction_error_px.value_or(0));
}

MotionPrior Odometry::Impl::PriorFor(const ActiveKeyframe& reference,
                                     const Pose2& T_map_base) const {
  return {ImageMotionOf(view, reference.keyframe.pose.T_map_base.Inverse() * T_map_base),
          PriorSigma(),
          params.prior_sigma_rad};
}

void Odometry::Impl::Place(const ActiveKeyframe& reference,
                           const Edge& edge,
                           FramePose& pose) const {
  const FramePose& from = reference.keyframe.pose;
  pose.T_map_base = from.T_map_base * edge.T_from_to;
  pose.covariance = ComposeCovariance(
      from.T_map_base, from.covariance, edge.T_from_to, edge.information.inverse());
}

bool Odometry::Impl::Start(const FrameSpectrum& spectrum,
                           const cv::Mat& picture,
                           OdometryStep& step) {
  // A picture that cannot be registered even against itself shows nothing that a map could be made
  // of.
  step.registration = registrar.Register(spectrum, spectrum, MotionPrior{{}, 1.0, 0.01});
  if (!step.registration.ok()) return false;
  step.pose.T_map_base = T_last_seen;
  step.pose.status = TrackingStatus::kTracking;
  MakeKeyframe(step.pose, spectrum, picture, {}, false, step);
  step.pose = step.new_keyframe->pose;
  return true;
}

bool Odometry::Impl::TryReference(std::size_t index,
                                  const FrameSpectrum& spectrum,
                                  const std::optional<Pose2>& expected,
                                  OdometryStep& step,
                                  Edge& edge) {
  const ActiveKeyframe& reference = active[index];
  std::optional<MotionPrior> prior;
  if (expected) prior = PriorFor(reference, *expected);
  step.registration = registrar.Register(reference.spectrum, spectrum, prior);
  if (!step.registration.ok()) return false;
  edge = MeasuredEdge(view, step.registration, reference.keyframe.id, -1, params.noise);
  AddTiltDoubt(view, step.pose.tilt, edge);
  Place(reference, edge, step.pose);
  step.pose.keyframe_id = reference.keyframe.id;
  return true;
}

bool Odometry::Impl::Track(const FrameSpectrum& spectrum, OdometryStep& step, Edge& edge) {
  // After a loss nothing is known of where the robot is.
  std::optional<Pose2> expected;
  if (last) expected = Predict(step.pose.stamp_s);
  const bool tilting = last && last->edge.to < 0 && last->pose.tilt.IsLevel() &&
                       !step.pose.tilt.IsLevel() && last->overlap < params.level_overlap;
  if (tilting) Bridge(step);
  if (TryReference(active.size() - 1, spectrum, expected, step, edge)) return true;
  // The last frame that was still placed sees more of what this one sees: it becomes the keyframe.
  if (!last || last->edge.to >= 0 || step.registration.verdict == Verdict::kNoTexture) return false;
  Bridge(step);
  return TryReference(active.size() - 1, spectrum, expected, step, edge);
}

/// Makes the last frame a keyframe.
void Odometry::Impl::Bridge(OdometryStep& step) {
  const LastFrame bridge = *last;
  MakeKeyframe(bridge.pose, bridge.spectrum, bridge.picture, bridge.edge, bridge.ambiguous, step);
  last->edge.to = active.back().keyframe.id;
}

bool Odometry::Impl::WantsKeyframe(const OdometryStep& step) const {
  const Registration& r = step.registration;
  const bool level = step.pose.tilt.IsLevel();
  return r.overlap < (level ? params.min_overlap : params.min_tilted_overlap) ||
         (level && r.inliers < params.min_inlier_part * r.blocks);
}

bool Odometry::Impl::Recover(const FrameSpectrum& spectrum, OdometryStep& step, Edge& edge) {
  // Where the robot is now is unknown, so no prior: only a place that is unmistakable counts.
  const Registration tracked = step.registration;
  if (tracked.verdict == Verdict::kNoTexture) return false;
  for (std::size_t i = active.size(); i-- > 0;) {
    if (TryReference(i, spectrum, std::nullopt, step, edge)) {
      step.pose.status = TrackingStatus::kRelocalized;
      return true;
    }
  }
  step.registration = tracked;
  return false;
}

bool Odometry::Impl::Restart(const FrameSpectrum& spectrum,
                             const cv::Mat& picture,
                             OdometryStep& step) {
  if (step.registration.verdict == Verdict::kNoTexture) return false;
  if (++lost_in_a_row < params.restart_after || step.new_keyframe) return false;
  const Registration failed = step.registration;
  std::deque<ActiveKeyframe> before;
  before.swap(active);
  if (Start(spectrum, picture, step)) return true;
  active.swap(before);
  step.registration = failed;
  return false;
}

void Odometry::Impl::TieToOlder(const FrameSpectrum& spectrum,
                                FramePose& pose,
                                const Edge& edge,
                                std::vector<Edge>& edges) {
  // Each tie is an estimate of the same pose; they are averaged by their information.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
  const auto add = [&](const ActiveKeyframe& reference, const Edge& tie) {
    const Pose2 T = reference.keyframe.pose.T_map_base * tie.T_from_to;
    const Eigen::Vector3d difference(T.x - pose.T_map_base.x,
                                     T.y - pose.T_map_base.y,
                                     calib::WrapAngle(T.yaw - pose.T_map_base.yaw));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = reference.keyframe.pose.T_map_base.Rotation();
    const Eigen::Matrix3d in_map = turn * tie.information * turn.transpose();
    information += in_map;
    weighted += in_map * difference;
  };
  const int width = view.Size().width;
  const int height = view.Size().height;
  for (std::size_t i = active.size(); i-- > 0;) {
    const ActiveKeyframe& reference = active[i];
    if (reference.keyframe.id == edge.from) {
      add(reference, edge);
      continue;
    }
    if (static_cast<int>(edges.size()) >= params.local_keyframes) break;
    MotionPrior prior = PriorFor(reference, pose.T_map_base);
    if (std::abs(prior.motion.tx_px) > 0.5 * width || std::abs(prior.motion.ty_px) > 0.5 * height)
      continue;
    prior.sigma_px = 3;
    prior.sigma_theta_rad = 0.01;
    const Registration registration = registrar.Register(reference.spectrum, spectrum, prior);
    const double off = std::hypot(registration.motion.tx_px - prior.motion.tx_px,
                                  registration.motion.ty_px - prior.motion.ty_px);
    if (!registration.ok() || off > 5) continue;
    Edge tie = MeasuredEdge(view, registration, reference.keyframe.id, edge.to, params.noise);
    AddTiltDoubt(view, pose.tilt, tie);
    add(reference, tie);
    edges.push_back(tie);
  }
  const Eigen::Vector3d correction = information.ldlt().solve(weighted);
  pose.T_map_base.x += correction.x();
  pose.T_map_base.y += correction.y();
  pose.T_map_base.yaw = calib::WrapAngle(pose.T_map_base.yaw + correction.z());
}

/// What is kept of a picture: black pixels are content, 0 is none (Keyframe::picture).
cv::Mat Odometry::Impl::Stored(const cv::Mat& picture) const {
  cv::Mat stored;
  cv::max(picture, 1, stored);
  const cv::Mat content = calib::ContentMask(picture);
  if (!content.empty()) cv::bitwise_and(stored, content, stored);
  if (!view.Mask().empty()) cv::bitwise_and(stored, view.Mask(), stored);
  return stored;
}

void Odometry::Impl::MakeKeyframe(const FramePose& pose,
                                  const FrameSpectrum& spectrum,
                                  const cv::Mat& picture,
                                  const Edge& edge,
                                  bool ambiguous,
                                  OdometryStep& step) {
  Keyframe keyframe{next_id++, pose, Stored(picture), ambiguous};
  keyframe.pose.keyframe_id = keyframe.id;
  if (!active.empty()) {
    Edge tie = edge;
    tie.to = keyframe.id;
    step.new_edges.push_back(tie);
    TieToOlder(spectrum, keyframe.pose, tie, step.new_edges);
  }
  step.new_keyframe = keyframe;
  step.new_spectrum = spectrum;
  active.push_back({std::move(keyframe), spectrum});
  active.back().keyframe.picture.release();
  while (static_cast<int>(active.size()) > params.recent_keyframes) active.pop_front();
}

void Odometry::Impl::Remember(const OdometryStep& step,
                              const FrameSpectrum& spectrum,
                              const cv::Mat& picture,
                              const Edge& edge) {
  T_last_seen = step.pose.T_map_base;
  lost_in_a_row = 0;
  before_last.reset();
  if (last) before_last = last->pose;
  if (!last) last.emplace();
  last->pose = step.pose;
  last->spectrum = spectrum;
  picture.copyTo(last->picture);
  last->edge = edge;
  last->overlap = step.registration.overlap;
  last->ambiguous = step.registration.by_prior;
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

OdometryStep Odometry::Process(const cv::Mat& picture,
                               std::int64_t frame_index,
                               double stamp_s,
                               const calib::Tilt& tilt) {
  Impl& me = *impl_;
  OdometryStep step;
  step.pose.frame_index = frame_index;
  step.pose.stamp_s = stamp_s;
  step.pose.tilt = tilt;
  const FrameSpectrum spectrum =
      me.registrar.Analyze(picture, tilt.IsLevel() ? cv::Mat() : calib::ContentMask(picture));
  Edge edge;
  bool placed = false;
  if (me.active.empty()) {
    placed = me.Start(spectrum, picture, step);
  } else {
    placed = me.Track(spectrum, step, edge) || me.Recover(spectrum, step, edge) ||
             me.Restart(spectrum, picture, step);
    if (placed && !step.new_keyframe && me.WantsKeyframe(step)) {
      me.MakeKeyframe(step.pose, spectrum, picture, edge, step.registration.by_prior, step);
      step.pose = step.new_keyframe->pose;
    }
  }
  if (!placed) {
    step.pose.status = step.registration.verdict == Verdict::kAmbiguous ? TrackingStatus::kAmbiguous
                                                                        : TrackingStatus::kLost;
    me.last.reset();
    me.before_last.reset();
    me.predicted.reset();
    me.prediction_error_px.reset();
    return step;
  }
  step.tie = edge;
  me.LearnFromPrediction(step.pose.T_map_base);
  me.predicted.reset();
  me.Remember(step, spectrum, picture, edge);
  return step;
}

OdometryStep Odometry::Close() {
  OdometryStep step;
  if (impl_->last && impl_->last->edge.to < 0) {
    const LastFrame frame = *impl_->last;
    impl_->MakeKeyframe(
        frame.pose, frame.spectrum, frame.picture, frame.edge, frame.ambiguous, step);
    impl_->last->edge.to = step.new_keyframe->id;
  }
  return step;
}

}  // namespace ceilmap::mapping
