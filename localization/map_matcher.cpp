#include "localization/map_matcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/level_view.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::localization {

using registration::FrameSpectrum;
using registration::MotionPrior;
using registration::Registrar;
using registration::Registration;

namespace {

// A match is rejected when its scale differs by more than this from what the rig implies.
constexpr double kMaxScaleError = 0.05;
// MapMatch::distinct. Of 118 matches at the right places of a simulated plant 110 had a peak of
// 0.16 or more; none of 150 at wrong places remained where it was.
constexpr double kDistinctPeak = 0.5;
constexpr double kDistinctDepthPeak = 0.15;
// Standard deviation of a residual tilt, beyond what residuals show, rad, > 0.
constexpr double kTiltNoiseRad = 3e-4;
// Standard deviations of a match with the map by errors that residuals do not show (things below
// the ceiling, sampling).
constexpr mapping::EdgeNoise kMatchNoise{0.012, 3e-5};
// A corrected pose (CorrectNear) is reported where its standard deviation is smaller, px.
constexpr double kMaxCorrectedSigmaPx = 8;
// ... and this part of the blocks agrees. At wrong places it was up to 0.08.
constexpr double kMinCorrectedInliers = 0.2;
// ... or where the evidence of all blocks is so many times that of chance.
constexpr double kMinCorrectedPeaks = 1.5;

/// The camera's view when everything that it sees is `scale` times as large as the rig implies, in
/// pixels.
calib::CeilingView MakeView(const calib::MountedCamera& up, double ceiling_height_m, double scale) {
  const double camera_m = up.T_base_cam.translation().z();
  return {up, camera_m + (ceiling_height_m - camera_m) / scale};
}

calib::CeilingView MakeFirstView(const store::MapReader& map, const calib::MountedCamera& up) {
  const store::MapMetadata& metadata = map.Metadata();
  if (metadata.unit != "m") {
    throw InputError(
        "the map is in pixels, because it was made without a rig; make it again with a rig");
  }
  if (map.Grid().width_px == 0) {
    throw InputError("the map has no mosaic to find a robot on; make it again");
  }
  calib::CeilingView view = MakeView(up, metadata.ceiling_height_m, 1);
  constexpr double kMaxScale = 4;
  const double scale = view.MetresPerPixel() / metadata.view_units_per_px;
  if (scale > kMaxScale || scale < 1 / kMaxScale) {
    throw InputError(
        fmt::format("a pixel of the camera covers {:.2g} mm of this ceiling, one of the map's "
                    "camera {:.2g} mm: too "
                    "different to be compared; check the rig's focal length and height",
                    1e3 * view.MetresPerPixel(),
                    1e3 * metadata.view_units_per_px));
  }
  return view;
}

/// Scales that differ between heights cannot be one scale of the camera: a map with heights takes
/// the rig's.
mosaic::HeightMap HeightsOf(const store::MapReader& map) {
  return {map.ReadKeyframes(), map.Metadata()};
}

registration::RegistrarParams WithScale(const calib::CeilingView& view,
                                        bool estimate_scale,
                                        bool local_features) {
  registration::RegistrarParams params;
  params.estimate_scale = estimate_scale;
  params.same_recording = false;
  params.local_features = local_features;
  SetForView(view, params);
  return params;
}

/// Derivative of the image motion (tx_px, ty_px, theta_rad) by a small motion (x, y, yaw) of base.
Eigen::Matrix3d ImageJacobian(const calib::CeilingView& view) {
  constexpr double kStep = 1e-4;
  Eigen::Matrix3d jacobian;
  for (int i = 0; i < 3; ++i) {
    const registration::ImageMotion m =
        mapping::ImageMotionOf(view, {i == 0 ? kStep : 0, i == 1 ? kStep : 0, i == 2 ? kStep : 0});
    jacobian.col(i) = Eigen::Vector3d(m.tx_px, m.ty_px, m.theta_rad) / kStep;
  }
  return jacobian;
}

/// From (x, y, yaw) in the axes of base to those of the map.
Eigen::Matrix3d MapAxes(const Pose2& T_map_base) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() = T_map_base.Rotation();
  return axes;
}

}  // namespace

double PositionSigma(const Eigen::Matrix3d& covariance) {
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double root = std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  return std::sqrt(std::max(0.0, mean + root));
}

