#include "app/evaluation/compensation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/evaluation/alignment.hpp"
#include "app/evaluation/association.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::evaluation {
namespace {

// Lower bound of the divisor: the ratio to a zero error stays a finite number, as JSON requires.
constexpr double kMinErrorM = 1e-11;

TiltDegrees TiltOf(const StampedPose& pose) {
  return {PitchOf(pose) * kDegPerRad, RollOf(pose) * kDegPerRad};
}

bool IsLevel(const StampedPose& truth, double below_deg) {
  const TiltDegrees tilt = TiltOf(truth);
  return std::max(std::abs(tilt.pitch_deg), std::abs(tilt.roll_deg)) < below_deg;
}

PlacedError Place(const StampedPose& truth,
                  const StampedPose& estimate,
                  const Pose2& T_truth_estimate) {
  const Eigen::Vector2d p_estimate = estimate.position.head<2>();
  const Eigen::Vector2d p_truth = T_truth_estimate * p_estimate;
  const Eigen::Vector2d error = p_truth - truth.position.head<2>();
  const double yaw = YawOf(truth);
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw));
  return {p_truth, ahead.dot(error), ahead.x() * error.y() - ahead.y() * error.x()};
}

PathErrors Collect(const std::vector<CompensatedFrame>& frames,
                   std::optional<PlacedError> CompensatedFrame::*which) {
  PathErrors errors;
  errors.expected = static_cast<std::int64_t>(frames.size());
  double squares = 0;
  for (const CompensatedFrame& frame : frames) {
    const std::optional<PlacedError>& error = frame.*which;
    if (!error) continue;
    const double distance_m = std::hypot(error->along_m, error->across_m);
    ++errors.matched;
    errors.max_along_m = std::max(errors.max_along_m, std::abs(error->along_m));
    errors.max_across_m = std::max(errors.max_across_m, std::abs(error->across_m));
    errors.max_m = std::max(errors.max_m, distance_m);
    squares += distance_m * distance_m;
  }
  if (errors.matched > 0) errors.rmse_m = std::sqrt(squares / static_cast<double>(errors.matched));
  return errors;
}

CompensationRatio Ratio(const PathErrors& before, const PathErrors& after) {
  const auto ratio = [](double a, double b) { return a / std::max(b, kMinErrorM); };
  return {ratio(after.max_along_m, before.max_along_m),
          ratio(after.max_across_m, before.max_across_m),
          ratio(after.max_m, before.max_m),
          ratio(after.rmse_m, before.rmse_m)};
}

void AddTiltErrors(Compensation& compensation) {
  std::vector<double> pitch_deg;
  std::vector<double> roll_deg;
  for (const CompensatedFrame& frame : compensation.frames) {
    if (!frame.tilt) continue;
    pitch_deg.push_back(frame.tilt->pitch_deg - frame.true_tilt.pitch_deg);
    roll_deg.push_back(frame.tilt->roll_deg - frame.true_tilt.roll_deg);
  }
  compensation.pitch_deg = Statistics(std::move(pitch_deg));
  compensation.roll_deg = Statistics(std::move(roll_deg));
}

}  // namespace

LevelAlignment AlignLevelFrames(const std::vector<StampedPose>& truth,
                                const std::vector<StampedPose>& before,
                                const CompensationParams& params) {
  LevelAlignment alignment;
  std::vector<PointPair> level;
  for (const auto& [k, c] : MatchStamps(truth, before, params.max_dt_s)) {
    ++alignment.matched;
    if (!IsLevel(truth[k], params.level_below_deg)) continue;
    level.push_back({truth[k].position.head<2>(), before[c].position.head<2>()});
  }
  alignment.level = static_cast<std::int64_t>(level.size());
  if (level.size() >= 2) alignment.T_truth_before = FitPlanarMotion(level);
  return alignment;
}

std::optional<Compensation> CompareCompensation(const std::vector<StampedPose>& truth,
                                                const std::vector<StampedPose>& before,
                                                const std::vector<StampedPose>& after,
                                                const Pose2& T_truth_before,
                                                const CompensationParams& params,
                                                const std::optional<Pose2>& T_truth_after) {
  Compensation compensation;
  for (const StampedPose& pose : truth) {
    compensation.frames.push_back(
        {pose.stamp_s, pose.position.head<2>(), TiltOf(pose), {}, {}, {}});
  }
  for (const auto& [k, c] : MatchStamps(truth, before, params.max_dt_s)) {
    compensation.frames[k].before = Place(truth[k], before[c], T_truth_before);
  }
  for (const auto& [k, c] : MatchStamps(truth, after, params.max_dt_s)) {
    compensation.frames[k].after =
        Place(truth[k], after[c], T_truth_after.value_or(T_truth_before));
    compensation.frames[k].tilt = TiltOf(after[c]);
  }
  compensation.before = Collect(compensation.frames, &CompensatedFrame::before);
  compensation.after = Collect(compensation.frames, &CompensatedFrame::after);
  if (compensation.before.matched == 0 || compensation.after.matched == 0) return std::nullopt;
  compensation.ratio = Ratio(compensation.before, compensation.after);
  AddTiltErrors(compensation);
  return compensation;
}

TiltDegrees LargestTilt(const std::vector<StampedPose>& poses) {
  TiltDegrees largest;
  for (const StampedPose& pose : poses) {
    const TiltDegrees tilt = TiltOf(pose);
    largest.pitch_deg = std::max(largest.pitch_deg, std::abs(tilt.pitch_deg));
    largest.roll_deg = std::max(largest.roll_deg, std::abs(tilt.roll_deg));
  }
  return largest;
}

}  // namespace ceilmap::evaluation
