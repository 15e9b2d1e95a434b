#include "compensation/matsumoto_tilt.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <future>

#include "calib/base/error.hpp"
#include "calib/base/stage_timer.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/forward_view.hpp"
#include "compensation/forward_equation.hpp"
#include "compensation/forward_tracker.hpp"
#include "compensation/level_frames.hpp"
#include "compensation/rig_cameras.hpp"
#include "compensation/similarity_tracker.hpp"

namespace ceilmap::compensation {

using Eigen::Vector2d;

namespace {

// Standard deviation of Cx, m.
constexpr double kSeenMotionSigmaM = 0.003;

double Square(double value) {
  return value * value;
}

/// Both images of a frame.
struct ImagePair {
  SimilarityTracker::Frame up;
  std::optional<ForwardTracker::Frame> forward;  // unset: no image, or one without texture
  bool level = false;                            // measured to be level
};

}  // namespace

struct MatsumotoTilt::Impl {
  Impl(const calib::Rig& robot, double sigmas)
      : rig(robot),
        level_sigmas(sigmas),
        up_view(UpOf(rig), rig.ceiling_height_m),
        forward_view(ForwardOf(rig)),
        up(up_view),
        forward(forward_view),
        front_climbs(TiltModel(-rig.axle_behind_mast_m, rig.ceiling_height_m), ForwardHeight(rig)),
        rear_climbs(TiltModel(0, rig.ceiling_height_m), ForwardHeight(rig)) {}

  struct Seen {
    std::optional<Pose2> T_level_frame;  // by the upward camera, as if both were level
    std::optional<ForwardMotion> forward;
  };
  Seen Observe(const TiltFrame& frame, ImagePair& images);
  [[nodiscard]] double SeenMotion(const Pose2& T_level_frame) const;
  [[nodiscard]] std::optional<TiltAngles> Solve(const Seen& seen) const;
  void Take(const TiltAngles& measured, TiltEstimate& estimate);
  void Renew(const ImagePair& images, double zoom);
  void MakeLevelFrame(const ImagePair& images);

  calib::Rig rig;
  double level_sigmas;
  calib::CeilingView up_view;
  calib::ForwardView forward_view;
  SimilarityTracker up;
  ForwardTracker forward;
  ForwardEquation front_climbs;
  ForwardEquation rear_climbs;
  TiltReport report;