calib::MountedCamera SuitedTo(const store::MapMetadata& map, const calib::MountedCamera& up) {
  constexpr double kMaxRatio = 1.2;
  const double half_diagonal_m =
      0.5 * map.view_units_per_px * std::hypot(map.view_size.width, map.view_size.height);
  const double distance_m = map.ceiling_height_m - up.T_base_cam.translation().z();
  calib::MountedCamera suited = up;
  if (map.unit == "m" && !suited.view && distance_m > 0) {
    suited.view = calib::ViewChoice{{}, {}, std::atan2(kMaxRatio * half_diagonal_m, distance_m)};
  }
  return suited;
}

MapMatcher::MapMatcher(const store::MapReader& map,
                       const calib::MountedCamera& up,
                       const LocalizerParams& params)
    : map_(map),
      up_(up),
      scale_frames_(params.scale_frames),
      view_(MakeFirstView(map, up)),
      span_(mapping::SpanOf(view_)),
      heights_(HeightsOf(map)),
      registrar_(view_.Size(), WithScale(view_, false, !heights_.empty())),
      scaling_(view_.Size(), WithScale(view_, true, false)),
      looks_(heights_.empty() ? map.ReadLooks() : std::vector<store::Look>()),
      scale_known_(params.scale_frames == 0 || !heights_.empty()) {
  DrawAnew();
}

void MapMatcher::DrawAnew() {
  patches_.reset();
  depth_ = std::make_unique<DepthDrawing>(heights_, map_.Metadata(), view_);
  patches_ = std::make_unique<MapPatches>(map_, view_, registrar_, depth_.get(), looks_);
  patches_->SetOtherLight(light_.IsKnown() && light_.IsOther());
}

void MapMatcher::Analyze(LevelFrame& frame, const registration::Encoding& encoding) {
  tilt_ = frame.tilt;
  if (frame.image.spectrum.empty()) {
    const cv::Mat& pixels = frame.image.pixels;
    frame.image.spectrum = registrar_.Analyze(
        pixels, tilt_.IsLevel() ? cv::Mat() : calib::ContentMask(pixels), encoding);
  }
  least_loss_ = std::min(least_loss_, frame.image.spectrum.CodingLoss());
}

MotionPrior MapMatcher::PriorFor(const Patch& at, const PoseWithCovariance& expected) const {
  MotionPrior prior;
  prior.motion = mapping::ImageMotionOf(view_, at.T_map_base.Inverse() * expected.pose);
  prior.sigma_px =
      std::max(kMinPriorSigmaPx, PositionSigma(expected.covariance) / view_.MetresPerPixel());
  prior.sigma_theta_rad = std::max(kMinPriorSigmaRad, std::sqrt(expected.covariance(2, 2)));
  return prior;
}

Registration MapMatcher::Register(const Patch& at,
                                  const FrameSpectrum& frame,
                                  const std::optional<PoseWithCovariance>& expected) {
  Registrar& registrar = scale_known_ ? registrar_ : scaling_;
  std::optional<MotionPrior> prior;
  if (expected) prior = PriorFor(at, *expected);
  Registration found = registrar.Register(at.spectrum, frame, prior);
  verdict_ = found.verdict;
  return found;
}

std::optional<MapMatch> MapMatcher::MatchAt(const Patch& at,
                                            const FrameSpectrum& frame,
                                            const std::optional<PoseWithCovariance>& expected) {
  const Registration found = Register(at, frame, expected);
  if (!found.ok()) return std::nullopt;
  return MatchOf(at, found);
}

std::optional<MapMatch> MapMatcher::MatchFromBeside(const FrameSpectrum& frame,
                                                    const PoseWithCovariance& expected,
                                                    std::shared_ptr<const Patch>& at) {
  constexpr double kBesideRatio = 0.06;  // of the span
  const Pose2 beside = expected.pose * Pose2{kBesideRatio * span_, 0, 0};
  const std::shared_ptr<const Patch> other = patches_->Exactly(beside);
  if (!other) return std::nullopt;
  std::optional<MapMatch> match = MatchAt(*other, frame, expected);
  if (match) at = other;
  return match;
}

/// @param found  with a valid motion. @return nothing where its scale cannot be that of the camera.
std::optional<MapMatch> MapMatcher::MatchOf(const Patch& at, Registration found) const {
  MapMatch match;
  match.scale = found.motion.scale;
  if (std::abs(std::log(match.scale)) > kMaxScaleError) return std::nullopt;
  // Converts the shift to pixels of the patch, whose size on the ceiling is known.
  found.motion.tx_px /= match.scale;
  found.motion.ty_px /= match.scale;
  found.motion.scale = 1;
  graph::Edge edge = mapping::MeasuredEdge(view_, found, 0, 1, kMatchNoise);
  mapping::InflateTiltCovariance(view_, tilt_, edge);
  match.pose = Moved({at.T_map_base}, edge.T_from_to, edge.information.inverse());
  match.disambiguated_by_prior = found.disambiguated_by_prior;
  match.peak = found.peak;
  match.inliers = found.inliers;
  match.blocks = found.blocks;
  match.distinct =
      match.peak >= (at.spectrum.Heights() != nullptr ? kDistinctDepthPeak : kDistinctPeak);
  return match;
}

