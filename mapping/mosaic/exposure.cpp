#include "mapping/mosaic/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <span>

#include "calib/base/sparse_cholesky.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr int kVignettingTerms = 3;
constexpr int kRounds = 6;
constexpr double kHuber = 0.02;  // log units: about 2 % of grey, twice the noise of a patch mean
constexpr double kRidge = 1e-4;  // in units of one observation

constexpr int kBandRounds = 10;         // in each of the rounds
constexpr double kBandPrior = 1;        // observations that a keyframe without bands is worth
constexpr double kVisibleBand = 0.005;  // log units: weaker bands are errors of the fit

/// Largest number of observations of one point. The work for a point grows with the square of this
/// number, and a robot may pass under a point any number of times.
constexpr std::size_t kMaxMatches = 8;

using Observations = std::span<const ExposureObservation>;

/// The observations sorted by point, without the points observed only once, and at most kMaxMatches
/// of each point. These are drawn at random: a regular choice would separate the keyframes into
/// groups that are hardly compared with each other.
std::vector<ExposureObservation> Select(std::vector<ExposureObservation> all) {
  std::stable_sort(
      all.begin(), all.end(), [](const ExposureObservation& a, const ExposureObservation& b) {
        return a.point < b.point;
      });
  std::minstd_rand random;  // default seed: the result is reproducible
  std::vector<ExposureObservation> selected;
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin + 1;
    while (end < all.size() && all[end].point == all[begin].point) ++end;
    const std::size_t seen = end - begin;
    const std::size_t count = seen < 2 ? 0 : std::min(seen, kMaxMatches);
    for (std::size_t i = 0; i < count; ++i) {
      if (seen > kMaxMatches) std::swap(all[begin + i], all[begin + i + random() % (seen - i)]);
      selected.push_back(all[begin + i]);
    }
    begin = end;
  }
  return selected;
}

/// One span of sorted observations for each point.
std::vector<Observations> GroupByPoint(const std::vector<ExposureObservation>& observations) {
  std::vector<Observations> points;
  for (std::size_t begin = 0; begin < observations.size();) {
    std::size_t end = begin + 1;
    while (end < observations.size() && observations[end].point == observations[begin].point) ++end;
    points.emplace_back(&observations[begin], end - begin);
    begin = end;
  }
  return points;
}

std::array<double, kVignettingTerms> Powers(double q) {
  return {q, q * q, q * q * q};
}

/// Normal equations of all unknowns x = (gains, vignetting), with the points' brightnesses
/// eliminated: each point adds sum w a a^T - (sum w a)(sum w a)^T / sum w, where a is an
/// observation's row.
class NormalEquations {
 public:
  explicit NormalEquations(int unknowns) : right_(Eigen::VectorXd::Zero(unknowns)) {
    for (int i = 0; i < unknowns; ++i) entries_.push_back({i, i, kRidge});
  }

  void AddPoint(Observations observations,
                const std::vector<double>& weights,
                const ExposureModel& model) {
    const int first_term = static_cast<int>(right_.size()) - kVignettingTerms;
    const double sum_w = std::accumulate(weights.begin(), weights.end(), 0.0);
    row_.clear();  // sum w a as (unknown, value); the three vignetting terms come last
    std::array<double, kVignettingTerms> terms_sum{};
    double grey_sum = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const auto terms = Powers(observations[i].q);
      const double w = weights[i];
      const int k = observations[i].keyframe;
      row_.emplace_back(k, w);
      const double log_grey =
          observations[i].log_grey - model.LogBand(observations[i].keyframe, observations[i].row_s);
      grey_sum += w * log_grey;
      entries_.push_back({k, k, w});
      right_[k] += w * log_grey;
      for (int m = 0; m < kVignettingTerms; ++m) {
        terms_sum[m] += w * terms[m];
        entries_.push_back({first_term + m, k, w * terms[m]});
        right_[first_term + m] += w * terms[m] * log_grey;
        for (int n = 0; n <= m; ++n) {
          entries_.push_back({first_term + m, first_term + n, w * terms[m] * terms[n]});
        }
      }
    }
    for (int m = 0; m < kVignettingTerms; ++m) row_.emplace_back(first_term + m, terms_sum[m]);
    for (const auto& [r, value_r] : row_) {
      right_[r] -= value_r * grey_sum / sum_w;
      for (const auto& [c, value_c] : row_) {
        if (c <= r) entries_.push_back({r, c, -value_r * value_c / sum_w});
      }
    }
  }

  [[nodiscard]] Eigen::VectorXd Solve() const {
    return SparseCholesky(right_.size(), entries_).Solve(right_);
  }

 private:
  std::vector<SparseCholesky::Entry> entries_;
  Eigen::VectorXd right_;
  std::vector<std::pair<int, double>> row_;
};

/// Log brightness of the point, as one observation has it.
double BrightnessBy(const ExposureObservation& o, const ExposureModel& model) {
  return o.log_grey - model.log_gain[o.keyframe] - model.LogVignetting(o.q) -
         model.LogBand(o.keyframe, o.row_s);
}

/// Huber weights of a point's observations about the point's brightness, the median of its
/// observations.
std::vector<double> Weights(Observations observations, const ExposureModel& model) {
  std::vector<double> brightness;
  for (const ExposureObservation& o : observations) {
    brightness.push_back(BrightnessBy(o, model));
  }
  std::vector<double> sorted = brightness;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (double& value : brightness) {
    const double residual = std::abs(value - *middle);
    value = residual <= kHuber ? 1 : kHuber / residual;
  }
  return brightness;
}

