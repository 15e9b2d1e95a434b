#include "compensation/mount/ceiling_recording.hpp"

#include <cmath>
#include <memory>
#include <utility>

#include "calib/base/degrees.hpp"
#include "compensation/mount/ceiling_pairs.hpp"
#include "compensation/mount/ceiling_registrar.hpp"

namespace ceilmap::mount {
namespace {

// Odd, so that thinning keeps the first and the newest. One image takes about 4 MB while pairs are
// measured.
constexpr std::size_t kMaxKeyframes = 97;
constexpr double kMinDistanceRatio = 0.035;
constexpr double kMinTurnRad = 4.5 * kRadPerDeg;

}  // namespace

CeilingRecorder::CeilingRecorder(const std::string& name, const calib::CeilingView& view)
    : view_(view),
      camera_(registration::PlaneCameraOf(view)),
      registrar_(CeilingRegistrar(view)),
      min_distance_ratio_(kMinDistanceRatio),
      min_turn_rad_(kMinTurnRad) {
  recording_.name = name;
}

bool CeilingRecorder::Add(const cv::Mat& image, std::optional<double> stamp_s) {
  recording_.has_stamps = stamp_s.has_value();
  const double time_s = stamp_s.value_or(static_cast<double>(recording_.frames));
  ++recording_.frames;
  AnalyzedKeyframe current{
      {image.clone(), {}, {}, time_s},
      path_.size(),
      registrar_.Analyze(view_.Rectify(image, buffer_, ExpectedVelocity(time_s)))};
  if (recording_.keyframes.empty()) {
    path_.push_back({time_s, {}});
    Keep(std::move(current));
    return true;
  }
  std::optional<Pose2> T_key_current = Match(current.spectrum);
  if (!T_key_current && last_) {
    Keep(std::move(*last_));
    last_.reset();
    T_key_current = Match(current.spectrum);
  }
  if (!T_key_current) return false;
  const Pose2 T_first_current = key_.keyframe.T_first_camera * *T_key_current;
  step_s_ = time_s - path_.back().stamp_s;
  step_ = T_first_last_.Inverse() * T_first_current;
  T_first_last_ = T_first_current;
  current.keyframe.T_first_camera = T_first_current;
  path_.push_back({time_s, T_first_current});
  if (IsFarFromKeyframe(*T_key_current)) {
    Keep(std::move(current));
    last_.reset();
  } else {
    last_ = std::move(current);
  }
  return true;
}

// Of base, as between the two images before; at rest after a gap, and where times are unknown.
Twist2 CeilingRecorder::ExpectedVelocity(double time_s) const {
  constexpr double kMaxSteps = 2.5;
  if (!recording_.has_stamps || path_.size() < 2) return {};
  if (time_s - path_.back().stamp_s > kMaxSteps * step_s_) return {};
  const calibration::ViewVelocity velocity = VelocityAt({{0, {}}, {step_s_, step_}}, 1);
  return InBase(velocity, view_.T_base_camera(), view_.MetresPerPixel() * view_.FocalLength());
}

CeilingRecording CeilingRecorder::Finish() {
  if (last_) Keep(std::move(*last_));
  KeepHeights();
  for (std::size_t i = 0; i < recording_.keyframes.size(); ++i) {
    recording_.keyframes[i].velocity = VelocityAt(path_, path_indices_[i]);
  }
  recording_.has_depth = 2 * matched_with_depth_ > recording_.frames;
  return std::move(recording_);
}

// With the heights of the keyframe, where one plane does not explain the images.
registration::Registration CeilingRecorder::Register(const registration::FrameSpectrum& current,
                                                     const Pose2& expected) {
  constexpr double kSigmaRatio = 0.1;  // of the image's width
  constexpr double kSigmaDeg = 10;
  const registration::MotionPrior prior{
      ImageMotionOf(camera_, expected), kSigmaRatio * view_.Size().width, kSigmaDeg * kRadPerDeg};
  registration::Registration found = registrar_.Register(key_.spectrum, current, prior);
  const bool plane = found.ok() && found.IsPlane();
  if (key_.spectrum.Heights() == nullptr && !plane &&
      found.verdict != registration::Verdict::kNoTexture) {
    const registration::Registration deep =
        registrar_.RegisterWithDepth(key_.spectrum, current, prior);
    if (deep.ShowsDepth()) found = deep;
  }
  return found;
}

std::optional<Pose2> CeilingRecorder::Match(registration::FrameSpectrum& current) {
  const Pose2 expected = key_.keyframe.T_first_camera.Inverse() * T_first_last_ * step_;
  const registration::Registration found = Register(current, expected);
  if (!found.ok()) return Follow(current, expected);
  if (found.heights) {
    ++matched_with_depth_;
    key_.spectrum.SetHeights(found.heights);
    current.SetHeights(std::make_shared<heights::HeightField>(
        registrar_.PredictHeights(key_.spectrum, found.motion)));
  }
  const registration::PlaneMotion motion =
      registration::PlaneMotion::FromSimilarity(camera_, found.motion);
  return Pose2{motion.x, motion.y, motion.yaw};
}

// The images of a tilted camera do not agree by a similarity: under a ceiling of little texture too
// few blocks may be left.
std::optional<Pose2> CeilingRecorder::Follow(const registration::FrameSpectrum& current,
                                             const Pose2& expected) {
  if (path_.size() < 2) return std::nullopt;  // nothing is known of the motion
  const registration::PlaneFit fit =
      registrar_.RefinePlane(key_.spectrum, current, camera_, LevelMotion(expected));
  constexpr int kMinBlocks = 12;
  constexpr double kMinInliers = 0.8;  // within a pixel
  constexpr double kMaxTilt = 0.02;    // of the robot
  // A camera that is mounted askew tilts against its own earlier image when the robot turns.
  constexpr double kMaxMountTilt = 0.3;
  const double max_tilt = kMaxTilt + 2 * kMaxMountTilt * std::abs(std::sin(fit.motion.yaw / 2));
  if (!fit.ok || fit.blocks < kMinBlocks || fit.inliers < kMinInliers * fit.blocks ||
      std::hypot(fit.motion.tilt_x, fit.motion.tilt_y) > max_tilt) {
    return std::nullopt;
  }
  return Pose2{fit.motion.x, fit.motion.y, fit.motion.yaw};
}

bool CeilingRecorder::IsFarFromKeyframe(const Pose2& T_key_current) const {
  const double shift_px = camera_.focal_px * T_key_current.Translation().norm();
  return shift_px > min_distance_ratio_ * std::hypot(view_.Size().width, view_.Size().height) ||
         std::abs(T_key_current.yaw) > min_turn_rad_;
}

// The images that follow a keyframe refine its heights.
void CeilingRecorder::KeepHeights() {
  if (recording_.keyframes.empty()) return;
  recording_.keyframes.back().heights = key_.spectrum.SharedHeights();
}

void CeilingRecorder::Keep(AnalyzedKeyframe frame) {
  KeepHeights();
  key_ = std::move(frame);
  T_first_last_ = key_.keyframe.T_first_camera;
  std::vector<CeilingKeyframe>& keyframes = recording_.keyframes;
  keyframes.push_back(key_.keyframe);
  path_indices_.push_back(key_.path_index);
  if (keyframes.size() < kMaxKeyframes) return;
  const std::size_t half = (keyframes.size() + 1) / 2;
  for (std::size_t i = 1; i < half; ++i) {
    keyframes[i] = std::move(keyframes[2 * i]);
    path_indices_[i] = path_indices_[2 * i];
  }
  keyframes.resize(half);
  path_indices_.resize(half);
  min_distance_ratio_ *= 2;
  min_turn_rad_ *= 2;
}

}  // namespace ceilmap::mount
