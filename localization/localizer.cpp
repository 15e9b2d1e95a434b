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
#include "localization/wheel_prediction.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/repetition.hpp"

namespace ceilmap::localization {

namespace {

// A measured pose further from the predicted one is rejected, in standard deviations, > 0.
constexpr double kMaxSigmas = 5;

}  // namespace

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

/// A match near an expected pose.
struct ExpectedMatch {
  MapMatch match;
  PoseWithCovariance expected;
  std::shared_ptr<const Patch> patch;
  double sigmas = 0;  // between the two
};

}  // namespace

struct Localizer::Impl {
  Impl(const store::MapReader& map, const calib::MountedCamera& up, const LocalizerParams& p)
      : motion(p.motion),
        params(p),
        matcher(map, up, p),
        search(map, matcher, p),
        shape(map),
        heading(p.heading) {}

  MotionModel motion;         // started: the robot is tracked
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
  GlobalSearch search;
  MapUncertainty shape;
  HeadingFusion heading;
  LocalizerReport report;

  std::shared_ptr<const Patch> patch;  // the robot is tracked on it
  // Of the view of `matcher`, made for the first tilted frame.
  std::optional<calib::LevelView> level_view;
  cv::Mat rectified;
  cv::Mat levelled;
  std::optional<double> last_stamp_s;  // of any frame
  int placed_frames = 0;               // since the robot was found
  bool was_placed = false;

