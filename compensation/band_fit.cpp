#include "compensation/band_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace ceilmap::compensation {
namespace {

constexpr std::size_t kMinSamples = 60;
constexpr std::size_t kMaxPairs = 48;
// Pairs of this age count a third: amplitude and frequency change slowly.
constexpr double kMemoryS = 3;
// Twice the largest deviation of mains from their nominal frequency, and its resolution.
constexpr double kReachHz = 0.3;
constexpr double kStepHz = 0.03;
// Standard deviation of an amplitude before anything is measured, log grey.
constexpr double kPriorSigma = 0.3;
// What the points of a pair have in common beside bands, as an error of each amplitude. While the
// robot has hardly moved, it is large compared with what bands that stand still change.
constexpr double kCommonSigma = 0.003;
// Bands are removed once the standard deviation is below this part of their amplitude: a wrong
// frequency within the first images changes it by a multiple of that.
constexpr double kMaxSigmaRatio = 0.03;
// Weaker bands are left to the mosaic: the removal of bands of 0.014, in a room with weak plaster
// and a turning fan, did not make the poses better.
constexpr double kMinAmplitude = 0.02;
// Bands that explain less of what changes between images are not removed. Without flicker, depth
// and moving things look like bands that explain 0.5 %; bands of 0.014 explained 2 to 20 %, bands
// of 0.1 95 %.
constexpr double kMinExplained = 0.015;
// Bands that were found remain so down to this part of these limits.
constexpr double kKnownRatio = 0.5;

constexpr int kGains = 3;  // gain, two terms of vignetting
constexpr int kUnknowns = kGains + 4;
using Row = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

Row RowOf(const BandSample& sample, double frequency_hz) {
  const double now = 2 * std::numbers::pi * frequency_hz * sample.row_s;
  const double then = 2 * std::numbers::pi * frequency_hz * sample.earlier_row_s;
  const double r2 = sample.radius2;
  const double earlier_r2 = sample.earlier_radius2;
  Row row;
  row << 1, r2 - earlier_r2, r2 * r2 - earlier_r2 * earlier_r2, std::cos(now), -std::sin(now),
      -std::cos(then), std::sin(then);
  return row;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Columns: real and imaginary part of the amplitude at a time; rows: those after `after_s`.
Eigen::Matrix2d Turned(double frequency_hz, double after_s) {
  const double phase = 2 * std::numbers::pi * std::remainder(frequency_hz * after_s, 1.0);
  const double c = std::cos(phase);
  const double s = std::sin(phase);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

}  // namespace

double Bands::LogGain(double time_s) const {
  const double turns = std::remainder(frequency_hz * (time_s - stamp_s), 1.0);
  return std::real(amplitude * std::polar(1.0, 2 * std::numbers::pi * turns));
}

/// Huber's weights on a robust scale: what moves or lies off the ceiling's plane does not count.
BandFit::Quadratic BandFit::Reduce(std::span<const BandSample> samples, double frequency_hz) {
  constexpr int kRounds = 4;
  constexpr double kHuber = 1.5;
  constexpr double kMinSigma = 0.002;  // rounding of grey values
  constexpr double kMadToSigma = 1.4826;
  std::vector<Row> rows;
  rows.reserve(samples.size());
  for (const BandSample& sample : samples) rows.push_back(RowOf(sample, frequency_hz));
  std::vector<double> weights(samples.size(), 1);
  std::vector<double> errors(samples.size());
  Normal normal;
  Row right;
  double total = 0;
  double sigma = 1;
  for (int round = 0; round < kRounds; ++round) {
    normal.setZero();
    right.setZero();
    total = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      normal += weights[i] * rows[i] * rows[i].transpose();
      right += weights[i] * samples[i].log_ratio * rows[i];
      total += weights[i] * samples[i].log_ratio * samples[i].log_ratio;
    }
    constexpr double kRidge = 1e-6;  // of a robot at rest, whose images tell less than all unknowns
    const Row x = (normal + kRidge * Normal::Identity()).ldlt().solve(right);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      errors[i] = std::abs(samples[i].log_ratio - rows[i].dot(x));
    }
    sigma = std::max(kMinSigma, kMadToSigma * MedianOf(errors));
    if (round + 1 == kRounds) break;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      weights[i] = errors[i] <= kHuber * sigma ? 1 : kHuber * sigma / errors[i];
    }
  }
  // Gain and vignetting are eliminated.
  const Eigen::Matrix3d gains =
      normal.topLeftCorner<kGains, kGains>() + 1e-6 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 4, kGains> mixed = normal.bottomLeftCorner<4, kGains>();
  const Eigen::Matrix<double, 4, kGains> eliminate = mixed * gains.inverse();
  const double scale = 1 / (sigma * sigma);
  Quadratic reduced;
  reduced.of_points = scale * (normal.bottomRightCorner<4, 4>() - eliminate * mixed.transpose());
  reduced.right_of_points = scale * (right.tail<4>() - eliminate * right.head<kGains>());
  reduced.total =
      scale * (total - right.head<kGains>().dot(gains.inverse() * right.head<kGains>()));
  const Eigen::Matrix4d common =
      (Eigen::Matrix4d::Identity() + kCommonSigma * kCommonSigma * reduced.of_points).inverse();
  reduced.information = common * reduced.of_points;
  reduced.right = common * reduced.right_of_points;
  return reduced;
}

