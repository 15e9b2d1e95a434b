#include "mapping/height_scales.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calib/base/sparse_cholesky.hpp"
#include "calib/base/statistics.hpp"
#include "mapping/heights/height_field.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

using heights::HeightCell;
using heights::HeightField;

/// A measurement of ln(factor of a) - ln(factor of b), or of ln(factor of a) alone.
struct ScaleTerm {
  int a = 0;
  int b = -1;  // -1: none
  double value = 0;
  double sigma = 1;
};

// Standard deviations: of the reference plane as one keyframe shows it, by the blocks of the
// registration or by dense stereo, and of what two keyframes have in common beyond the spread of
// their cells.
constexpr double kPlaneSigma = 0.015;
constexpr double kDensePlaneSigma = 0.004;
constexpr double kCommonSigma = 0.002;
// Fields with more cells are dense; of these a part is sufficient to compare them.
constexpr std::size_t kDenseCells = 5000;
// Where no keyframe of a part of the map shows the plane, its scale stays.
constexpr double kUnmeasuredSigma = 1;
// Cells with a larger standard deviation are not compared.
constexpr float kComparedSigma = 0.04F;

/// What moves by itself may have been measured behind the camera.
bool IsCompared(const HeightCell& cell) {
  return cell.sigma <= kComparedSigma && cell.rho > 0;
}

/// ln of the ratio of the scales of two keyframes that see the same things: points of one, seen in
/// the other.
std::optional<ScaleTerm> CompareScales(const calib::CeilingView& view,
                                       const Pose2& T_from_to,
                                       const HeightField& from,
                                       const HeightField& to) {
  constexpr std::size_t kFewest = 10;
  constexpr double kOffCentre = 0.5;  // of the distance of two cells
  const registration::PlaneCamera camera = registration::PlaneCameraOf(view);
  const auto motion =
      registration::PlaneMotion::FromSimilarity(camera, ImageMotionOf(view, T_from_to));
  std::vector<double> ratios;
  const std::size_t step = std::max<std::size_t>(1, from.cells.size() / kDenseCells);
  for (std::size_t i = 0; i < from.cells.size(); i += step) {
    const HeightCell& seen = from.cells[i];
    if (!IsCompared(seen)) continue;
    const Eigen::Vector2d x = motion.Apply(camera, from.Centre(i), seen.rho);
    const std::optional<std::size_t> hit = to.CellAt(x);
    if (!hit || !IsCompared(to.cells[*hit])) continue;
    const Eigen::Vector2d off = (x - to.Centre(*hit)).cwiseQuotient(to.step_px);
    if (off.cwiseAbs().maxCoeff() > kOffCentre) continue;
    ratios.push_back(std::log(seen.rho / to.cells[*hit].rho));
  }
  if (ratios.size() < kFewest) return std::nullopt;
  ScaleTerm term;
  term.value = Median(ratios);
  const auto count = static_cast<double>(ratios.size());
  for (double& ratio : ratios) ratio = std::abs(ratio - term.value);
  constexpr double kSigmaOfMedian = 1.4826 * 1.25;
  term.sigma = std::hypot(kCommonSigma, kSigmaOfMedian * Median(ratios) / std::sqrt(count));
  return term;
}

std::vector<ScaleTerm> Measure(const calib::CeilingView& view,
                               const graph::MapGraph& graph,
                               const std::unordered_map<std::int64_t, int>& index,
                               const std::vector<const HeightField*>& fields) {
  std::vector<ScaleTerm> terms;
  for (const graph::Edge& edge : graph.edges) {
    const auto from = index.find(edge.from);
    const auto to = index.find(edge.to);
    if (from == index.end() || to == index.end()) continue;
    auto term = CompareScales(view,
                              edge.T_from_to,
                              *fields[static_cast<std::size_t>(from->second)],
                              *fields[static_cast<std::size_t>(to->second)]);
    if (!term) continue;
    term->a = from->second;
    term->b = to->second;
    terms.push_back(*term);
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto plane = heights::FindReference(fields[i]->cells);
    const bool dense = fields[i]->cells.size() > kDenseCells;
    if (plane) {
      const double sigma = dense ? kDensePlaneSigma : kPlaneSigma;
      terms.push_back({static_cast<int>(i), -1, std::log(*plane), sigma});
    }
    terms.push_back({static_cast<int>(i), -1, 0, kUnmeasuredSigma});
  }
  return terms;
}

/// Least squares with Cauchy's weights, iterated.
Eigen::VectorXd Solve(const std::vector<ScaleTerm>& terms, Eigen::Index unknowns) {
  constexpr int kRounds = 15;
  constexpr double kCauchy = 2;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<SparseCholesky::Entry> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
    for (const ScaleTerm& term : terms) {
      const double predicted = x[term.a] - (term.b >= 0 ? x[term.b] : 0.0);
      const double off = (term.value - predicted) / term.sigma;
      const double robust = round == 0 ? 1 : 1 / (1 + off * off / (kCauchy * kCauchy));
      const double weight = robust / (term.sigma * term.sigma);
      entries.push_back({term.a, term.a, weight});
      right[term.a] += weight * term.value;
      if (term.b < 0) continue;
      entries.push_back({term.b, term.b, weight});
      entries.push_back({std::max(term.a, term.b), std::min(term.a, term.b), -weight});
      right[term.b] -= weight * term.value;
    }
    const SparseCholesky solver(unknowns, entries);
    if (!solver.HasFactors()) return Eigen::VectorXd::Zero(unknowns);
    x = solver.Solve(right);
  }
  return x;
}

}  // namespace

std::unordered_map<std::int64_t, double> ConsistentScales(const calib::CeilingView& view,
                                                          const graph::MapGraph& graph) {
  std::unordered_map<std::int64_t, int> index;
  std::vector<const HeightField*> fields;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    if (!keyframe.heights) continue;
    index[keyframe.id] = static_cast<int>(fields.size());
    fields.push_back(keyframe.heights.get());
  }
  std::unordered_map<std::int64_t, double> factors;
  if (fields.empty()) return factors;
  const Eigen::VectorXd solved =
      Solve(Measure(view, graph, index, fields), static_cast<Eigen::Index>(fields.size()));
  for (const auto& [id, at] : index) factors[id] = std::exp(solved[at]);
  return factors;
}

}  // namespace ceilmap::mapping