  [[nodiscard]] LevelFrame Levelled(const CeilingFrame& frame);
  void CheckTilt(const Patch& at,
                 const FrameSpectrum& spectrum,
                 const MapMatch& match,
                 Location& location);
  void InflateByTilt(Location& location);
  void Check(const CeilingFrame& frame) const;
  void ChoosePatch(const PoseWithCovariance& expected);
  std::optional<MapMatch> MatchFromBeside(const FrameSpectrum& spectrum,
                                          const PoseWithCovariance& expected);
  void TakeHeading(const HeadingPrior& yaw);
  [[nodiscard]] bool CanBeAt(const PoseWithCovariance& pose, double stamp_s) const;
  [[nodiscard]] double InnovationSigma(const MapMatch& match,
                                       const PoseWithCovariance& expected) const;
  bool Track(double stamp_s,
             const FrameSpectrum& spectrum,
             const std::optional<HeadingPrior>& yaw,
             Location& location);
  std::optional<ExpectedMatch> MatchAt(const PoseWithCovariance& expected_pose,
                                       const FrameSpectrum& spectrum);
  void Accept(const ExpectedMatch& found, const FrameSpectrum& spectrum, Location& location);
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

/// Keeps the patch while enough of it is in view. The next patch lies ahead, so that it can be used
/// longer. Under a ceiling with depth a patch shows soon what is hidden from the robot: it is used
/// for a shorter way, and drawn where the robot will be.
void Localizer::Impl::ChoosePatch(const PoseWithCovariance& expected) {
  constexpr double kMinDepthOverlap = 0.85;
  const bool depth = matcher.HasDepth();
  const double min_overlap =
      depth ? std::max(params.min_overlap, kMinDepthOverlap) : params.min_overlap;
  const Pose2& T_map_base = expected.pose;
  const auto in_view = [&] { return patch && matcher.Overlap(*patch, T_map_base) >= min_overlap; };
  if (in_view()) return;
  const auto draw = [&](const Pose2& at) {
    patch = depth ? matcher.Patches().Exactly(at) : matcher.Patches().Near(at);
  };
  constexpr double kSlow = 0.05;  // m/s: direction of travel not defined
  // Of the span: less than the way for which a patch is used.
  const double ahead_ratio = depth ? 0.05 : 0.17;
  const Eigen::Vector2d velocity = motion.Velocity().head<2>();
  if (velocity.norm() > kSlow) {
    const Eigen::Vector2d ahead = ahead_ratio * matcher.Span() * velocity.normalized();
    draw(T_map_base * Pose2{ahead.x(), ahead.y(), 0});
    if (in_view()) return;
  }
  draw(T_map_base);
}

/// Where the patch is drawn from the robot's own place, no block can be explained by its height,
/// and small distortions of the image (rolling shutter) exclude many. From a place beside it they
/// are not.
std::optional<MapMatch> Localizer::Impl::MatchFromBeside(const FrameSpectrum& spectrum,
                                                         const PoseWithCovariance& expected) {
  constexpr double kBesideRatio = 0.06;  // of the span
  const Pose2 beside = expected.pose * Pose2{kBesideRatio * matcher.Span(), 0, 0};
  const std::shared_ptr<const Patch> other = matcher.Patches().Exactly(beside);
  if (!other) return std::nullopt;
  std::optional<MapMatch> match = matcher.MatchAt(*other, spectrum, expected);
  if (match) patch = other;
  return match;
}

/// A heading that contradicts the motion model is disturbed (steel, a crowd) and is not used.
void Localizer::Impl::TakeHeading(const HeadingPrior& yaw) {
  const PoseWithCovariance expected = motion.Pose();
  const double off = WrapAngle(yaw.heading_rad - expected.pose.yaw);
  const double variance = expected.covariance(2, 2) + yaw.variance_rad2;
  if (off * off > kMaxSigmas * kMaxSigmas * variance) return;
  motion.UpdateYaw(yaw.heading_rad, yaw.variance_rad2);
}

/// Robots do not jump. For an apparent jump, the image may be of another time, or damaged without
/// an error of its decoder, even if the match is good.
/// @return standard deviation that accounts for this, m; 0 where the motion is near constant
///   velocity.
double Localizer::Impl::InnovationSigma(const MapMatch& match,
                                        const PoseWithCovariance& expected) const {
  constexpr double kExactPx = 1.5;
  constexpr double kSigmas = 2.5;
  constexpr double kInflation = 0.5;  // of the position innovation
  const double off = (match.pose.pose.Translation() - expected.pose.Translation()).norm();
  const double sigma =
      std::hypot(PositionSigma(expected.covariance), kExactPx * matcher.View().MetresPerPixel());
  return off > kSigmas * sigma ? kInflation * off : 0;
}

/// Expects the robot where its wheels say, else where it is at constant velocity. Where the ceiling
/// is seen there only, the wheels have slipped.
bool Localizer::Impl::Track(double stamp_s,
                            const FrameSpectrum& spectrum,
                            const std::optional<HeadingPrior>& yaw,
                            Location& location) {
  motion.Predict(stamp_s);
  if (yaw) TakeHeading(*yaw);
  constexpr double kPlausible = 3;  // standard deviations
  const std::optional<PoseWithCovariance> by_wheel = by_wheels.Pose();
  std::optional<ExpectedMatch> found;
  if (by_wheel) found = MatchAt(*by_wheel, spectrum);
  const bool textured = matcher.Verdict() != registration::Verdict::kNoTexture;
  if (!by_wheel || (textured && !(found && found->sigmas < kPlausible))) {
    const std::optional<ExpectedMatch> at_constant_velocity = MatchAt(motion.Pose(), spectrum);
    const bool slipped = by_wheel && at_constant_velocity &&
                         (!found || at_constant_velocity->sigmas < found->sigmas);
    report.slips += slipped ? 1 : 0;
    if (!found || slipped) found = at_constant_velocity;
  }
  if (!found) return false;
  Accept(*found, spectrum, location);
  return true;
}

/// Nothing where the image does not match the map near there.
std::optional<ExpectedMatch> Localizer::Impl::MatchAt(const PoseWithCovariance& expected_pose,
                                                      const FrameSpectrum& spectrum) {
  PoseWithCovariance expected = expected_pose;
  // After a gap in time one match is not enough, because of perceptual aliasing.
  constexpr double kVagueRatio = 0.2;
  if (PositionSigma(expected.covariance) > kVagueRatio * matcher.Span()) return std::nullopt;
  ChoosePatch(expected);
  if (!patch) return std::nullopt;
  std::optional<MapMatch> match = matcher.MatchAt(*patch, spectrum, expected);
  if (!match && matcher.HasDepth()) match = MatchFromBeside(spectrum, expected);
  if (!match) return std::nullopt;
  const double floor = MapMatcher::kMinPriorSigmaPx * matcher.View().MetresPerPixel();
  const double floor_rad = MapMatcher::kMinPriorSigmaRad;
  expected.covariance.diagonal() +=
      Eigen::Vector3d(floor * floor, floor * floor, floor_rad * floor_rad);
  const double sigmas = std::sqrt(SquaredDistance(match->pose, expected));
  if (!(sigmas <= kMaxSigmas)) return std::nullopt;
  return ExpectedMatch{*match, expected_pose, patch, sigmas};
}

void Localizer::Impl::Accept(const ExpectedMatch& found,
                             const FrameSpectrum& spectrum,
                             Location& location) {
  patch = found.patch;
  const double innovation_sigma = InnovationSigma(found.match, found.expected);
  motion.Update(found.match.pose);
  Place(found.match, location);
  location.pose.covariance.topLeftCorner<2, 2>().diagonal().array() +=
      innovation_sigma * innovation_sigma;
  CheckTilt(*patch, spectrum, found.match, location);
  location.pose.status = was_placed ? TrackingStatus::kTracking : TrackingStatus::kRelocalized;
  if (!matcher.LearnScale(found.match)) return;
  patch.reset();
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
  const double off = (pose.pose.Translation() - expected.pose.Translation()).norm();
  return off < kSigmas * std::hypot(PositionSigma(expected.covariance),
                                    MapMatcher::kMinPriorSigmaPx * matcher.View().MetresPerPixel());
}

/// During a short period without texture the earlier prediction remains valid, with wheels as long
/// as they know the way.
bool Localizer::Impl::IsDropout(double stamp_s) const {
  return matcher.Verdict() == registration::Verdict::kNoTexture &&
         (stamp_s - last_frame.stamp_s <= params.max_dropout_s || by_wheels.Pose());
}

/// From now on the search starts from the last known pose.
void Localizer::Impl::StartSearch() {
  motion_before = motion;
  motion.Stop();
  search.BeginAt(last_pose, last_frame, last_velocity);
}

void Localizer::Impl::Search(const LevelFrame& frame,
                             const FrameSpectrum& spectrum,
                             const GlobalSearch::Known& known,
                             Location& location) {
  const GlobalSearch::Result result = search.Next(frame, spectrum, known);
  location.pose.status = result.status;
  location.hypotheses = result.hypotheses;
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
  motion.Start(result.match.pose, frame.stamp_s, velocity);
  patch.reset();
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
  if (motion.KnowsVelocity()) {
    last_velocity = {motion.Velocity().head<2>(), motion.Velocity().z()};
  }
  if (!frame.heading) return;
  heading.Learn(
      *frame.heading, location.pose.T_map_base.yaw, location.pose.covariance(2, 2), frame.stamp_s);
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
  me.matcher.Analyze(level);
  const FrameSpectrum& spectrum = level.image.spectrum;
  me.report.analyze_ms += MillisecondsSince(start);
  GlobalSearch::Known known;
  known.wheels = std::exchange(me.unused_motion, wheels::RelativeMotion{});
  known.expected = me.by_wheels.Pose();
  known.trusted = !me.by_wheels.IsContradicted();
  if (frame.heading) known.yaw = me.heading.InMap(*frame.heading, frame.stamp_s);

  start = Clock::now();
  bool decided = false;
  if (me.motion.Started()) {
    decided = me.Track(frame.stamp_s, spectrum, known.yaw, location);
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
  me.InflateByTilt(location);
  if (location.Placed()) me.Remember(frame, level, location);
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
  me.motion.Stop();
  me.motion_before.reset();
  me.by_wheels.Stop();
  me.search.Reset(start);
  me.heading.Forget();
  me.patch.reset();
  me.was_placed = false;
  me.placed_frames = 0;
  me.unnoticed_tilt.reset();
}

const LocalizerReport& Localizer::Report() const {
  return impl_->report;
}

}  // namespace ceilmap::localization
