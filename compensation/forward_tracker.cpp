#include "compensation/forward_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compensation/even_speed.hpp"

namespace ceilmap::compensation {

using registration::Compose;
using registration::ImageMotion;
using registration::MotionPrior;
using registration::Registration;

namespace {

// Standard deviations of shift, roll and zoom by errors that residuals do not show: the scene is
// not at one distance.
constexpr double kSystematicPx = 0.5;
constexpr double kForwardSystematicRad = 4e-4;
constexpr double kSystematicZoom = 2e-3;
// Standard deviation that grows with the zoom: the nearer the scene, the larger the effect of
// its depth. As a fraction of (zoom - 1); applies to the shift over the focal length and to the
// roll.
constexpr double kDepthRatio = 0.01;

registration::RegistrarParams ForForward(const cv::Mat& mask) {
  return {.estimate_scale = true, .mask = mask};
}

/// Near a prediction, ten agreeing blocks are sufficient and a lower inlier ratio is accepted: a
/// scene with depth does not fit one motion as a ceiling does.
registration::RegistrarParams ForFollowing(registration::RegistrarParams params) {
  params.final_blocks = 32;
  params.min_inliers = 10;
  params.refine_poc_peak = 0;
  params.min_agreement = 0.6;
  params.min_block_agreement = 0.6;
  params.min_partial_inliers = 1;
  return params;
}

}  // namespace

ForwardTracker::ForwardTracker(const calib::ForwardView& view)
    : view_(view),
      registrar_(view.Size(), ForForward(view.Mask())),
      following_(view.Size(), ForFollowing(ForForward(view.Mask()))) {}

ForwardTracker::Frame ForwardTracker::Analyze(const cv::Mat& image, double stamp_s) {
  Frame frame;
  frame.spectrum = registrar_.Analyze(image);
  frame.stamp_s = stamp_s;
  return frame;
}

/// The motion against the reference, by the constant-velocity model.
ImageMotion ForwardTracker::Predict(double stamp_s) const {
  if (!last_) return {};
  ImageMotion ahead = last_->from_reference;
  if (!before_) return ahead;
  const double part = StepsAhead(before_->stamp_s, last_->stamp_s, stamp_s);
  const ImageMotion& old = before_->from_reference;
  ahead.tx_px += part * (ahead.tx_px - old.tx_px);
  ahead.ty_px += part * (ahead.ty_px - old.ty_px);
  ahead.theta_rad += part * (ahead.theta_rad - old.theta_rad);
  return ahead;
}

/// Registers the frame with one of known motion, or with the reference itself.
bool ForwardTracker::Against(Frame& from, Frame& frame, Registration& found) {
  MotionPrior prior;
  prior.motion = Compose(Predict(frame.stamp_s), from.from_reference.Inverse());
  found = last_ ? following_.Refine(from.spectrum, frame.spectrum, prior.motion) : Registration{};
  if (!found.ok()) {
    // Between consecutive frames a robot pitches by a few degrees at most.
    constexpr double kReachRad = 0.06;
    prior.sigma_px = kReachRad * view_.FocalLength();
    prior.sigma_theta_rad = kReachRad;
    found = registrar_.Register(from.spectrum, frame.spectrum, prior);
    // A large moving object can match better than the static scene.
    constexpr double kMaxSigmas = 4;
    const double off_px = std::hypot(found.motion.tx_px - prior.motion.tx_px,
                                     found.motion.ty_px - prior.motion.ty_px);
    if (last_ && off_px > kMaxSigmas * prior.sigma_px) return false;
  }
  if (!found.ok()) return false;
  frame.from_reference = Compose(found.motion, from.from_reference);
  frame.variance_px2 = from.variance_px2;
  return true;
}

ForwardMotion ForwardTracker::Describe(const Frame& frame, const Registration& found) const {
  const double focal = view_.FocalLength();
  ForwardMotion motion;
  // The point in the reference that the frame has straight ahead.
  const Eigen::Vector2d at = frame.from_reference.Inverse().Apply(view_.Horizon());
  motion.tan_shift = (at.y() - view_.Horizon().y()) / focal;
  motion.zoom = 1 / frame.from_reference.scale;
  // When the camera's left side rises, the image rotates counter-clockwise on the screen.
  motion.roll_rad = -frame.from_reference.theta_rad;
  const double depth = kDepthRatio * std::abs(motion.zoom - 1);
  const double shift_px2 =
      found.covariance(1, 1) + frame.variance_px2 + kSystematicPx * kSystematicPx;
  motion.sigma_tan_shift = std::hypot(std::sqrt(shift_px2) / focal, depth);
  motion.sigma_zoom = std::hypot(std::sqrt(found.covariance(3, 3)), kSystematicZoom);
  motion.sigma_roll_rad =
      std::hypot(std::sqrt(found.covariance(2, 2)), kForwardSystematicRad, depth);
  motion.inliers = found.inliers;
  motion.blocks = found.blocks;
  return motion;
}

std::optional<ForwardMotion> ForwardTracker::Measure(Frame& frame) {
  if (!HasReference()) return std::nullopt;
  Registration found;
  bool placed = Against(*reference_, frame, found);
  if (!placed && last_ && found.verdict != registration::Verdict::kNoTexture) {
    placed = Against(*last_, frame, found);
    constexpr double kBridgePx = 1;
    if (placed) frame.variance_px2 += kBridgePx * kBridgePx;
  }
  if (!placed) {
    last_.reset();
    before_.reset();
    return std::nullopt;
  }
  before_ = std::move(last_);
  last_ = frame;
  return Describe(frame, found);
}

bool ForwardTracker::IsBare(const Frame& frame) {
  return !registrar_.Refine(frame.spectrum, frame.spectrum, {}).ok();
}

void ForwardTracker::SetReference(const Frame& frame) {
  reference_ = frame;
  reference_->from_reference = {};
  reference_->variance_px2 = 0;
  for (std::optional<Frame>* moment : {&last_, &before_}) {
    if (!*moment) continue;
    (*moment)->from_reference = Compose((*moment)->from_reference, frame.from_reference.Inverse());
    (*moment)->variance_px2 = std::max(0.0, (*moment)->variance_px2 - frame.variance_px2);
  }
}

}  // namespace ceilmap::compensation
