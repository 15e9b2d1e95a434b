#include "localization/localizer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/level_view.hpp"
#include "localization/global_search.hpp"
#include "localization/map_matcher.hpp"
#include "localization/map_uncertainty.hpp"
#include "localization/tracker.hpp"
#include "localization/wheel_prediction.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/repetition.hpp"

namespace ceilmap::localization {

using graph::TrackingStatus;
using registration::FrameSpectrum;

void LocalizerParams::Validate() const {
  const FieldCheck require("localizer");
  heading.Validate();
  motion.Validate();
  hypotheses.Validate();
  require(min_overlap > 0 && min_overlap < 1, "min_overlap", min_overlap, "in (0, 1)");
  require(max_frames_at_start_prior >= 1,
          "max_frames_at_start_prior",
          max_frames_at_start_prior,
          "at least 1");
  require(give_up_heading_after >= 1, "give_up_heading_after", give_up_heading_after, "at least 1");
  require(max_dropout_s >= 0, "max_dropout_s", max_dropout_s, ">= 0");
  require(
      speed_noise_when_lost_m_s > 0, "speed_noise_when_lost_m_s", speed_noise_when_lost_m_s, "> 0");
  require(scale_frames >= 0, "scale_frames", scale_frames, "at least 0");
  if (start) {
    const Pose2& T = start->pose;
    require(
        std::isfinite(T.x + T.y + T.yaw) && start->covariance.allFinite(), "start", T.x, "finite");
  }
  require(tilt_checks >= 0, "tilt_checks", tilt_checks, "at least 0");
  require(tilt_check_every >= 0, "tilt_check_every", tilt_check_every, "at least 0");
}

namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

struct Localizer::Impl {
  Impl(const store::MapReader& map, const calib::MountedCamera& up, const LocalizerParams& p)
      : params(p),
        matcher(map, up, p),
        tracker(matcher, p),
        search(map, matcher, p),
        shape(map),
        heading(p.heading) {}

  WheelPrediction by_wheels;  // since the last pose
  // By the wheels, since the last frame that did not repeat the one before.
  std::optional<wheels::RelativeMotion> unused_motion;
  std::optional<TiltAngles> unnoticed_tilt;  // of the latest check, if significant
  LevelFrame last_frame;                     // the last one with a pose ...
  PoseWithCovariance last_pose;              // ... its pose ...
  std::optional<Twist2> last_velocity;       // ... and its velocity, if it is known
  std::optional<MotionModel> motion_before;  // at the time when the robot was lost
  LocalizerParams params;
  MapMatcher matcher;
  Tracker tracker;
  GlobalSearch search;
  MapUncertainty shape;
  HeadingFusion heading;
  LocalizerReport report;

  // Of the view of `matcher`, made for the first tilted frame.
  std::optional<calib::LevelView> level_view;
  cv::Mat rectified;
  cv::Mat levelled;
  std::optional<double> last_stamp_s;  // of any frame
  int placed_frames = 0;               // since the robot was found
  int unplaced_frames = 0;             // in a row
  bool was_placed = false;