/// The patch of a lattice point near the robot shows a ceiling with depth from another place, where
/// other things hide others. The map is drawn again as the robot sees it from the pose found. At
/// other places than the true one such a match fails, or leads away (localization/README.md).
std::shared_ptr<const Patch> MapMatcher::MatchExactly(const FrameSpectrum& frame,
                                                      std::optional<MapMatch>& match) {
  constexpr int kMaxTries = 3;
  for (int i = 0; i < kMaxTries && match; ++i) {
    const MapMatch before = *match;
    std::shared_ptr<const Patch> at = patches_->Exactly(before.pose.pose);
    if (!at) break;
    match = MatchAt(*at, frame, before.pose);
    if (!match) match = MatchFromBeside(frame, before.pose, at);
    constexpr double kSamePx = 4;
    if (match && (match->pose.pose.Translation() - before.pose.pose.Translation()).norm() <
                     kSamePx * view_.MetresPerPixel()) {
      return at;
    }
  }
  match.reset();
  return nullptr;
}

void MapMatcher::LearnLight(const Pose2& T_map_base, const cv::Mat& image) {
  constexpr int kEvery = 32;  // frames, once the light is known
  if (looks_.empty() || (light_.IsKnown() && ++frames_since_light_ < kEvery)) return;
  if (!patches_->DependsOnLight(T_map_base)) return;
  frames_since_light_ = 0;
  cv::Mat in_map_light;
  cv::Mat in_other_light;
  cv::Mat content;
  patches_->SetOtherLight(false);
  patches_->Draw(T_map_base, in_map_light, content);
  patches_->SetOtherLight(true);
  patches_->Draw(T_map_base, in_other_light, content);
  light_.Add(image, in_map_light, in_other_light, content & (image != 0));
  patches_->SetOtherLight(light_.IsKnown() && light_.IsOther());
}

void MapMatcher::ForgetLight() {
  light_.Forget();
  patches_->SetOtherLight(false);
}

std::optional<MapMatch> MapMatcher::MatchNear(const Pose2& T_map_base,
                                              const FrameSpectrum& frame,
                                              const std::optional<PoseWithCovariance>& expected) {
  std::optional<MapMatch> match = MatchNearInLight(T_map_base, frame, expected);
  if (light_.IsKnown() || !patches_->DependsOnLight(T_map_base)) return match;
  const registration::Verdict verdict = verdict_;
  const std::optional<MapMatch> one_way = one_of_several_ways_;
  patches_->SetOtherLight(true);
  std::optional<MapMatch> other = MatchNearInLight(T_map_base, frame, expected);
  patches_->SetOtherLight(false);
  if (other && (!match || other->dissimilarity.mean < match->dissimilarity.mean)) return other;
  verdict_ = verdict;
  one_of_several_ways_ = one_way;
  return match;
}

std::optional<MapMatch> MapMatcher::MatchNearInLight(
    const Pose2& T_map_base,
    const FrameSpectrum& frame,
    const std::optional<PoseWithCovariance>& expected) {
  one_of_several_ways_.reset();
  std::shared_ptr<const Patch> at = patches_->Near(T_map_base);
  if (!at) return std::nullopt;
  const Registration found = Register(*at, frame, expected);
  const bool ambiguous = found.verdict == registration::Verdict::kAmbiguous;
  std::optional<MapMatch> match;
  if (found.ok() || ambiguous) match = MatchOf(*at, found);
  if (match && found.ok() && at->spectrum.Heights() != nullptr) {
    match->distinct = false;
    std::optional<MapMatch> exact = match;
    const std::shared_ptr<const Patch> there = MatchExactly(frame, exact);
    if (exact) {
      at = there;
      match = exact;
    }
  }
  if (!match) return std::nullopt;
  // The frame is the reference, so that places can be compared with each other.
  registration::ImageMotion to_map =
      mapping::ImageMotionOf(view_, match->pose.pose.Inverse() * at->T_map_base);
  to_map.scale = 1 / match->scale;
  match->dissimilarity = registrar_.Compare(frame, at->spectrum, to_map);
  if (ambiguous || match->disambiguated_by_prior) one_of_several_ways_ = match;
  if (ambiguous) return std::nullopt;
  return match;
}