void BandFit::Add(double stamp_s, double earlier_stamp_s, std::span<const BandSample> samples) {
  if (samples.size() < kMinSamples) return;
  Pair pair{stamp_s, earlier_stamp_s, {}};
  for (std::size_t i = 0; i < kMainsHz.size(); ++i) {
    pair.by_mains[i] = Reduce(samples, kMainsHz[i]);
  }
  pairs_.push_back(pair);
  if (pairs_.size() > kMaxPairs) pairs_.pop_front();
}

/// All pairs under one frequency, at the time of the last one.
struct BandFit::Trial {
  Bands bands;
  double gain = 0;       // what the bands explain, the errors in common included
  double explained = 0;  // of what the points change, 0..1
  double sigma = 0;      // of the amplitude, in its least certain direction
};

BandFit::Trial BandFit::Try(std::size_t mains, double frequency_hz) const {
  const double stamp_s = pairs_.back().stamp_s;
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity() / (kPriorSigma * kPriorSigma);
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Eigen::Matrix2d of_points = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right_of_points = Eigen::Vector2d::Zero();
  double total = 0;
  for (const Pair& pair : pairs_) {
    const double weight = std::exp((pair.stamp_s - stamp_s) / kMemoryS);
    const Quadratic& q = pair.by_mains[mains];
    Eigen::Matrix<double, 4, 2> both;
    both << Turned(frequency_hz, pair.stamp_s - stamp_s),
        Turned(frequency_hz, pair.earlier_stamp_s - stamp_s);
    information += weight * both.transpose() * q.information * both;
    right += weight * both.transpose() * q.right;
    of_points += weight * both.transpose() * q.of_points * both;
    right_of_points += weight * both.transpose() * q.right_of_points;
    total += weight * q.total;
  }
  const Eigen::Vector2d x = information.ldlt().solve(right);
  Trial trial;
  trial.bands = {frequency_hz, stamp_s, {x[0], x[1]}};
  trial.gain = x.dot(right);
  if (total > 0) trial.explained = (2 * x.dot(right_of_points) - x.dot(of_points * x)) / total;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(information);
  trial.sigma = 1 / std::sqrt(axes.eigenvalues().minCoeff());
  return trial;
}

std::optional<Bands> BandFit::Solve(bool known) const {
  if (pairs_.empty()) return std::nullopt;
  Trial best;
  const auto steps = static_cast<int>(std::lround(kReachHz / kStepHz));
  for (std::size_t i = 0; i < kMainsHz.size(); ++i) {
    for (int step = -steps; step <= steps; ++step) {
      const Trial trial = Try(i, kMainsHz[i] + step * kStepHz);
      if (trial.gain > best.gain) best = trial;
    }
  }
  const double amplitude = std::abs(best.bands.amplitude);
  const double limit = known ? kKnownRatio : 1;
  if (best.explained < limit * kMinExplained || amplitude < limit * kMinAmplitude ||
      (!known && best.sigma > kMaxSigmaRatio * amplitude)) {
    return std::nullopt;
  }
  return best.bands;
}

}  // namespace ceilmap::compensation
