#include "mapping/survey/alignment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/one_line.hpp"
#include "calib/base/planar_fit.hpp"

namespace ceilmap::survey {
namespace {

constexpr std::size_t kMaxPoints = 10'000;
constexpr std::size_t kMaxHypotheses = 5'000;  // pairs of points
constexpr int kMaxRounds = 20;
// A point whose residual is larger than this many of its standard deviations contradicts the
// others. Of good points one in 800 has such a residual.
constexpr double kOutlierSigmas = 3.7;
// A wrong unit or a mirrored axis is reported when it explains the points better by this factor.
constexpr double kMuchBetter = 5;
// Scales beyond these are no error of a camera's height or focal length.
constexpr double kMinScale = 0.8;
constexpr double kMaxScale = 1.25;
constexpr double kLargestYawSigmaRad = 0.1;
// Larger numbers are mistakes, and their squares would leave the range of a double.
constexpr double kMaxCoordinate = 1e9;  // map units, metres
constexpr double kMinSigmaM = 1e-6;
constexpr double kMaxSigmaM = 1e6;
// Residuals that exceed the points' standard deviations by this factor are contradictions.
constexpr double kLargestRatio = 100;

double Squared(double value) {
  return value * value;
}

/// All points, or a subset: pairs for the fit, with weights 1 / sigma^2.
using Pairs = std::vector<PointPair>;

/// Squared residual in units of the point's variance.
double Chi2(const PointPair& pair, const Similarity2& S_site_map) {
  return pair.weight * (pair.p_a - S_site_map * pair.p_b).squaredNorm();
}

/// Number of points that agree with a good hypothesis if fewer than half are wrong.
std::size_t Majority(std::size_t points) {
  return std::min(points, (points + 3) / 2);
}

/// A transform and its error: the Majority-th smallest Chi2 of all points.
struct Hypothesis {
  Similarity2 S_site_map;
  double chi2 = std::numeric_limits<double>::infinity();
};

Hypothesis Score(const Pairs& pairs, const Similarity2& S_site_map, std::vector<double>& chi2) {
  chi2.clear();
  for (const PointPair& pair : pairs) chi2.push_back(Chi2(pair, S_site_map));
  const auto at = chi2.begin() + static_cast<std::ptrdiff_t>(Majority(pairs.size())) - 1;
  std::nth_element(chi2.begin(), at, chi2.end());
  return {S_site_map, *at};
}

/// The best transform by two points (least median of squares).
Hypothesis BestByTwo(const Pairs& pairs, bool estimate_scale) {
  Hypothesis best;
  std::vector<double> chi2;
  const auto test = [&](std::size_t i, std::size_t j) {
    const auto fit = FitPlane(Pairs{pairs[i], pairs[j]}, estimate_scale);
    if (!fit) return;
    const Hypothesis hypothesis = Score(pairs, fit->S_a_b, chi2);
    if (hypothesis.chi2 < best.chi2) best = hypothesis;
  };
  const std::size_t n = pairs.size();
  if (n * (n - 1) / 2 <= kMaxHypotheses) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) test(i, j);
    }
    return best;
  }
  std::mt19937 random(1);  // the result depends on the points alone
  for (std::size_t k = 0; k < kMaxHypotheses; ++k) {
    const std::size_t i = random() % n;
    const std::size_t j = random() % n;
    if (i != j) test(i, j);
  }
  return best;
}

Pairs Mirrored(Pairs pairs) {
  for (PointPair& pair : pairs) pair.p_a.y() = -pair.p_a.y();
  return pairs;
}

/// Reports coordinates in another unit or with a mirrored axis.
void CheckConventions(const Pairs& pairs, const Hypothesis& best, bool estimate_scale) {
  // Below the points' standard deviations all hypotheses are equally good.
  const double error = std::max(best.chi2, 1.0);
  if (!estimate_scale) {
    const Hypothesis scaled = BestByTwo(pairs, true);
    const double scale = scaled.S_site_map.scale;
    if ((scale < kMinScale || scale > kMaxScale) &&
        std::max(scaled.chi2, 1.0) * Squared(kMuchBetter) < error) {
      throw InputError(fmt::format(
          "distances between the points are {:.4g} times as long in the building as in the map; "
          "site coordinates must be in metres, and the map must have been made with a right rig",
          scale));
    }
  }
  if (pairs.size() < 3) return;
  const Hypothesis mirrored = BestByTwo(Mirrored(pairs), estimate_scale);
  if (std::max(mirrored.chi2, 1.0) * Squared(kMuchBetter) < error) {
    throw InputError(
        "the points agree with a mirrored map: site_x and site_y are exchanged, or one of them has "
        "the opposite sign; y must be counter-clockwise from x, seen from above");
  }
}

