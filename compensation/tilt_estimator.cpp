#include "compensation/tilt_estimator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <future>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"
#include "calib/level_view.hpp"
#include "compensation/ceiling_tracker.hpp"
#include "compensation/forward_tracker.hpp"
#include "compensation/level_frames.hpp"
#include "compensation/matsumoto_tilt.hpp"
#include "compensation/rig_cameras.hpp"
#include "compensation/shutter_tracker.hpp"
#include "compensation/usual_tilt.hpp"

namespace ceilmap::compensation {

using Eigen::Isometry3d;

namespace {

// After level frames measured by the ceiling, both limits of the tilt (TiltEstimatorParams) are
// larger by this number of standard deviations: among many frames some are noisy, and a real bump
// rises fast.
constexpr double kNoiseMarginSigmas = 1;
// A new keyframe is needed when the robot has been tilted since the last one, when less than this
// of the keyframe's ceiling is visible, or when the zoom of the forward image has changed
// (kRenewZoom).
constexpr double kRenewOverlap = 0.8;
constexpr double kRenewOverlapDepth = 0.92;  // under a ceiling with depth
// A keyframe whose rows may show such a tilt, rad, waits for a better one down to this overlap.
constexpr double kUnsteadyRad = 1e-3;
constexpr double kUnsteadyOverlap = 0.7;
// A tilted frame becomes the keyframe, drawn level, when the visible fraction is below this.
constexpr double kMinOverlap = 0.55;
// A contradiction by the map counts from this angle on, rad. The keyframe is corrected after
// `kCorrectAfter` consecutive contradictions.
constexpr double kCorrectRad = 1.5e-3;
constexpr int kCorrectAfter = 3;

/// A frame stored as a candidate for the next keyframe.
struct Moment {
  CeilingTracker::Frame ceiling;
  bool has_ceiling = false;                      // measured against the reference
  bool has_pose = false;                         // the same, or the reference itself
  std::optional<ForwardTracker::Frame> forward;  // unset when the image has no texture
  bool level = false;
  // Of the tilt that the rows of a rolling shutter show, because the velocity is not known better.
  double shutter_variance = 0;
  Twist2 assumed;  // velocity with which the ceiling's image was rectified
};

bool IsSteady(const Moment& moment) {
  return moment.shutter_variance < kUnsteadyRad * kUnsteadyRad;
}

}  // namespace

struct TiltEstimator::Impl {
  Impl(const calib::Rig& robot, const TiltEstimatorParams& p)
      : rig(robot),
        params(p),
        view(UpOf(rig), rig.ceiling_height_m),
        level_view(view),
        ceiling(view),
        filter(p.filter),
        shutter(view, level_view, ceiling) {
    if (!(params.tilted_sigmas > params.level_sigmas)) {
      throw InputError(fmt::format("tilt: tilted_sigmas = {}, must be > level_sigmas = {}",
                                   params.tilted_sigmas,
                                   params.level_sigmas));
    }
    if (params.method == TiltMethod::kMatsumoto) {
      matsumoto.emplace(rig, params.level_sigmas);
      return;
    }
    const bool wants_forward = params.method != TiltMethod::kCeiling;
    if (!wants_forward || (!rig.forward && params.method == TiltMethod::kFused)) return;
    forward_view = std::make_unique<calib::ForwardView>(ForwardOf(rig));
    forward = std::make_unique<ForwardTracker>(*forward_view);
    solver = std::make_unique<ForwardSolver>(rig, forward_view->Yaw(), params.solver);
  }

  calib::Rig rig;
  TiltEstimatorParams params;
  std::optional<MatsumotoTilt> matsumoto;  // set: it measures, and nothing below is used
  calib::CeilingView view;
  calib::LevelView level_view;
  CeilingTracker ceiling;
  std::unique_ptr<calib::ForwardView> forward_view;
  std::unique_ptr<ForwardTracker> forward;
  std::unique_ptr<ForwardSolver> solver;
  TiltFilter filter;
  TiltReport report;