  [[nodiscard]] LevelFrame Levelled(const CeilingFrame& frame);
  void CheckTilt(const Patch& at,
                 const FrameSpectrum& spectrum,
                 const MapMatch& match,
                 Location& location);
  void InflateByTilt(Location& location);
  void Check(const CeilingFrame& frame) const;
  [[nodiscard]] bool CanBeAt(const PoseWithCovariance& pose, double stamp_s) const;
  void Accept(const Tracker::Found& found, const FrameSpectrum& spectrum, Location& location);
  [[nodiscard]] bool IsDropout(double stamp_s) const;
  void StartSearch();
  void Search(const LevelFrame& frame,
              const FrameSpectrum& spectrum,
              const GlobalSearch::Known& known,
              Location& location);
  void PredictUnlessCarried(bool elsewhere,
                            const std::optional<PoseWithCovariance>& followed,
                            Location& location);
  void Predict(const std::optional<PoseWithCovariance>& followed, Location& location);
  void Place(const MapMatch& match, Location& location);
  void Remember(const CeilingFrame& frame, const LevelFrame& level, const Location& location);
  [[nodiscard]] SeenCeiling SeenAt(const Pose2& T_map_base, const cv::Mat& level_image) const;
  void Count(TrackingStatus status);
};

LevelFrame Localizer::Impl::Levelled(const CeilingFrame& frame) {
  LevelFrame level{frame.rectified, frame.index, frame.stamp_s, frame.tilt, frame.heading};
  if (level.image.pixels.empty())
    level.image = {matcher.View().Rectify(frame.grey, rectified, frame.velocity), {}};
  if (frame.tilt.IsLevel()) return level;
  if (!level_view) level_view.emplace(matcher.View());
  level_view->Draw(level.image.pixels, frame.tilt, levelled);
  level.image = {levelled, {}};
  return level;
}

void Localizer::Impl::CheckTilt(const Patch& at,
                                const FrameSpectrum& spectrum,
                                const MapMatch& match,
                                Location& location) {
  const int frames = placed_frames + 1;
  const bool due = params.tilt_check_every > 0 && frames % params.tilt_check_every == 0;
  if (frames > params.tilt_checks && !due && !unnoticed_tilt) return;
  location.tilt_left = matcher.MeasureTilt(at, spectrum, match);
  if (!location.tilt_left) return;
  constexpr double kSigmas = 3;
  unnoticed_tilt.reset();
  if (location.tilt_left->Sigmas() > kSigmas) unnoticed_tilt = location.tilt_left;
}

/// An unnoticed tilt causes a position error of the distance to the ceiling times the tilt. A frame
/// that does not measure the tilt uses that of the frame before.
void Localizer::Impl::InflateByTilt(Location& location) {
  if (!location.Placed()) unnoticed_tilt.reset();
  if (!unnoticed_tilt) return;
  const Eigen::Vector2d& angles = unnoticed_tilt->angles;
  location.pose.covariance.topLeftCorner<2, 2>() +=
      mapping::TiltCovariance(matcher.View(),
                              location.pose.T_map_base,
                              angles * angles.transpose() + unnoticed_tilt->covariance);
}

void Localizer::Impl::Check(const CeilingFrame& frame) const {
  if (!std::isfinite(frame.stamp_s)) {
    throw InputError(fmt::format("frame {}: its time is not finite", frame.index));
  }
  if (last_stamp_s && !(frame.stamp_s > *last_stamp_s)) {
    throw InputError(fmt::format("frame {}: time {} s is not later than that of the frame before",
                                 frame.index,
                                 frame.stamp_s));
  }
  if (!frame.heading) return;
  if (!(frame.heading->variance_rad2 > 0) || !std::isfinite(frame.heading->variance_rad2) ||
      !std::isfinite(frame.heading->heading_rad)) {
    throw InputError(
        fmt::format("frame {}: a heading must be finite, its variance > 0", frame.index));
  }
}

void Localizer::Impl::Accept(const Tracker::Found& found,
                             const FrameSpectrum& spectrum,
                             Location& location) {
  report.slips += found.slipped ? 1 : 0;
  Place(found.match, location);
  location.pose.covariance.topLeftCorner<2, 2>().diagonal().array() +=
      found.innovation_sigma_m * found.innovation_sigma_m;
  CheckTilt(*found.patch, spectrum, found.match, location);
  location.pose.status = was_placed ? TrackingStatus::kTracking : TrackingStatus::kRelocalized;
  if (!matcher.LearnScale(found.match)) return;
  tracker.ForgetPatch();
  level_view.reset();
  search.ChangeView();
  report.scale = matcher.Scale();
}

/// Nobody carries a robot away within a second: a pose found within that time must be reachable
/// from the last one.
bool Localizer::Impl::CanBeAt(const PoseWithCovariance& pose, double stamp_s) const {
  constexpr double kMomentSeconds = 1;
  constexpr double kSigmas = 3;
  if (!motion_before || stamp_s - last_frame.stamp_s > kMomentSeconds) return true;
  const PoseWithCovariance expected = motion_before->PredictedAt(stamp_s);
  const double floor = MapMatcher::kMinPriorSigmaPx * matcher.View().MetresPerPixel();
  // A robot drives less exactly ahead than sideways.
  Eigen::Matrix2d spread = expected.covariance.topLeftCorner<2, 2>();
  spread.diagonal().array() += floor * floor;
  const Eigen::Vector2d off = pose.pose.Translation() - expected.pose.Translation();
  return off.dot(spread.inverse() * off) < kSigmas * kSigmas;
}

/// During a short period without texture the earlier prediction remains valid, with wheels as long
/// as they know the way.
bool Localizer::Impl::IsDropout(double stamp_s) const {
  return matcher.Verdict() == registration::Verdict::kNoTexture &&
         (stamp_s - last_frame.stamp_s <= params.max_dropout_s || by_wheels.Pose());
}

/// From now on the search starts from the last known pose.
void Localizer::Impl::StartSearch() {
  motion_before = tracker.Motion();
  tracker.Stop();
  search.BeginAt(last_pose, last_frame, last_velocity);
}

void Localizer::Impl::Search(const LevelFrame& frame,
                             const FrameSpectrum& spectrum,
                             const GlobalSearch::Known& known,
                             Location& location) {
  const GlobalSearch::Result result = search.Next(frame, spectrum, known);
  location.pose.status = result.status;
  location.hypotheses = result.hypotheses;
  location.places = result.places;
  location.velocity = result.velocity;
  report.searches = search.Searches();
  if (result.status != TrackingStatus::kRelocalized) {
    PredictUnlessCarried(result.elsewhere, result.followed_pose, location);
    return;
  }
  // The image did not contribute to a pose that is followed.
  if (result.followed && result.match.inliers == 0 && by_wheels.Pose()) {
    PredictUnlessCarried(result.elsewhere, result.match.pose, location);
    return;
  }
  if (!CanBeAt(result.match.pose, frame.stamp_s)) {
    location.pose.status = TrackingStatus::kAmbiguous;
    Predict(std::nullopt, location);
    return;
  }
  if (was_placed) location.pose.status = TrackingStatus::kTracking;
  Place(result.match, location);
  if (result.followed) return;
  std::optional<Twist2> velocity;
  constexpr double kRecentS = 0.5;
  if (result.velocity && frame.stamp_s - result.velocity->stamp_s < kRecentS) {
    velocity = result.velocity->velocity;
  }
  tracker.Start(result.match.pose, frame.stamp_s, velocity);
}

/// A robot that sees clear structure, but not that of the place where its wheels say it is, was
/// carried away: it may be anywhere.
void Localizer::Impl::PredictUnlessCarried(bool elsewhere,
                                           const std::optional<PoseWithCovariance>& followed,
                                           Location& location) {
  if (!by_wheels.Pose()) return;
  by_wheels.Contradict(elsewhere);
  if (by_wheels.Pose()) {
    Predict(followed, location);
  } else {
    location.pose.status = TrackingStatus::kLost;
    search.Reset();
  }
}

/// Without a pose by the image: where the robot is by its wheels, if it has wheels.
void Localizer::Impl::Predict(const std::optional<PoseWithCovariance>& followed,
                              Location& location) {
  const std::optional<PoseWithCovariance> by_wheel = by_wheels.Pose();
  if (!by_wheel) return;
  const PoseWithCovariance& pose = followed ? *followed : *by_wheel;
  location.pose.status = TrackingStatus::kPredicted;
  location.pose.T_map_base = pose.pose;
  location.pose.covariance = pose.covariance + shape.At(pose.pose);
}

void Localizer::Impl::Place(const MapMatch& match, Location& location) {
  location.pose.T_map_base = match.pose.pose;
  location.pose.covariance = match.pose.covariance + shape.At(match.pose.pose);
  location.peak = match.peak;
  location.inliers = match.inliers;
  location.blocks = match.blocks;
  last_pose = match.pose;
}

void Localizer::Impl::Remember(const CeilingFrame& frame,
                               const LevelFrame& level,
                               const Location& location) {
  level.image.pixels.copyTo(last_frame.image.pixels);
  last_frame.image.spectrum = level.image.spectrum;
  last_frame.index = level.index;
  last_frame.stamp_s = level.stamp_s;
  last_frame.tilt = level.tilt;
  last_frame.heading = level.heading;
  by_wheels.Start(last_pose);
  last_velocity = std::nullopt;
  const MotionModel& motion = tracker.Motion();
  if (motion.KnowsVelocity()) {
    last_velocity = {motion.Velocity().head<2>(), motion.Velocity().z()};
  }
  if (!frame.heading) return;
  heading.Learn(
      *frame.heading, location.pose.T_map_base.yaw, location.pose.covariance(2, 2), frame.stamp_s);
}

SeenCeiling Localizer::Impl::SeenAt(const Pose2& T_map_base, const cv::Mat& level_image) const {
  const calib::CeilingView& view = matcher.View();
  return {level_image,
          view.Mask(),
          T_map_base * view.T_base_view(),
          view.MetresPerPixel(),
          registration::PlaneCameraOf(view).principal_px};
}

void Localizer::Impl::Count(TrackingStatus status) {
  ++report.frames;
  switch (status) {
    case TrackingStatus::kTracking:
      ++report.tracking;
      break;
    case TrackingStatus::kRelocalized:
      ++report.relocalized;
      break;
    case TrackingStatus::kPredicted:
      ++report.predicted;
      break;
    case TrackingStatus::kAmbiguous:
      ++report.ambiguous;
      break;
    case TrackingStatus::kLost:
      ++report.lost;
      break;
  }
}

Localizer::Localizer(const store::MapReader& map,
                     const calib::MountedCamera& up,
                     const LocalizerParams& params) {
  params.Validate();
  impl_ = std::make_unique<Impl>(map, up, params);
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Location Localizer::Locate(const CeilingFrame& frame) {
  Impl& me = *impl_;
  me.Check(frame);
  Location location;
  location.pose.frame_index = frame.index;
  location.pose.stamp_s = frame.stamp_s;
  location.pose.tilt = frame.tilt;
  me.by_wheels.Move(frame.wheels);
  me.unused_motion = wheels::Joined(me.unused_motion, frame.wheels);
  if (frame.repeated > mapping::kMaxRepeated) {
    location.pose.status = TrackingStatus::kAmbiguous;
    me.Predict(std::nullopt, location);
    me.last_stamp_s = frame.stamp_s;
    ++me.report.repeated;
    me.Count(location.pose.status);
    return location;
  }
  auto start = Clock::now();
  LevelFrame level = me.Levelled(frame);
  me.report.rectify_ms += MillisecondsSince(start);
  start = Clock::now();
  const FrameSpectrum& analyzed = frame.rectified.spectrum;
  me.matcher.Analyze(level, analyzed.empty() ? frame.encoding : analyzed.GetEncoding());
  const FrameSpectrum& spectrum = level.image.spectrum;
  me.report.analyze_ms += MillisecondsSince(start);
  GlobalSearch::Known known;
  known.wheels = std::exchange(me.unused_motion, wheels::RelativeMotion{});
  known.expected = me.by_wheels.Pose();
  known.trusted = !me.by_wheels.IsContradicted();
  known.usual_inliers = me.tracker.UsualInliers();
  if (frame.heading) known.yaw = me.heading.InMap(*frame.heading, frame.stamp_s);

  start = Clock::now();
  bool decided = false;
  if (me.tracker.Motion().Started()) {
    const std::optional<Tracker::Found> found =
        me.tracker.Track(frame.stamp_s, spectrum, known.yaw, me.by_wheels.Pose());
    if (found) me.Accept(*found, spectrum, location);
    decided = found.has_value();
    if (!decided && me.IsDropout(frame.stamp_s)) {
      location.pose.status = TrackingStatus::kLost;
      me.Predict(std::nullopt, location);
      decided = true;
    }
    me.report.track_ms += MillisecondsSince(start);
    if (!decided) {
      me.StartSearch();
      known.wheels = me.by_wheels.Motion();  // since the frame with which the search starts
    }
  }
  if (!decided) {
    start = Clock::now();
    me.Search(level, spectrum, known, location);
    me.report.search_ms += MillisecondsSince(start);
  }
  me.was_placed = location.Placed();
  me.placed_frames = location.Placed() ? me.placed_frames + 1 : 0;
  constexpr int kForgetLightAfter = 30;
  me.unplaced_frames = location.Placed() ? 0 : me.unplaced_frames + 1;
  if (me.unplaced_frames == kForgetLightAfter) me.matcher.ForgetLight();
  me.InflateByTilt(location);
  if (location.Placed()) me.Remember(frame, level, location);
  if (location.Placed() && location.inliers > 0 && me.matcher.KnowsScale()) {
    location.seen = me.SeenAt(location.pose.T_map_base, level.image.pixels);
    me.matcher.LearnLight(location.pose.T_map_base, level.image.pixels);
  }
  me.last_stamp_s = frame.stamp_s;
  me.Count(location.pose.status);
  me.report.coding_loss += (spectrum.CodingLoss() - me.report.coding_loss) /
                           static_cast<double>(me.report.frames - me.report.repeated);
  return location;
}

void Localizer::Reset(const std::optional<PoseWithCovariance>& start) {
  Impl& me = *impl_;
  me.params.start = start;
  me.params.Validate();
  me.tracker.Stop();
  me.motion_before.reset();
  me.by_wheels.Stop();
  me.search.Reset(start);
  me.heading.Forget();
  me.tracker.ForgetPatch();
  me.was_placed = false;
  me.placed_frames = 0;
  me.matcher.ForgetLight();
  me.unnoticed_tilt.reset();
}

const LocalizerReport& Localizer::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::localization