  std::deque<ImagePair> recent;   // measured since B, the latest ones, oldest first
  double reference_variance = 0;  // of the tilt of B
  bool tilted_since = false;      // a frame since B was not level
  int failed = 0;                 // consecutive frames without a measurement
  cv::Mat rectified;
  cv::Mat forward_rectified;
};

MatsumotoTilt::Impl::Seen MatsumotoTilt::Impl::Observe(const TiltFrame& frame, ImagePair& images) {
  Seen seen;
  std::future<void> ahead;
  if (frame.forward.empty()) {
    ++report.without_forward;
  } else {
    ahead = std::async(std::launch::async, [&] {
      const StageTimer timer(report.forward_ms);
      images.forward =
          forward.Analyze(forward_view.Rectify(frame.forward, forward_rectified), frame.stamp_s);
      seen.forward = forward.Measure(*images.forward);
      if (!seen.forward && forward.IsBare(*images.forward)) images.forward.reset();
    });
  }
  {
    const StageTimer timer(report.ceiling_ms);
    images.up = up.Analyze(up_view.Rectify(frame.up, rectified, frame.velocity), frame.encoding);
    seen.T_level_frame = up.Measure(images.up);
  }
  if (ahead.valid()) ahead.get();
  return seen;
}

/// Cx of Eq. (1): from the ceiling point on the axis of the upward camera in the frame to the one
/// in B, along the view of the forward camera in the frame.
double MatsumotoTilt::Impl::SeenMotion(const Pose2& T_level_frame) const {
  const Vector2d camera = up_view.T_base_camera().translation().head<2>();
  const double yaw = T_level_frame.yaw + forward_view.Yaw();
  return Vector2d(std::cos(yaw), std::sin(yaw)).dot(camera - T_level_frame * camera);
}

/// Eq. (1) for the pitch; the roll is the rotation of the forward image.
std::optional<TiltAngles> MatsumotoTilt::Impl::Solve(const Seen& seen) const {
  if (!seen.forward || !seen.T_level_frame) return std::nullopt;
  const ForwardMotion& ahead = *seen.forward;
  const ForwardEquation& equation = ahead.tan_shift < 0 ? front_climbs : rear_climbs;
  const ForwardSolution solution =
      equation.SolveFromZoom({ahead.tan_shift, ahead.zoom, SeenMotion(*seen.T_level_frame)});
  if (solution.tilts.empty()) return std::nullopt;
  const ForwardTilt& pitch = solution.tilts.front();
  const ForwardSensitivity& by = pitch.sensitivity;
  const double variance = Square(by.by_tan_shift * ahead.sigma_tan_shift) +
                          Square(by.by_zoom * ahead.sigma_zoom) +
                          Square(by.by_seen_motion_m * kSeenMotionSigmaM);
  TiltAngles tilt =
      InAxesOfBase(forward_view.Yaw(),
                   {pitch.tilt_rad, ahead.roll_rad},
                   {std::min(variance, Square(kUnknownSigmaRad)), Square(ahead.sigma_roll_rad)});
  tilt.covariance += reference_variance * Eigen::Matrix2d::Identity();
  return tilt;
}

/// The tilt of the frame is what was measured, no more.
void MatsumotoTilt::Impl::Take(const TiltAngles& measured, TiltEstimate& estimate) {
  estimate.by_forward = measured;
  estimate.source = TiltSource::kForward;
  Tilt& tilt = estimate.tilt;
  tilt.pitch_rad = measured.angles[0];
  tilt.roll_rad = measured.angles[1];
  tilt.lift_m = rig.axle_behind_mast_m * std::sin(std::max(0.0, -tilt.pitch_rad));
  tilt.covariance = measured.covariance;
  ++report.by_forward;
  report.largest_rad = std::max(report.largest_rad, measured.angles.norm());
}

void MatsumotoTilt::Impl::MakeLevelFrame(const ImagePair& images) {
  forward.SetReference(*images.forward);
  recent.clear();
  tilted_since = false;
  failed = 0;
  ++report.keyframes;
}

/// Makes one of the last frames the level frame B, when a new one is needed.
void MatsumotoTilt::Impl::Renew(const ImagePair& images, double zoom) {
  tilted_since = tilted_since || !images.level;
  recent.push_back(images);
  if (static_cast<int>(recent.size()) > kLevelFrames) recent.pop_front();
  const bool needed = tilted_since || std::abs(zoom - 1) > kRenewZoom;
  if (!needed || static_cast<int>(recent.size()) < kLevelFrames) return;
  const bool all_level =
      std::all_of(recent.begin(), recent.end(), [](const ImagePair& each) { return each.level; });
  if (!all_level) return;
  const ImagePair middle = recent[kLevelFrames / 2];
  up.SetReference(middle.up);
  MakeLevelFrame(middle);
}

MatsumotoTilt::MatsumotoTilt(const calib::Rig& rig, double level_sigmas)
    : impl_(std::make_unique<Impl>(rig, level_sigmas)) {}
MatsumotoTilt::~MatsumotoTilt() = default;
MatsumotoTilt::MatsumotoTilt(MatsumotoTilt&&) noexcept = default;
MatsumotoTilt& MatsumotoTilt::operator=(MatsumotoTilt&&) noexcept = default;

TiltEstimate MatsumotoTilt::Estimate(const TiltFrame& frame) {
  Impl& me = *impl_;
  ++me.report.frames;
  ImagePair images;
  const Impl::Seen seen = me.Observe(frame, images);
  TiltEstimate estimate;
  estimate.up = images.up.image;
  if (const std::optional<TiltAngles> measured = me.Solve(seen)) {
    me.failed = 0;
    me.Take(*measured, estimate);
    images.level = measured->Sigmas() <= me.level_sigmas;
    me.report.level += images.level ? 1 : 0;
    me.Renew(images, seen.forward->zoom);
    return estimate;
  }
  ++me.report.unknown;
  ++me.report.level;  // is taken as level
  ++me.failed;
  me.recent.clear();
  const bool first = me.report.frames == 1;
  if (!first) {
    estimate.tilt.covariance = Square(kUnknownSigmaRad) * Eigen::Matrix2d::Identity();
  }
  const bool begins = !me.forward.HasReference() || me.failed > kRestartAfter;
  if (begins && images.forward && !me.up.IsBare(images.up)) {
    me.up.Restart(images.up);
    me.MakeLevelFrame(images);
    me.reference_variance = first ? 0 : Square(kAssumedSigmaRad);
  }
  return estimate;
}

const TiltReport& MatsumotoTilt::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::compensation