/// Indices of points, and the fit to them.
struct Consensus {
  std::vector<std::size_t> used;
  PlanarFit fit;
  double ratio = 1;  ///< of the residuals to the points' standard deviations, at least 1
};

class Aligner {
 public:
  Aligner(const std::vector<ControlPoint>& points, const AlignOptions& params);

  Alignment Run();

 private:
  [[nodiscard]] std::optional<PlanarFit> FitTo(const std::vector<std::size_t>& used) const;
  [[nodiscard]] std::optional<PlanarFit> FitWithout(const std::vector<std::size_t>& used,
                                                    std::size_t left_out) const;
  [[nodiscard]] Consensus Begin(const Hypothesis& hypothesis) const;
  [[nodiscard]] std::vector<std::size_t> Agreeing(const Consensus& consensus) const;
  [[nodiscard]] Consensus Refit(std::vector<std::size_t> used) const;
  [[nodiscard]] double Leverage(const PlanarFit& fit, std::size_t point) const;
  [[nodiscard]] Alignment Report(const Consensus& consensus) const;

  std::vector<ControlPoint> points_;  // with sigma_m
  AlignOptions params_;
  Pairs pairs_;
};

Aligner::Aligner(const std::vector<ControlPoint>& points, const AlignOptions& params)
    : points_(points), params_(params) {
  for (ControlPoint& point : points_) {
    if (point.sigma_m == 0) point.sigma_m = params.sigma_m;
    pairs_.push_back({point.p_site, point.p_map, 1 / Squared(point.sigma_m)});
  }
}

std::optional<PlanarFit> Aligner::FitTo(const std::vector<std::size_t>& used) const {
  Pairs pairs;
  for (const std::size_t i : used) pairs.push_back(pairs_[i]);
  return FitPlane(pairs, params_.estimate_scale);
}

std::optional<PlanarFit> Aligner::FitWithout(const std::vector<std::size_t>& used,
                                             std::size_t left_out) const {
  std::vector<std::size_t> others;
  std::copy_if(used.begin(), used.end(), std::back_inserter(others), [&](std::size_t i) {
    return i != left_out;
  });
  return FitTo(others);
}

/// Variance of the fit's prediction at a point, in units of the point's variance.
double Aligner::Leverage(const PlanarFit& fit, std::size_t point) const {
  const double turning = params_.estimate_scale ? 1 : 0.5;  // a rotation moves along one axis only
  const PointPair& pair = pairs_[point];
  return pair.weight *
         (1 / fit.weights + turning * (pair.p_b - fit.centre_b).squaredNorm() / fit.moment_b);
}

/// The points that a transform by two points explains.
Consensus Aligner::Begin(const Hypothesis& hypothesis) const {
  const auto n = static_cast<double>(pairs_.size());
  const double fraction = static_cast<double>(Majority(pairs_.size())) / (n + 1);
  // The quantile of a chi-squared with two degrees of freedom.
  const double expected = -2 * std::log(1 - fraction);
  Consensus consensus;
  consensus.ratio = std::max(1.0, std::sqrt(hypothesis.chi2 / expected));
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (Chi2(pairs_[i], hypothesis.S_site_map) <= Squared(kOutlierSigmas * consensus.ratio)) {
      consensus.used.push_back(i);
    }
  }
  return consensus;
}

/// The points whose difference from what the others predict is within the threshold.
std::vector<std::size_t> Aligner::Agreeing(const Consensus& consensus) const {
  std::vector<std::size_t> agreeing;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const std::optional<PlanarFit> others = FitWithout(consensus.used, i);
    if (!others) continue;
    const double limit = Squared(kOutlierSigmas * consensus.ratio);
    if (Chi2(pairs_[i], others->S_a_b) <= limit * (1 + Leverage(*others, i))) {
      agreeing.push_back(i);
    }
  }
  return agreeing;
}

Consensus Aligner::Refit(std::vector<std::size_t> used) const {
  Consensus consensus;
  const std::optional<PlanarFit> fit = FitTo(used);
  if (!fit) {
    throw InputError("the points lie in one place; choose points at the far ends of the map");
  }
  consensus.fit = *fit;
  double chi2 = 0;
  for (const std::size_t i : used) chi2 += Chi2(pairs_[i], fit->S_a_b);
  const double unknowns = params_.estimate_scale ? 4 : 3;
  const double redundancy = 2 * static_cast<double>(used.size()) - unknowns;
  if (redundancy > 0) consensus.ratio = std::max(1.0, std::sqrt(chi2 / redundancy));
  consensus.used = std::move(used);
  return consensus;
}