  std::optional<TiltAngles> correction;  // to apply to the next frame
  // Pose of the forward keyframe in the ceiling's keyframe. Unset: the ceiling did not measure it.
  std::optional<Isometry3d> T_reference_forward = Isometry3d::Identity();
  double reference_variance = 0;  // of the tilt of the ceiling's keyframe
  std::optional<double> last_stamp_s;
  ShutterTracker shutter;
  std::deque<Moment> moments;  // the latest ones, oldest first
  cv::Mat forward_rectified;
  UsualTilt usual;
  int ceiling_failed = 0;       // consecutive frames without a measurement
  int forward_failed = 0;       // the same for the forward camera, images with texture only
  int contradictions = 0;       // consecutive
  bool tilted_since = false;    // a tilted frame was measured since the last keyframe
  bool bare_reference = false;  // the ceiling's reference has no texture

  struct Seen {
    std::optional<CeilingMotion> ceiling;
    std::optional<ForwardMotion> forward;
  };
  void Check(const TiltFrame& frame) const;
  std::optional<CeilingMotion> MeasureCeiling(const TiltFrame& frame, Moment& moment);
  Seen Observe(const TiltFrame& frame, Moment& moment);
  [[nodiscard]] std::optional<double> CeilingMotionToForward(const Seen& seen) const;
  void Measure(const Seen& seen, TiltEstimate& estimate);
  void Fuse(TiltEstimate& estimate);
  void Decide(const Seen& seen, Moment& moment, TiltEstimate& estimate);
  void ApplyCorrection(Moment& moment, TiltEstimate& estimate);
  void Renew(const Seen& seen);
  [[nodiscard]] bool WantsNewBeginning(const Moment& moment);
  void BeginAnew(const TiltFrame& frame, Moment& moment, const TiltEstimate& estimate);
  void CountFrom(const Moment& keyframe);
  void MakeKeyframe(const Moment& moment);
  void MakeTiltedKeyframe(const Moment& moment, const Tilt& tilt);
};

void TiltEstimator::Impl::Check(const TiltFrame& frame) const {
  if (!std::isfinite(frame.stamp_s) || (last_stamp_s && !(frame.stamp_s > *last_stamp_s))) {
    throw InputError(fmt::format("a frame's time, {} s, is not later than that of the frame before",
                                 frame.stamp_s));
  }
}

std::optional<CeilingMotion> TiltEstimator::Impl::MeasureCeiling(const TiltFrame& frame,
                                                                 Moment& moment) {
  const Moment* const last = moments.size() > 1 ? &moments[moments.size() - 2] : nullptr;
  ShutterTracker::Before before;
  if (last != nullptr && last->has_pose) before = {&last->ceiling, last->has_ceiling};
  ShutterTracker::Measurement seen = shutter.Measure(frame, before);
  moment.ceiling = std::move(seen.frame);
  moment.assumed = seen.assumed;
  moment.shutter_variance = seen.tilt_variance;
  return seen.motion;
}

TiltEstimator::Impl::Seen TiltEstimator::Impl::Observe(const TiltFrame& frame, Moment& moment) {
  Seen seen;
  std::future<void> ahead;
  if (forward && !frame.forward.empty()) {
    ahead = std::async(std::launch::async, [&] {
      const StageTimer timer(report.forward_ms);
      moment.forward =
          forward->Analyze(forward_view->Rectify(frame.forward, forward_rectified), frame.stamp_s);
      seen.forward = forward->Measure(*moment.forward);
      // An image of a covered camera cannot become a keyframe.
      if (!seen.forward && forward->IsBare(*moment.forward)) moment.forward.reset();
    });
  }
  {
    const StageTimer timer(report.ceiling_ms);
    seen.ceiling = MeasureCeiling(frame, moment);
    moment.has_ceiling = moment.has_pose = seen.ceiling.has_value();
  }
  if (ahead.valid()) ahead.get();
  return seen;
}

/// Cx of Eq. (1): from the ceiling point on the optical axis in the frame to the one in the forward
/// keyframe, along the direction of the forward camera in the frame.
std::optional<double> TiltEstimator::Impl::CeilingMotionToForward(const Seen& seen) const {
  if (!seen.ceiling || !T_reference_forward) return std::nullopt;
  const PlanarTilt at = FromSpace(T_reference_forward->inverse() * seen.ceiling->T_reference_base);
  const Eigen::Vector2d camera = view.T_base_camera().translation().head<2>();
  // Both points in the level base of the forward keyframe.
  const Eigen::Vector2d frame_sees = at.pose * (camera + level_view.CeilingShift(at.tilt)).eval();
  const double yaw = at.pose.yaw + forward_view->Yaw();
  return Eigen::Vector2d(std::cos(yaw), std::sin(yaw)).dot(camera - frame_sees);
}

void TiltEstimator::Impl::Measure(const Seen& seen, TiltEstimate& estimate) {
  if (seen.ceiling) {
    const Tilt tilt = FromSpace(seen.ceiling->T_reference_base).tilt;
    TiltAngles angles{{tilt.pitch_rad, tilt.roll_rad}, seen.ceiling->covariance};
    angles.covariance += reference_variance * Eigen::Matrix2d::Identity();
    estimate.by_ceiling = angles;
    ++report.by_ceiling;
  }
  if (seen.forward) {
    estimate.by_forward = solver->Solve(*seen.forward, CeilingMotionToForward(seen));
    if (estimate.by_forward) ++report.by_forward;
  }
}

void TiltEstimator::Impl::Fuse(TiltEstimate& estimate) {
  const bool use_ceiling = params.method != TiltMethod::kForward && estimate.by_ceiling;
  const bool use_forward = params.method != TiltMethod::kCeiling && estimate.by_forward;
  // The ceiling is an absolute measurement checked by many blocks: it overrides the prediction.
  if (use_ceiling && !filter.Update(*estimate.by_ceiling)) filter.Restart(*estimate.by_ceiling);
  bool took_forward = false;
  if (use_forward) {
    took_forward = filter.Update(*estimate.by_forward);
    if (!took_forward) ++report.forward_refused;
    if (!took_forward && !use_ceiling) {
      filter.Restart(*estimate.by_forward);
      took_forward = true;
    }
  }
  estimate.source = use_ceiling && took_forward ? TiltSource::kBoth
                    : use_ceiling               ? TiltSource::kCeiling
                    : took_forward              ? TiltSource::kForward
                                                : TiltSource::kNone;
  if (estimate.source == TiltSource::kNone) ++report.unknown;
}

/// Decides whether the frame is level, and sets its tilt.
void TiltEstimator::Impl::Decide(const Seen& seen, Moment& moment, TiltEstimate& estimate) {
  const TiltAngles now =
      estimate.source == TiltSource::kNone ? usual.Combine(filter.Now()) : filter.Now();
  const bool by_ceiling =
      estimate.source == TiltSource::kCeiling || estimate.source == TiltSource::kBoth;
  // Measured by the ceiling, against a keyframe that is level.
  const bool exact = by_ceiling && reference_variance == 0;
  const bool was_level = std::all_of(
      moments.begin(), moments.end() - 1, [](const Moment& before) { return before.level; });
  const double sigmas = now.Sigmas() - (was_level && exact ? kNoiseMarginSigmas : 0);
  const double part = std::clamp(
      (sigmas - params.level_sigmas) / (params.tilted_sigmas - params.level_sigmas), 0.0, 1.0);
  moment.level = part < 1;
  report.level += part == 0 ? 1 : 0;
  if (by_ceiling) usual.Add(part * now.angles);
  tilted_since = tilted_since || !moment.level;
  Tilt& tilt = estimate.tilt;
  // The first frame is level by definition. A frame that the ceiling shows to be level is exactly
  // level. The forward camera does not detect the foot of a bump.
  const bool sure = report.frames == 1 || exact;
  if (part > 0 || !sure) {
    const double most = kUnknownSigmaRad * kUnknownSigmaRad;
    const double variance = now.covariance.diagonal().maxCoeff();
    tilt.covariance = now.covariance * std::min(1.0, most / variance);
  }
  if (part == 0) return;
  tilt.pitch_rad = part * now.angles[0];
  tilt.roll_rad = part * now.angles[1];
  report.largest_rad = std::max(report.largest_rad, part * now.angles.norm());
  const bool measured = seen.ceiling && params.method != TiltMethod::kForward;
  // Rising wheels before the mast lift its foot. For other wheels the pivot's height is unknown.
  tilt.lift_m = measured ? part * seen.ceiling->T_reference_base.translation().z()
                         : rig.axle_behind_mast_m * std::sin(std::max(0.0, -tilt.pitch_rad));
}

/// Transforms all stored poses from the old keyframe to this one.
void TiltEstimator::Impl::CountFrom(const Moment& keyframe) {
  const Isometry3d T_new_old =
      ToSpace(FromSpace(keyframe.ceiling.T_reference_base).pose, {}).inverse();
  for (Moment& moment : moments) {
    moment.ceiling.T_reference_base = T_new_old * moment.ceiling.T_reference_base;
  }
  if (T_reference_forward) T_reference_forward = T_new_old * *T_reference_forward;
  shutter.Forget();
  ++report.keyframes;
}

void TiltEstimator::Impl::MakeKeyframe(const Moment& moment) {
  ceiling.SetReference(moment.ceiling);
  tilted_since = false;
  reference_variance = IsSteady(moment) ? 0 : moment.shutter_variance;
  CountFrom(moment);
  if (!forward || !moment.forward) return;
  forward->SetReference(*moment.forward);
  forward_failed = 0;
  if (T_reference_forward) {
    const Eigen::Vector2d step = T_reference_forward->inverse().translation().head<2>();
    const double yaw = forward_view->Yaw();
    solver->MoveKeyframe(Eigen::Vector2d(std::cos(yaw), std::sin(yaw)).dot(step));
  }
  T_reference_forward = Isometry3d::Identity();
}

/// Draws the ceiling's image level; the forward keyframe stays.
void TiltEstimator::Impl::MakeTiltedKeyframe(const Moment& moment, const Tilt& tilt) {
  cv::Mat level;
  level_view.Draw(moment.ceiling.image.pixels, tilt, level);
  ceiling.SetReference(moment.ceiling, level);
  reference_variance = 0.5 * tilt.covariance.trace();
  CountFrom(moment);
}

/// The keyframe was tilted by the residual tilt that the map measured.
void TiltEstimator::Impl::ApplyCorrection(Moment& moment, TiltEstimate& estimate) {
  TiltAngles tilt = filter.Now();
  tilt.angles += correction->angles;
  tilt.covariance = correction->covariance;
  correction.reset();
  filter.Restart(tilt);
  moment.level = tilt.Sigmas() < params.tilted_sigmas;
  estimate.tilt.covariance = tilt.covariance;
  estimate.tilt.pitch_rad = moment.level ? 0 : tilt.angles[0];
  estimate.tilt.roll_rad = moment.level ? 0 : tilt.angles[1];
  if (moment.level) {
    estimate.tilt.lift_m = 0;
    MakeKeyframe(Moment(moment));
  } else {
    MakeTiltedKeyframe(Moment(moment), estimate.tilt);
  }
  ++report.corrected;
}

/// True when no frame can be measured against the ceiling's keyframe. A keyframe taken in the dark
/// is replaced as soon as an image has texture.
bool TiltEstimator::Impl::WantsNewBeginning(const Moment& moment) {
  if (!ceiling.HasReference() || ceiling_failed >= kRestartAfter) return true;
  return bare_reference && ceiling_failed > 0 && !ceiling.IsBare(moment.ceiling);
}

void TiltEstimator::Impl::BeginAnew(const TiltFrame& frame,
                                    Moment& moment,
                                    const TiltEstimate& estimate) {
  moment.ceiling.T_reference_base = Isometry3d::Identity();
  moment.has_pose = true;
  T_reference_forward.reset();
  if (moment.level) {
    MakeKeyframe(Moment(moment));
  } else {
    MakeTiltedKeyframe(Moment(moment), estimate.tilt);
  }
  // The first keyframe is level by definition.
  if (report.frames > 1) reference_variance = std::pow(kAssumedSigmaRad, 2);
  ceiling_failed = 0;
  bare_reference = ceiling.IsBare(moment.ceiling);
  if (moment.level) shutter.Begin(frame, moment.assumed);
}

/// Makes one of the preceding level frames the keyframe, when a new keyframe is needed.
void TiltEstimator::Impl::Renew(const Seen& seen) {
  const bool far = seen.ceiling && seen.ceiling->overlap <
                                       (seen.ceiling->depth ? kRenewOverlapDepth : kRenewOverlap);
  const bool near = seen.forward && std::abs(seen.forward->zoom - 1) > kRenewZoom;
  const bool none =
      moments.back().forward && (!forward->HasReference() || forward_failed >= kRestartAfter);
  if (!far && !near && !none && !tilted_since) return;
  if (static_cast<int>(moments.size()) < kLevelFrames) return;
  const bool all_level = std::all_of(moments.begin(), moments.end(), [](const Moment& moment) {
    return moment.level && moment.has_ceiling;
  });
  if (!all_level) return;
  const Moment& middle = moments[moments.size() / 2];
  const bool waits = seen.ceiling && seen.ceiling->overlap > kUnsteadyOverlap;
  if (IsSteady(middle) || !waits) MakeKeyframe(Moment(middle));
}

TiltEstimator::TiltEstimator(const calib::Rig& rig, const TiltEstimatorParams& params)
    : impl_(std::make_unique<Impl>(rig, params)) {}
TiltEstimator::~TiltEstimator() = default;
TiltEstimator::TiltEstimator(TiltEstimator&&) noexcept = default;
TiltEstimator& TiltEstimator::operator=(TiltEstimator&&) noexcept = default;

TiltEstimate TiltEstimator::Estimate(const TiltFrame& frame) {
  Impl& me = *impl_;
  me.Check(frame);
  me.last_stamp_s = frame.stamp_s;
  if (me.matsumoto) return me.matsumoto->Estimate(frame);
  ++me.report.frames;
  if (me.forward && frame.forward.empty()) ++me.report.without_forward;

  me.moments.emplace_back();
  if (static_cast<int>(me.moments.size()) > kLevelFrames) me.moments.pop_front();
  Moment& moment = me.moments.back();
  const Impl::Seen seen = me.Observe(frame, moment);
  TiltEstimate estimate;
  estimate.up = moment.ceiling.image;
  me.filter.Predict(frame.stamp_s);
  me.Measure(seen, estimate);
  me.Fuse(estimate);
  me.Decide(seen, moment, estimate);

  if (me.correction && seen.ceiling) {
    me.ApplyCorrection(moment, estimate);
    return estimate;
  }
  me.ceiling_failed = seen.ceiling ? 0 : me.ceiling_failed + 1;
  if (moment.forward) me.forward_failed = seen.forward ? 0 : me.forward_failed + 1;
  if (me.WantsNewBeginning(moment)) {
    me.BeginAnew(frame, moment, estimate);
  } else if (seen.ceiling && seen.ceiling->overlap < kMinOverlap && !moment.level) {
    me.MakeTiltedKeyframe(Moment(moment), estimate.tilt);
  } else {
    me.Renew(seen);
  }
  return estimate;
}

void TiltEstimator::Correct(const TiltAngles& left) {
  Impl& me = *impl_;
  if (me.matsumoto) return;
  constexpr double kSigmas = 4;
  const bool contradicts = left.angles.norm() > kCorrectRad && left.Sigmas() > kSigmas;
  me.contradictions = contradicts ? me.contradictions + 1 : 0;
  if (me.contradictions < kCorrectAfter) return;
  me.contradictions = 0;
  me.correction = left;
}

std::optional<CorrectedImage> TiltEstimator::TakeCorrected() {
  return impl_->shutter.TakeCorrected();
}

const TiltReport& TiltEstimator::Report() const {
  return impl_->matsumoto ? impl_->matsumoto->Report() : impl_->report;
}

}  // namespace ceilmap::compensation
