#include "app/evaluation/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "app/evaluation/alignment.hpp"
#include "app/evaluation/masked_correlation.hpp"
#include "app/evaluation/planar_track.hpp"

namespace ceilmap::evaluation {
namespace {

constexpr double kLeverM = 0.5;  // weight of a radian of yaw relative to a metre, > 0
// Time over which speeds are measured, at least two poses apart; >= 0.
constexpr double kWindowS = 0.2;
// Minimum fraction of the shorter trajectory that overlaps the other one, in (0, 1].
constexpr double kMinOverlap = 0.3;

constexpr std::int64_t kMaxSamples = 1 << 16;  // per trajectory
constexpr double kMinOverlapSamples = 10;
constexpr std::size_t kMaxRefinedPoses = 2000;
constexpr std::size_t kMaxCandidates = 10;

struct MotionProfile {
  MaskedSignal speed;
  MaskedSignal yaw_rate;
};

// Central differences, with half_window samples to either side.
MotionProfile Resample(const PlanarTrack& track, double step_s, std::int64_t half_window) {
  const auto samples = static_cast<std::int64_t>((track.End() - track.Start()) / step_s) + 1;
  std::vector<std::optional<PlanarTrack::Point>> points;
  for (std::int64_t i = 0; i < samples; ++i) {
    points.push_back(track.At(track.Start() + static_cast<double>(i) * step_s));
  }
  MotionProfile profile;
  for (std::int64_t i = 0; i < samples; ++i) {
    double speed = 0;
    double yaw_rate = 0;
    bool known = i >= half_window && i + half_window < samples;
    if (known) {
      const auto& before = points[static_cast<std::size_t>(i - half_window)];
      const auto& after = points[static_cast<std::size_t>(i + half_window)];
      known = before && after;
      const double between_s = 2 * static_cast<double>(half_window) * step_s;
      if (known) speed = (after->position - before->position).norm() / between_s;
      if (known) yaw_rate = (after->yaw - before->yaw) / between_s;
    }
    for (auto [signal, value] : {std::pair{&profile.speed, speed}, {&profile.yaw_rate, yaw_rate}}) {
      signal->values.push_back(value);
      signal->known.push_back(known ? 1 : 0);
    }
  }
  return profile;
}

struct Score {
  std::int64_t shift = 0;
  double correlation = 0;
};

// Combined score of speed and yaw rate, each weighted by its variance in the truth: a constant
// signal gives no information.
std::vector<Score> ScoreShifts(const MotionProfile& truth, const MotionProfile& estimate) {
  const auto known = [](const MotionProfile& profile) {
    const std::vector<double>& samples = profile.speed.known;
    return static_cast<double>(std::count(samples.begin(), samples.end(), 1.0));
  };
  const double shorter = std::min(known(truth), known(estimate));
  const double min_overlap = std::max(kMinOverlapSamples, kMinOverlap * shorter);
  const auto speeds = CorrelateShifts(truth.speed, estimate.speed);
  const auto yaw_rates = CorrelateShifts(truth.yaw_rate, estimate.yaw_rate);
  std::vector<Score> scores;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    if (speeds[i].overlap < min_overlap) continue;
    const double of_speed = speeds[i].variance;
    const double of_yaw_rate = kLeverM * kLeverM * yaw_rates[i].variance;
    if (!(of_speed + of_yaw_rate > 0)) continue;
    scores.push_back({speeds[i].shift,
                      (of_speed * speeds[i].correlation + of_yaw_rate * yaw_rates[i].correlation) /
                          (of_speed + of_yaw_rate)});
  }
  return scores;
}

// Local maxima, the highest first.
std::vector<Score> Candidates(const std::vector<Score>& scores) {
  constexpr double kMinOfBest = 0.3;
  std::vector<Score> peaks;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double here = scores[i].correlation;
    const bool rises = i == 0 || here > scores[i - 1].correlation;
    const bool falls = i + 1 == scores.size() || here >= scores[i + 1].correlation;
    if (here > 0 && rises && falls) peaks.push_back(scores[i]);
  }
  std::sort(peaks.begin(), peaks.end(), [](const Score& a, const Score& b) {
    return a.correlation > b.correlation;
  });
  while (peaks.size() > kMaxCandidates ||
         (!peaks.empty() && peaks.back().correlation < kMinOfBest * peaks.front().correlation)) {
    peaks.pop_back();
  }
  return peaks;
}

// Part of the true path that an estimate does not explain at an offset; yaws are weighted by the
// lever.
struct Residual {
  double mean_square = std::numeric_limits<double>::infinity();  // m^2
  double variance = 0;                                           // of the true path, m^2
  std::int64_t poses = 0;

  [[nodiscard]] double Unexplained() const {
    return variance > 0 ? std::min(1.0, mean_square / variance) : 1;
  }
};

Residual ResidualAt(const PlanarTrack& truth,
                    const std::vector<StampedPose>& estimate,
                    double offset_s,
                    double lever_m) {
  std::vector<PointPair> points;
  std::vector<double> turns;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double squares = 0;
  for (const StampedPose& pose : estimate) {
    const auto point = truth.At(pose.stamp_s + offset_s);
    if (!point) continue;
    points.push_back({point->position, pose.position.head<2>()});
    turns.push_back(point->yaw - YawOf(pose));
    const Eigen::Vector3d place(point->position.x(), point->position.y(), lever_m * point->yaw);
    sum += place;
    squares += place.squaredNorm();
  }
  Residual residual;
  residual.poses = static_cast<std::int64_t>(points.size());
  if (points.empty()) return residual;
  const auto count = static_cast<double>(points.size());
  residual.variance = squares / count - (sum / count).squaredNorm();
  const Similarity2 fit = FitPlanarSimilarity(points);
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
  for (const double turn : turns) direction += Eigen::Vector2d(std::cos(turn), std::sin(turn));
  const double mean_turn = std::atan2(direction.y(), direction.x());
  residual.mean_square = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double yaw_m = lever_m * WrapAngle(turns[i] - mean_turn);
    const double square = (fit * points[i].p_b - points[i].p_a).squaredNorm();
    residual.mean_square += (square + yaw_m * yaw_m) / count;
  }
  return residual;
}

