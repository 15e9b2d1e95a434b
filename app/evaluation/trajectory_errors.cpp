#include "app/evaluation/trajectory_errors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/evaluation/association.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::evaluation {
namespace {
constexpr double kRelativeLengthM = 1;

FrameError ErrorOf(const PosePair& pair) {
  FrameError error;
  error.stamp_s = pair.truth.stamp_s;
  error.T_truth_base = PlanarPose(pair.estimate);
  error.shift_m = (pair.estimate.position - pair.truth.position).head<2>();
  error.position_m = error.shift_m.norm();
  const double yaw = YawOf(pair.truth);
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw));
  error.along_m = ahead.dot(error.shift_m);
  error.across_m = ahead.x() * error.shift_m.y() - ahead.y() * error.shift_m.x();
  error.yaw_deg = kDegPerRad * WrapAngle(error.T_truth_base.yaw - yaw);
  error.pitch_deg = kDegPerRad * (PitchOf(pair.estimate) - PitchOf(pair.truth));
  error.roll_deg = kDegPerRad * WrapAngle(RollOf(pair.estimate) - RollOf(pair.truth));
  error.pose = AbsoluteError(pair);
  return error;
}

bool IsTilted(const StampedPose& pose) {
  constexpr double kMin = 1e-9;  // files are rounded to 1e-9 m and 1e-12
  return std::abs(pose.position.z()) > kMin || std::abs(pose.orientation.x()) > kMin ||
         std::abs(pose.orientation.y()) > kMin;
}

template <typename Value>
ErrorStatistics Over(const std::vector<FrameError>& frames, Value value) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameError& frame : frames) values.push_back(value(frame));
  return Statistics(std::move(values));
}

void AddAbsoluteErrors(const std::vector<PosePair>& pairs, TrajectoryErrors& errors) {
  errors.position_m = Over(errors.frames, [](const FrameError& f) { return f.position_m; });
  errors.yaw_deg = Over(errors.frames, [](const FrameError& f) { return f.yaw_deg; });
  errors.tilted = std::any_of(pairs.begin(), pairs.end(), [](const PosePair& pair) {
    return IsTilted(pair.truth) || IsTilted(pair.estimate);
  });
  std::vector<PoseError> in_space;
  in_space.reserve(errors.frames.size());
  for (const FrameError& frame : errors.frames) in_space.push_back(frame.pose);
  errors.pose = Statistics(in_space);
}

// Errors in the plane, over each metre of the true path.
void AddPerMetre(const std::vector<PosePair>& pairs,
                 const std::vector<double>& distance_m,
                 TrajectoryErrors& errors) {
  std::vector<double> position_m;
  std::vector<double> yaw_deg;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto end =
        std::lower_bound(distance_m.begin(), distance_m.end(), distance_m[i] + kRelativeLengthM);
    if (end == distance_m.end()) break;
    const PosePair& to = pairs[static_cast<std::size_t>(end - distance_m.begin())];
    const Pose2 true_motion = PlanarPose(pairs[i].truth).Inverse() * PlanarPose(to.truth);
    const Pose2 motion = PlanarPose(pairs[i].estimate).Inverse() * PlanarPose(to.estimate);
    position_m.push_back((motion.Translation() - true_motion.Translation()).norm());
    yaw_deg.push_back(WrapAngle(motion.yaw - true_motion.yaw) * kDegPerRad);
  }
  if (position_m.empty()) return;
  errors.per_metre_m = Statistics(std::move(position_m));
  errors.per_metre_yaw_deg = Statistics(std::move(yaw_deg));
}

void AddRelativeErrors(const std::vector<PosePair>& pairs,
                       const SegmentParams& params,
                       TrajectoryErrors& errors) {
  std::vector<double> distance_m;
  distance_m.reserve(pairs.size());
  for (const FrameError& frame : errors.frames) distance_m.push_back(frame.distance_m);
  AddPerMetre(pairs, distance_m, errors);
  errors.per_frame = RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kFrames});
  errors.per_metre = RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kMetres});
  errors.per_metre_all_pairs =
      RelativeErrors(pairs, {.delta = 1, .unit = DeltaUnit::kMetres, .all_pairs = true});
  errors.segments = MeasureSegments(pairs, distance_m, params);
}

}  // namespace

std::optional<TrajectoryErrors> EvaluateTrajectory(const std::vector<StampedPose>& truth,
                                                   const std::vector<StampedPose>& estimate,
                                                   const EvaluationParams& params) {
  const auto matches = MatchStamps(truth, estimate, params.max_dt_s);
  if (matches.empty()) return std::nullopt;
  std::vector<PosePair> pairs;
  pairs.reserve(matches.size());
  for (const auto& [k, c] : matches) pairs.push_back({truth[k], estimate[c]});

  TrajectoryErrors errors;
  errors.T_truth_estimate =
      params.T_truth_estimate ? *params.T_truth_estimate : Align(pairs, params.align);
  for (PosePair& pair : pairs) pair.estimate = errors.T_truth_estimate * pair.estimate;
  const std::vector<double> distance_m = PathLengths(truth);
  errors.frames.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    FrameError& error = errors.frames.emplace_back(ErrorOf(pairs[i]));
    error.truth = matches[i].first;
    error.estimate = matches[i].second;
    error.distance_m = distance_m[error.truth];
  }
  errors.matched = static_cast<std::int64_t>(pairs.size());
  errors.expected = params.expected.value_or(static_cast<std::int64_t>(truth.size()));
  errors.path_m = distance_m.back();
  AddAbsoluteErrors(pairs, errors);
  AddRelativeErrors(pairs, params.segments, errors);
  return errors;
}

}  // namespace ceilmap::evaluation