std::optional<MapMatch> MapMatcher::CorrectNear(const PoseWithCovariance& expected,
                                                const FrameSpectrum& frame) {
  // The patch is drawn where the robot is expected: things below the ceiling stand where they do in
  // the frame.
  const std::shared_ptr<const Patch> at = patches_->Exactly(expected.pose);
  if (!at) return std::nullopt;
  const Eigen::Matrix3d to_image = ImageJacobian(view_);
  const Eigen::Matrix3d to_map = MapAxes(expected.pose);
  const Eigen::Matrix3d in_base = to_map.transpose() * expected.covariance * to_map;
  const Registration found =
      registrar_.CorrectJointly(at->spectrum, frame, {}, to_image * in_base * to_image.transpose());
  // Compared with the sharpest image: a patch of the map is less noisy than any.
  if (!found.ok() || (frame.IsBlurredBeside(least_loss_) &&
                      registrar_.IsHiddenByBlur(at->spectrum, frame, found.motion))) {
    return std::nullopt;
  }
  const Eigen::Matrix3d to_base = to_map * to_image.inverse();
  MapMatch match;
  match.pose.pose = expected.pose * mapping::BaseMotion(view_, found.motion);
  match.pose.covariance = to_base * found.covariance.topLeftCorner<3, 3>() * to_base.transpose();
  match.disambiguated_by_prior = true;
  match.peak = found.peak;
  match.inliers = found.inliers;
  match.blocks = found.blocks;
  match.corrected = true;
  // An expectation may be exact without the image, also where the robot is no longer.
  const bool supported = match.inliers >= kMinCorrectedInliers * match.blocks ||
                         found.peak > kMinCorrectedPeaks * found.runner_up;
  match.sure = supported && PositionSigma(WithTilt(match.pose).covariance) <
                                kMaxCorrectedSigmaPx * view_.MetresPerPixel();
  return match;
}

PoseWithCovariance MapMatcher::WithTilt(const PoseWithCovariance& pose) const {
  PoseWithCovariance result = pose;
  result.covariance.topLeftCorner<2, 2>() +=
      mapping::TiltCovariance(view_, pose.pose, tilt_.covariance);
  return result;
}

std::shared_ptr<const heights::HeightField> MapMatcher::HeightsAt(const Pose2& T_map_base) {
  if (!HasDepth()) return nullptr;
  const std::shared_ptr<const Patch> at = patches_->Exactly(T_map_base);
  return at ? at->spectrum.SharedHeights() : nullptr;
}

std::optional<TiltAngles> MapMatcher::MeasureTilt(const Patch& at,
                                                  const FrameSpectrum& frame,
                                                  const MapMatch& match) {
  const registration::PlaneCamera camera = registration::PlaneCameraOf(view_);
  const registration::PlaneMotion start = registration::PlaneMotion::FromSimilarity(
      camera, mapping::ImageMotionOf(view_, at.T_map_base.Inverse() * match.pose.pose));
  // Under a ceiling with depth the blocks have too many errors in common for a check of the tilt.
  if (at.spectrum.Heights() != nullptr) return std::nullopt;
  const registration::PlaneFit fit = registrar_.RefinePlane(at.spectrum, frame, camera, start);
  constexpr int kMinMatches = 12;
  if (!fit.ok || fit.inliers < kMinMatches || 2 * fit.inliers < fit.blocks) return std::nullopt;
  TiltAngles left = registration::TiltOf(fit, view_);
  left.covariance.diagonal().array() += kTiltNoiseRad * kTiltNoiseRad;
  return left;
}

double MapMatcher::Overlap(const Patch& at, const Pose2& T_map_base) const {
  return mapping::OverlapOf(view_, at.T_map_base.Inverse() * T_map_base);
}

bool MapMatcher::LearnScale(const MapMatch& match) {
  if (scale_known_) return false;
  scales_.push_back(match.scale);
  if (static_cast<int>(scales_.size()) < scale_frames_) return false;
  std::sort(scales_.begin(), scales_.end());
  const double median = scales_[scales_.size() / 2];
  // The scales of matches with one ceiling agree closely. A larger spread shows wrong matches:
  // restart.
  constexpr double kSpread = 0.004;  // between the quartiles
  const double spread = scales_[3 * scales_.size() / 4] - scales_[scales_.size() / 4];
  if (spread > kSpread) {
    scales_.clear();
    return false;
  }
  scale_known_ = true;
  scale_ = median;
  view_ = MakeView(up_, map_.Metadata().ceiling_height_m, median);
  DrawAnew();
  return true;
}

}  // namespace ceilmap::localization