Alignment Aligner::Run() {
  const Hypothesis best = BestByTwo(pairs_, params_.estimate_scale);
  if (!std::isfinite(best.chi2)) {
    throw InputError("the points lie in one place; choose points at the far ends of the map");
  }
  CheckConventions(pairs_, best, params_.estimate_scale);
  Consensus consensus = Refit(Begin(best).used);
  for (int round = 0; round < kMaxRounds && pairs_.size() > 3; ++round) {
    std::vector<std::size_t> agreeing = Agreeing(consensus);
    if (agreeing == consensus.used) break;
    if (agreeing.size() < 3) break;
    consensus = Refit(std::move(agreeing));
  }
  if (consensus.ratio > kLargestRatio) {
    throw InputError(
        fmt::format("the points contradict each other: their residuals are {:.0f} times as large "
                    "as their standard deviations; check the coordinates, or state a larger sigma",
                    consensus.ratio));
  }
  if (consensus.used.size() < Majority(points_.size())) {
    throw InputError(
        fmt::format("the points contradict each other: at most {} of {} agree; check the "
                    "coordinates, and whether x and y belong to the same point",
                    consensus.used.size(),
                    points_.size()));
  }
  return Report(consensus);
}

Alignment Aligner::Report(const Consensus& consensus) const {
  Alignment alignment;
  SiteFrame& site = alignment.site;
  site.S_site_map = consensus.fit.S_a_b;
  site.centre_map = consensus.fit.centre_b;
  site.sigma_position_m = consensus.ratio / std::sqrt(consensus.fit.weights);
  site.sigma_yaw_rad =
      consensus.ratio / (site.S_site_map.scale * std::sqrt(consensus.fit.moment_b));
  if (params_.estimate_scale) site.sigma_scale = site.sigma_yaw_rad;
  if (site.sigma_yaw_rad > kLargestYawSigmaRad) {
    throw InputError(
        fmt::format("the points are too close together: the direction would be uncertain by {:.0f} "
                    "degrees; choose points at the far ends of the map",
                    site.sigma_yaw_rad * kDegPerRad));
  }
  std::vector<char> used(points_.size(), 0);
  for (const std::size_t i : consensus.used) used[i] = 1;
  double squares = 0;
  double left_out_squares = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    AlignedPoint point;
    point.point = points_[i];
    point.residual_m = point.point.p_site - site.S_site_map * point.point.p_map;
    point.used = used[i] != 0;
    if (const auto others = FitWithout(consensus.used, i)) {
      point.leave_one_out_m = (point.point.p_site - others->S_a_b * point.point.p_map).norm();
    }
    if (point.used) {
      squares += point.residual_m.squaredNorm();
      left_out_squares += Squared(point.leave_one_out_m.value_or(0));
    }
    site.points.push_back(std::move(point));
  }
  const auto n = static_cast<double>(consensus.used.size());
  alignment.used = static_cast<int>(consensus.used.size());
  alignment.rms_m = std::sqrt(squares / n);
  alignment.leave_one_out_rms_m = std::sqrt(left_out_squares / n);
  alignment.sigma_ratio = consensus.ratio;
  alignment.checked = alignment.used >= 4;
  return alignment;
}

void CheckPoints(const std::vector<ControlPoint>& points) {
  if (points.size() < 2) {
    throw InputError(
        fmt::format("{} point{}: at least two are needed, and four to find a wrong one",
                    points.size(),
                    points.size() == 1 ? "" : "s"));
  }
  if (points.size() > kMaxPoints) {
    throw InputError(fmt::format("{} points: at most {} can be used", points.size(), kMaxPoints));
  }
  std::set<std::string> names;
  for (const ControlPoint& point : points) {
    if (point.name.empty() || !names.insert(point.name).second) {
      throw InputError(point.name.empty()
                           ? "a point has no name"
                           : fmt::format("two points have the name '{}'", Shown(point.name)));
    }
    const auto within = [](const Eigen::Vector2d& p) {
      return std::abs(p.x()) <= kMaxCoordinate && std::abs(p.y()) <= kMaxCoordinate;
    };
    if (!within(point.p_map) || !within(point.p_site)) {
      throw InputError(fmt::format(
          "point '{}': the coordinates must be within {:g}", Shown(point.name), kMaxCoordinate));
    }
    if (point.sigma_m != 0 && !(point.sigma_m >= kMinSigmaM && point.sigma_m <= kMaxSigmaM)) {
      throw InputError(fmt::format("point '{}': sigma_m = {}, must be in {:g}..{:g}, or 0",
                                   Shown(point.name),
                                   point.sigma_m,
                                   kMinSigmaM,
                                   kMaxSigmaM));
    }
  }
}

}  // namespace

void AlignOptions::Validate() const {
  const FieldCheck check("alignment");
  check(sigma_m >= kMinSigmaM && sigma_m <= kMaxSigmaM, "sigma_m", sigma_m, "in 1e-06..1e+06");
}

Alignment Align(const std::vector<ControlPoint>& points, const AlignOptions& params) {
  params.Validate();
  CheckPoints(points);
  return Aligner(points, params).Run();
}

}  // namespace ceilmap::survey
