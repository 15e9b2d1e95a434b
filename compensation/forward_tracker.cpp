#include "compensation/forward_tracker.hpp"

#include <cmath>

namespace ceilmap::compensation {

using registration::Compose;
using registration::ImageMotion;
using registration::MotionPrior;
using registration::Registration;

namespace {

registration::RegistrarParams ForForward(registration::RegistrarParams params,
                                         const cv::Mat& mask) {
  params.estimate_scale = true;
  params.mask = mask;
  return params;
}

}  // namespace

ForwardTracker::ForwardTracker(const calib::ForwardView& view, const ForwardTrackerParams& params)
    : view_(view),
      params_(params),
      registrar_(view.Size(), ForForward(params.registration, view.Mask())) {}

ForwardTracker::Frame ForwardTracker::Analyze(const cv::Mat& picture) {
  Frame frame;
  frame.spectrum = registrar_.Analyze(picture);
  return frame;
}

/// Registers the frame against one whose motion is known, or is the reference itself.
bool ForwardTracker::Against(const Frame& from, Frame& frame, Registration& found) {
  // From frame to frame a robot pitches by a few degrees at the most.
  constexpr double kReachRad = 0.06;
  MotionPrior prior;
  if (last_) prior.motion = Compose(last_->from_reference, from.from_reference.Inverse());
  prior.sigma_px = kReachRad * view_.FocalLength();
  prior.sigma_theta_rad = kReachRad;
  found = registrar_.Register(from.spectrum, frame.spectrum, prior);
  if (!found.ok()) return false;
  frame.from_reference = Compose(found.motion, from.from_reference);
  frame.variance_px2 = from.variance_px2;
  return true;
}

ForwardMotion ForwardTracker::Describe(const Frame& frame, const Registration& found) const {
  const double focal = view_.FocalLength();
  ForwardMotion motion;
  // Where the reference sees what the frame has straight ahead.
  const Eigen::Vector2d at = frame.from_reference.Inverse().Apply(view_.Horizon());
  motion.tan_shift = (at.y() - view_.Horizon().y()) / focal;
  motion.zoom = 1 / frame.from_reference.scale;
  // When the camera's left side goes up, the picture turns counter-clockwise as seen on the screen.
  motion.roll_rad = -frame.from_reference.theta_rad;
  const double depth = params_.depth_part * std::abs(motion.zoom - 1);
  const double shift_px2 =
      found.covariance(1, 1) + frame.variance_px2 + params_.systematic_px * params_.systematic_px;
  motion.sigma_tan_shift = std::hypot(std::sqrt(shift_px2) / focal, depth);
  motion.sigma_zoom = std::hypot(std::sqrt(found.covariance(3, 3)), params_.systematic_zoom);
  motion.sigma_roll_rad =
      std::hypot(std::sqrt(found.covariance(2, 2)), params_.systematic_rad, depth);
  motion.inliers = found.inliers;
  motion.blocks = found.blocks;
  return motion;
}

std::optional<ForwardMotion> ForwardTracker::Measure(Frame& frame) {
  if (!HasReference()) return std::nullopt;
  Registration found;
  bool placed = Against({reference_, {}, 0}, frame, found);
  if (!placed && last_ && found.verdict != registration::Verdict::kNoTexture) {
    placed = Against(*last_, frame, found);
    constexpr double kBridgePx = 1;
    if (placed) frame.variance_px2 += kBridgePx * kBridgePx;
  }
  if (!placed) {
    last_.reset();
    return std::nullopt;
  }
  last_ = frame;
  return Describe(frame, found);
}

void ForwardTracker::SetReference(const Frame& frame) {
  reference_ = frame.spectrum;
  if (!last_) return;
  last_->from_reference = Compose(last_->from_reference, frame.from_reference.Inverse());
  last_->variance_px2 = std::max(0.0, last_->variance_px2 - frame.variance_px2);
}

}  // namespace ceilmap::compensation