double MeanBrightness(Observations observations,
                      const std::vector<double>& weights,
                      const ExposureModel& model) {
  double sum = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    sum += weights[i] * BrightnessBy(observations[i], model);
  }
  return sum / std::accumulate(weights.begin(), weights.end(), 0.0);
}

/// The waves of a row, whose sum by the parts of a band's amplitude is the band; and a constant.
Eigen::Vector3d WavesOf(double row_s, double flicker_hz) {
  const double phase = 2 * std::numbers::pi * flicker_hz * row_s;
  return {std::cos(phase), -std::sin(phase), 1};
}

/// Fits the bands of each keyframe to what its observations differ from the points' brightness. A
/// point's brightness contains the bands themselves: repeated until they are complete.
void FitBands(const std::vector<Observations>& points, ExposureModel& model) {
  const std::size_t keyframes = model.bands.size();
  for (int round = 0; round < kBandRounds; ++round) {
    std::vector<Eigen::Matrix3d> normal(keyframes, kBandPrior * Eigen::Matrix3d::Identity());
    std::vector<Eigen::Vector3d> right(keyframes, Eigen::Vector3d::Zero());
    for (const Observations& point : points) {
      const std::vector<double> weights = Weights(point, model);
      const double mean = MeanBrightness(point, weights, model);
      for (std::size_t i = 0; i < point.size(); ++i) {
        const auto k = static_cast<std::size_t>(point[i].keyframe);
        const Eigen::Vector3d waves = WavesOf(point[i].row_s, model.flicker_hz);
        normal[k] += weights[i] * waves * waves.transpose();
        right[k] += weights[i] * (BrightnessBy(point[i], model) - mean) * waves;
      }
    }
    for (std::size_t k = 0; k < keyframes; ++k) {
      right[k].head<2>() -=
          kBandPrior * Eigen::Vector2d(model.bands[k].real(), model.bands[k].imag());
      const Eigen::Vector3d more = normal[k].ldlt().solve(right[k]);
      model.bands[k] += std::complex<double>(more[0], more[1]);
    }
  }
}

/// Gains, vignetting and, at a frequency that is not 0, bands.
ExposureModel Solve(int keyframes, const std::vector<Observations>& points, double flicker_hz) {
  ExposureModel model;
  model.log_gain.assign(static_cast<std::size_t>(keyframes), 0);
  model.flicker_hz = flicker_hz;
  if (flicker_hz > 0) model.bands.assign(static_cast<std::size_t>(keyframes), 0);
  for (int round = 0; round < kRounds; ++round) {
    NormalEquations equations(keyframes + kVignettingTerms);
    for (const Observations& point : points) {
      // The first iteration has no residuals: all observations have equal weight.
      const std::vector<double> weights =
          round == 0 ? std::vector<double>(point.size(), 1) : Weights(point, model);
      equations.AddPoint(point, weights, model);
    }
    const Eigen::VectorXd x = equations.Solve();
    for (int k = 0; k < keyframes; ++k) model.log_gain[k] = x[k];
    for (int m = 0; m < kVignettingTerms; ++m) model.vignetting[m] = x[keyframes + m];
    if (flicker_hz > 0) FitBands(points, model);
  }
  return model;
}

/// Sum of Huber's loss of all observations.
double LossOf(const std::vector<Observations>& points, const ExposureModel& model) {
  double loss = 0;
  for (const Observations& point : points) {
    const std::vector<double> weights = Weights(point, model);
    const double mean = MeanBrightness(point, weights, model);
    for (std::size_t i = 0; i < point.size(); ++i) {
      loss += weights[i] * std::pow(BrightnessBy(point[i], model) - mean, 2);
    }
  }
  return loss;
}

}  // namespace

double ExposureModel::LogBand(int keyframe, double row_s) const {
  if (bands.empty()) return 0;
  const double phase = 2 * std::numbers::pi * flicker_hz * row_s;
  return std::real(bands[static_cast<std::size_t>(keyframe)] * std::polar(1.0, phase));
}

double ExposureModel::LogVignetting(double q) const {
  return q * (vignetting[0] + q * (vignetting[1] + q * vignetting[2]));
}

ExposureModel SolveExposure(int keyframes,
                            std::vector<ExposureObservation> observations,
                            bool rolling) {
  const std::vector<ExposureObservation> selected = Select(std::move(observations));
  const std::vector<Observations> points = GroupByPoint(selected);
  ExposureModel model = Solve(keyframes, points, 0);
  if (rolling) {
    for (const double mains_hz : {100.0, 120.0}) {
      ExposureModel with_bands = Solve(keyframes, points, mains_hz);
      if (LossOf(points, with_bands) < LossOf(points, model)) model = std::move(with_bands);
    }
    for (std::complex<double>& band : model.bands) {
      if (std::abs(band) < kVisibleBand) band = 0;
    }
  }
  if (keyframes > 0) {
    const double mean =
        std::accumulate(model.log_gain.begin(), model.log_gain.end(), 0.0) / keyframes;
    for (double& gain : model.log_gain) gain -= mean;
  }
  return model;
}

}  // namespace ceilmap::mosaic