// The offset between `low` and `high` with the least residual, by golden-section search around the
// best of several samples.
double Refine(const PlanarTrack& truth,
              const std::vector<StampedPose>& estimate,
              double low_s,
              double high_s,
              double lever_m) {
  const auto cost = [&](double offset_s) {
    return ResidualAt(truth, estimate, offset_s, lever_m).mean_square;
  };
  constexpr int kTrials = 16;
  const double step_s = (high_s - low_s) / kTrials;
  double best_s = low_s;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kTrials; ++i) {
    const double value = cost(low_s + i * step_s);
    if (value < least) {
      least = value;
      best_s = low_s + i * step_s;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSections = 30;  // 1e-6 of the first interval
  double a = best_s - step_s;
  double b = best_s + step_s;
  double c = b - kGolden * (b - a);
  double d = a + kGolden * (b - a);
  double at_c = cost(c);
  double at_d = cost(d);
  for (int i = 0; i < kSections; ++i) {
    if (at_c < at_d) {
      b = std::exchange(d, c);
      at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = cost(c);
    } else {
      a = std::exchange(c, d);
      at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = cost(d);
    }
  }
  return (a + b) / 2;
}

std::vector<StampedPose> Thinned(const std::vector<StampedPose>& poses) {
  const std::size_t every = (poses.size() + kMaxRefinedPoses - 1) / kMaxRefinedPoses;
  std::vector<StampedPose> thinned;
  for (std::size_t i = 0; i < poses.size(); i += every) thinned.push_back(poses[i]);
  return thinned;
}

// Mean squared speed of the truth, m^2/s^2; the yaw rate is weighted by the lever.
double MeanSquareSpeed(const MotionProfile& profile, double lever_m) {
  double squares = 0;
  double known = 0;
  for (std::size_t i = 0; i < profile.speed.values.size(); ++i) {
    const double turn = lever_m * profile.yaw_rate.values[i];
    squares += profile.speed.values[i] * profile.speed.values[i] + turn * turn;
    known += profile.speed.known[i];
  }
  return known > 0 ? squares / known : 0;
}

// Keeps the better one of two offsets and the residual of the other one. Offsets within `same_s`
// are the same.
void Offer(TimeOffset offset, double same_s, std::optional<TimeOffset>& best) {
  if (!best) {
    best = offset;
    return;
  }
  const bool same = std::abs(offset.offset_s - best->offset_s) < same_s;
  const bool better = offset.unexplained < best->unexplained;
  const double loser = better ? best->unexplained : offset.unexplained;
  offset.runner_up = best->runner_up;
  if (better) best = offset;
  if (!same) best->runner_up = std::min(best->runner_up, loser);
}

}  // namespace

bool TimeOffset::IsReliable() const {
  constexpr double kMinCorrelation = 0.3;
  constexpr double kMaxUnexplained = 0.1;
  constexpr double kMaxOfRunnerUp = 0.25;  // half of the runner-up's error
  return correlation > kMinCorrelation && unexplained < kMaxUnexplained &&
         unexplained < kMaxOfRunnerUp * runner_up;
}

std::optional<TimeOffset> FindTimeOffset(const std::vector<StampedPose>& truth,
                                         const std::vector<StampedPose>& estimate) {
  if (truth.size() < 2 || estimate.size() < 2) return std::nullopt;
  const PlanarTrack true_track(truth);
  const PlanarTrack track(estimate);
  const double longer_s =
      std::max(true_track.End() - true_track.Start(), track.End() - track.Start());
  const double step_s = std::max(
      {true_track.MedianStep(), track.MedianStep(), longer_s / static_cast<double>(kMaxSamples)});
  const auto half_window = std::max<std::int64_t>(1, std::llround(kWindowS / (2 * step_s)));
  const MotionProfile true_motion = Resample(true_track, step_s, half_window);
  const std::vector<Score> candidates =
      Candidates(ScoreShifts(true_motion, Resample(track, step_s, half_window)));
  if (candidates.empty()) return std::nullopt;

  const double reach_s = static_cast<double>(half_window + 1) * step_s;
  const double speed2 = MeanSquareSpeed(true_motion, kLeverM);
  const std::vector<StampedPose> thinned = Thinned(estimate);
  std::optional<TimeOffset> best;
  for (const Score& candidate : candidates) {
    const double coarse_s =
        true_track.Start() - track.Start() + static_cast<double>(candidate.shift) * step_s;
    TimeOffset offset{.correlation = std::min(1.0, candidate.correlation)};
    offset.offset_s = Refine(true_track, thinned, coarse_s - reach_s, coarse_s + reach_s, kLeverM);
    const Residual residual = ResidualAt(true_track, thinned, offset.offset_s, kLeverM);
    if (residual.poses == 0) continue;
    offset.unexplained = residual.Unexplained();
    const double weight = static_cast<double>(residual.poses) * speed2;
    if (weight > 0) offset.sigma_s = std::sqrt(residual.mean_square / weight);
    Offer(offset, 2 * reach_s, best);
  }
  return best;
}

std::vector<StampedPose> Delayed(std::vector<StampedPose> poses, double offset_s) {
  for (StampedPose& pose : poses) pose.stamp_s += offset_s;
  return poses;
}

}  // namespace ceilmap::evaluation
