#include "compensation/ceiling_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/level_view.hpp"
#include "compensation/even_speed.hpp"

namespace ceilmap::compensation {

using Eigen::Isometry3d;
using registration::PlaneFit;
using registration::PlaneMotion;
using registration::Registration;

namespace {

// A fit is accepted when at least this ratio of its blocks, and at least `kMinInliers` of them, lie
// within a pixel, and the robust standard deviation of its residuals is at most `kMaxSigmaPx`.
constexpr double kMinInlierRatio = 0.4;
constexpr int kMinInliers = 10;
constexpr double kMaxSigmaPx = 0.4;
// A fit is accepted only when the standard deviation of its tilt is at most this, rad. A fit
// with a poor initial value can converge to a wrong minimum, where half of the blocks agree by
// chance. Such a fit has a large standard deviation.
constexpr double kMaxSigmaRad = 5e-3;
// Encoded images leave fewer exact blocks: where at least this ratio of the blocks agrees, the
// standard deviation may be this large, rad.
constexpr double kMinInlierRatioCoded = 0.75;
constexpr double kMaxSigmaCodedRad = 1e-2;
// A fit with a larger standard deviation than this is compared with one from a new initial
// value, rad.
constexpr double kVagueSigmaRad = 2e-3;
// A larger tilt is rejected as a wrong fit, rad: debris does not cause it.
constexpr double kMaxMeasuredRad = 0.25;
// Standard deviation of pitch and roll by errors that residuals do not show (things below the
// ceiling, compression), rad.
constexpr double kCeilingSystematicRad = 1.5e-4;
// Blocks of encoded images have errors in common: the codec moves areas larger than a block. The
// standard deviation of the tilt grows by this fraction where the codec removed all noise of the
// sensor. Without it, level frames of x264 at CRF 30 and 35 had up to 0.7 degrees.
constexpr double kCommonCodingErrors = 3;
// With more than this FrameSpectrum::CodingLoss no tilt is measured: x265 at CRF 40 and 45 gave
// level frames up to 4 degrees, with a standard deviation of a tenth of that.
constexpr double kMaxCodingLoss = 0.5;

// Under a ceiling with depth matching is less exact, because a block may show several surfaces: the
// limits that correspond to kMinInlierRatio, kMaxSigmaPx and kCeilingSystematicRad; ...
constexpr double kMinInlierRatioDepth = 0.3;
constexpr double kMaxSigmaDepthPx = 1.2;
constexpr double kDepthSystematicRad = 1.2e-3;
// ... the first of them for tilts larger than this, rad, which heights explain by chance: in a room
// of plain plaster one image in 1200 seemed to be tilted by 3 degrees, with 0.32 of its blocks; ...
constexpr double kSteepRad = 0.02;
constexpr double kMinInlierRatioSteep = 0.4;
// ... the factor of the variance of the tilt as of independent blocks (PlaneFit::tilt_spread),
// because blocks have errors in common; ...
constexpr double kDepthInflation = 14;
// ... and the number of standard deviations of its tilt below which a frame is level, so that it
// may refine the heights.
constexpr double kLevelSigmas = 3;
// Where fewer of the blocks agree with one plane, the ceiling may have depth.
constexpr double kPlaneInlierRatio = 0.75;
// Below this part a new reference is taken to be plane.
constexpr double kStillPlane = 0.05;
// Standard deviations of a predicted motion, where depth is searched.
constexpr double kPriorPx = 8;
constexpr double kPriorRad = 0.05;

registration::RegistrarParams ParamsFor(const calib::CeilingView& view) {
  registration::RegistrarParams params;
  SetForView(view, params);
  return params;
}

/// Standard deviation of the tilt with which limits are compared, rad.
double TiltSigma(const PlaneFit& fit) {
  return std::sqrt(fit.tilt_spread.trace());
}

/// Whether nearly all that is seen lies in one plane.
bool ShowsPlane(const PlaneFit& fit) {
  return fit.ok && fit.inliers >= kPlaneInlierRatio * fit.blocks;
}

/// Whether a plane is tilted that fits most blocks, but none as exactly as a plane does: two levels
/// of a ceiling, of which a tilted plane lies within a pixel.
bool LooksUneven(const PlaneFit& fit) {
  constexpr double kExactPx = 0.15;
  constexpr double kSigmas = 1.5;
  return fit.sigma_px > kExactPx &&
         std::hypot(fit.motion.tilt_x, fit.motion.tilt_y) > kSigmas * TiltSigma(fit);
}

/// The pose without its tilt: the pose of a level robot with the same foot and heading.
Isometry3d Levelled(const Isometry3d& T) {
  return ToSpace(FromSpace(T).pose, {});
}

}  // namespace

CeilingTracker::CeilingTracker(const calib::CeilingView& view)
    : view_(view),
      camera_(registration::PlaneCameraOf(view)),
      distance_m_(view.FocalLength() * view.MetresPerPixel()),
      registrar_(view.Size(), ParamsFor(view)) {
  if (!(camera_.focal_px > 0)) {
    throw InputError("tilt cannot be seen on the ceiling without a rig");
  }
}

CeilingTracker::Frame CeilingTracker::Analyze(const cv::Mat& image,
                                              double stamp_s,
                                              const registration::Encoding& encoding) {
  Frame frame;
  frame.image = {image.clone(), registrar_.Analyze(image, {}, encoding)};
  frame.stamp_s = stamp_s;
  return frame;
}

PlanarTilt CeilingTracker::Predict(double stamp_s) const {
  if (!last_) return {};
  if (!before_) return last_->at;
  const double part = StepsAhead(before_->stamp_s, last_->stamp_s, stamp_s);
  const Pose2 step = before_->at.pose.Inverse() * last_->at.pose;
  PlanarTilt ahead = last_->at;
  ahead.pose = last_->at.pose * Pose2{part * step.x, part * step.y, part * step.yaw};
  ahead.tilt.pitch_rad += part * (last_->at.tilt.pitch_rad - before_->at.tilt.pitch_rad);
  ahead.tilt.roll_rad += part * (last_->at.tilt.roll_rad - before_->at.tilt.roll_rad);
  return ahead;
}

PlaneMotion CeilingTracker::ToMotion(const PlanarTilt& at) const {
  const Isometry3d& T_base_camera = view_.T_base_camera();
  const PlanarTilt camera =
      FromSpace(T_base_camera.inverse() * ToSpace(at.pose, at.tilt) * T_base_camera);
  return {camera.pose.x / distance_m_,
          camera.pose.y / distance_m_,
          camera.tilt.lift_m / distance_m_,
          camera.pose.yaw,
          camera.tilt.roll_rad,
          camera.tilt.pitch_rad};
}

Isometry3d CeilingTracker::ToPose(const PlaneMotion& motion) const {
  const Pose2 planar{distance_m_ * motion.x, distance_m_ * motion.y, motion.yaw};
  const Tilt tilt{motion.tilt_y, motion.tilt_x, distance_m_ * motion.height, {}};
  const Isometry3d& T_base_camera = view_.T_base_camera();
  return T_base_camera * ToSpace(planar, tilt) * T_base_camera.inverse();
}

bool CeilingTracker::IsSound(const PlaneFit& fit, double coding_loss) const {
  if (reference_.spectrum.Heights() != nullptr) {
    const double tilt = std::hypot(fit.motion.tilt_x, fit.motion.tilt_y);
    const double min_ratio = tilt > kSteepRad ? kMinInlierRatioSteep : kMinInlierRatioDepth;
    return fit.ok && fit.inliers >= min_ratio * fit.blocks && fit.sigma_px <= kMaxSigmaDepthPx &&
           TiltSigma(fit) <= kMaxSigmaRad && tilt <= kMaxMeasuredRad;
  }
  const bool clear = coding_loss > 0 && fit.inliers >= kMinInlierRatioCoded * fit.blocks;
  return fit.ok && fit.inliers >= kMinInliers && fit.inliers >= kMinInlierRatio * fit.blocks &&
         fit.sigma_px <= kMaxSigmaPx &&
         TiltSigma(fit) <= (clear ? kMaxSigmaCodedRad : kMaxSigmaRad) &&
         std::hypot(fit.motion.tilt_x, fit.motion.tilt_y) <= kMaxMeasuredRad;
}

CeilingMotion CeilingTracker::Describe(const PlaneFit& fit) const {
  CeilingMotion motion;
  motion.T_reference_base = ToPose(fit.motion);
  motion.inliers = fit.inliers;
  motion.blocks = fit.blocks;
  const bool depth = reference_.spectrum.Heights() != nullptr;
  const double systematic = std::pow(depth ? kDepthSystematicRad : kCeilingSystematicRad, 2);
  // The median of few residuals is a poor scale. It is too small when the fit adapts to the
  // residuals.
  constexpr double kFewBlocks = 12;
  const double few = 1 + std::pow(kFewBlocks / fit.inliers, 2);
  motion.depth = depth;
  PlaneFit stated = fit;
  if (depth) {
    stated.covariance.bottomRightCorner<2, 2>() = kDepthInflation * fit.tilt_spread;
  }
  motion.covariance = few * registration::TiltOf(stated, view_).covariance;
  motion.covariance.diagonal().array() += systematic;
  // The visible fraction of the reference's image, for a level robot.
  const Pose2 planar = FromSpace(motion.T_reference_base).pose;
  const PlaneMotion level = ToMotion({planar, {}});
  registration::ImageMotion shift;
  const Eigen::Vector2d centre = level.Apply(camera_, Eigen::Vector2d::Zero());
  shift.tx_px = centre.x();
  shift.ty_px = centre.y();
  shift.theta_rad = -level.yaw;
  motion.overlap = registration::OverlapOf(shift, view_.Size());
  return motion;
}

/// For a poor prediction: the initial value is the similarity motion that a level robot would see.
PlaneFit CeilingTracker::Find(Frame& frame) {
  const Registration found = registrar_.Register(reference_.spectrum, frame.image.spectrum);
  if (found.verdict == registration::Verdict::kNoTexture) return {};
  return Fit(frame, PlaneMotion::FromSimilarity(camera_, found.motion));
}

PlaneFit CeilingTracker::Fit(const Frame& frame, const PlaneMotion& start) {
  return reference_.spectrum.Heights() != nullptr
             ? registrar_.RefineWithDepth(reference_.spectrum, frame.image.spectrum, start)
             : registrar_.RefinePlane(reference_.spectrum,
                                      frame.image.spectrum,
                                      camera_,
                                      start,
                                      {},
                                      registration::Effort::kTracking);
}

/// Whether heights explain the images where one plane does not; the reference then has them. Until
/// it has, the robot is taken to be level.
bool CeilingTracker::FindDepth(Frame& frame, const PlaneFit& plane) {
  PlanarTilt level = Predict(frame.stamp_s);
  level.tilt = {};
  registration::MotionPrior prior{ToMotion(level).ToSimilarity(camera_), kPriorPx, kPriorRad};
  const Registration deep = registrar_.RegisterWithDepth(
      reference_.spectrum,
      frame.image.spectrum,
      prior,
      plane.ok ? std::optional(plane.motion.ToSimilarity(camera_)) : std::nullopt);
  if (!deep.ShowsDepth()) return false;
  reference_.spectrum.SetHeights(deep.heights);
  return true;
}

/// Things at several heights that are not recognized yet look like a tilt. Where a part of the
/// blocks does not agree with the tilted plane, or all do poorly, and a level camera explains about
/// as many blocks as well, the robot is level, to within the tilt that was found.
PlaneFit CeilingTracker::PreferLevel(const Frame& frame, const PlaneFit& tilted) {
  constexpr double kLevelQuality = 0.7;
  // A true tilt that is larger than this, rad, leaves a level camera less: at most 0.06 of the
  // quality on two drives over debris, where one of 0.2 degrees left up to 0.21.
  constexpr double kLargeRad = 8e-3;
  constexpr double kLevelQualityLarge = 0.5;
  registration::PlaneFitParams params;
  params.fit_tilt = false;
  params.fit_height = false;
  PlaneMotion start = PlaneMotion::FromSimilarity(camera_, tilted.motion.ToSimilarity(camera_));
  start.height = 0;
  PlaneFit level =
      registrar_.RefinePlane(reference_.spectrum, frame.image.spectrum, camera_, start, params);
  const auto quality = [](const PlaneFit& fit) {
    return fit.inliers / (fit.sigma_px * fit.sigma_px);
  };
  const Eigen::Vector2d tilt(tilted.motion.tilt_x, tilted.motion.tilt_y);
  const double needed = tilt.norm() > kLargeRad ? kLevelQualityLarge : kLevelQuality;
  if (!level.ok || quality(level) < needed * quality(tilted)) return tilted;
  level.covariance = tilted.covariance;
  level.covariance.bottomRightCorner<2, 2>() += tilt * tilt.transpose();
  level.tilt_spread = tilted.tilt_spread + tilt * tilt.transpose();
  return level;
}

/// A level frame refines the heights of the reference.
void CeilingTracker::LearnHeights(const PlaneFit& fit) {
  const Eigen::Vector2d tilt(fit.motion.tilt_x, fit.motion.tilt_y);
  const Eigen::Matrix2d spread =
      kDepthInflation * fit.tilt_spread +
      kDepthSystematicRad * kDepthSystematicRad * Eigen::Matrix2d::Identity();
  if (!fit.level_heights || tilt.dot(spread.inverse() * tilt) > kLevelSigmas * kLevelSigmas) return;
  reference_.spectrum.SetHeights(fit.level_heights);
}

std::optional<CeilingMotion> CeilingTracker::Measure(Frame& frame) {
  if (!HasReference()) return std::nullopt;
  const double reference_loss = reference_.spectrum.CodingLoss();
  const double frame_loss = frame.image.spectrum.CodingLoss();
  const double loss = std::min(reference_loss, frame_loss);
  // Where one of the images is blurred, blocks agree at either end of the blur, some here and some
  // there, which looks like a tilt.
  if (loss > kMaxCodingLoss || frame.image.spectrum.IsBlurredBeside(reference_loss) ||
      reference_.spectrum.IsBlurredBeside(frame_loss)) {
    return std::nullopt;
  }
  PlaneFit fit = Fit(frame, ToMotion(Predict(frame.stamp_s)));
  const bool plane = reference_.spectrum.Heights() == nullptr;
  if (plane && !ShowsPlane(fit)) {
    // After a gap the prediction may be wrong, and heights explain what it leaves unexplained.
    const PlaneFit anywhere = Find(frame);
    if (IsSound(anywhere, loss) && ShowsPlane(anywhere)) {
      fit = anywhere;
      last_.reset();
      before_.reset();
    } else if (FindDepth(frame, fit)) {
      PlanarTilt level = Predict(frame.stamp_s);
      level.tilt = {};
      fit = Fit(frame, ToMotion(level));
    }
  }
  const bool sound = IsSound(fit, loss);
  if (!sound || TiltSigma(fit) > kVagueSigmaRad) {
    const PlaneFit found = Find(frame);
    const bool better = IsSound(found, loss) && (!sound || TiltSigma(found) < TiltSigma(fit));
    if (better || !sound) {
      last_.reset();
      before_.reset();
    }
    if (better) fit = found;
    if (!better && !sound) return std::nullopt;
  }
  if (reference_.spectrum.Heights() != nullptr) {
    LearnHeights(fit);
  } else if (!ShowsPlane(fit) || LooksUneven(fit)) {
    // After all searches, which would take its doubt for a poor start.
    fit = PreferLevel(frame, fit);
  }
  CeilingMotion motion = Describe(fit);
  const double smoothing =
      std::min(reference_.spectrum.SmoothingLoss(), frame.image.spectrum.SmoothingLoss());
  motion.covariance *= std::pow(1 + kCommonCodingErrors * smoothing, 2);
  frame.T_reference_base = motion.T_reference_base;
  if (!last_ || last_->stamp_s < frame.stamp_s) before_ = last_;  // not measured again
  last_ = Moment{FromSpace(motion.T_reference_base), frame.stamp_s};
  return motion;
}

bool CeilingTracker::IsBare(const Frame& frame) {
  return !registrar_.Refine(frame.image.spectrum, frame.image.spectrum, {}).ok();
}

void CeilingTracker::MoveTo(const Isometry3d& T_reference_new) {
  const Isometry3d T_new_reference = Levelled(T_reference_new).inverse();
  for (std::optional<Moment>* moment : {&last_, &before_}) {
    if (!*moment) continue;
    PlanarTilt& at = (*moment)->at;
    at = FromSpace(T_new_reference * ToSpace(at.pose, at.tilt));
  }
}

/// @param T_old_new  motion of the level robot from the old reference to the new one.
void CeilingTracker::TakeReference(const registration::AnalyzedImage& image,
                                   const Isometry3d& T_old_new) {
  const registration::AnalyzedImage old = reference_;
  reference_ = image;
  if (old.spectrum.Heights() == nullptr) return;
  const PlanarTilt forth{FromSpace(T_old_new).pose, {}};
  const PlanarTilt back{forth.pose.Inverse(), {}};
  const auto set = [this](heights::HeightField field) {
    reference_.spectrum.SetHeights(std::make_shared<const heights::HeightField>(std::move(field)));
  };
  set(registrar_.PredictHeights(old.spectrum, ToMotion(forth).ToSimilarity(camera_)));
  heights::HeightField refined = registrar_.RefineHeights(
      reference_.spectrum, old.spectrum, ToMotion(back).ToSimilarity(camera_));
  heights::PullToReference(refined);
  set(std::move(refined));
  if (reference_.spectrum.Heights()->DepthRatio() < kStillPlane) {
    reference_.spectrum.SetHeights(nullptr);
  }
}

void CeilingTracker::SetReference(const Frame& frame) {
  MoveTo(frame.T_reference_base);
  reference_content_.release();
  TakeReference(frame.image, Levelled(frame.T_reference_base));
}

void CeilingTracker::SetReference(const Frame& frame, const cv::Mat& level) {
  MoveTo(frame.T_reference_base);
  reference_content_ = calib::ContentMask(level);
  TakeReference({level.clone(), registrar_.Analyze(level, reference_content_)},
                Levelled(frame.T_reference_base));
}

}  // namespace ceilmap::compensation
