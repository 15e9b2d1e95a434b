#include "calib/solve/camera_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/solve/camera_problem.hpp"

namespace ceilmap::calibration {
namespace {

// A view is left out whose RMS is more than so many times the views' median, > 1.
constexpr double kOutlierFactor = 3;

using Eigen::Index;
using Eigen::MatrixXd;

// Candidate sets of coefficients, the simplest first; the last one contains all.
std::vector<std::vector<bool>> TermSets(const SolverParams& params) {
  const std::size_t count = CoefficientNames(params.model).size();
  std::vector<std::vector<int>> sets;
  if (params.choose_terms && params.model == LensModel::kEquidistant) {
    sets = {{}, {0}, {0, 1}, {0, 1, 2}};
  } else if (params.choose_terms) {
    sets = {{}, {0}, {0, 1}, {0, 2, 3}, {0, 1, 4}, {0, 1, 2, 3}};
  }
  if (params.choose_terms && params.model == LensModel::kRational) {
    // All eight together are hardly determined beyond the boards.
    sets.insert(sets.end(),
                {{0, 5},
                 {0, 1, 5},
                 {0, 2, 3, 5},
                 {0, 1, 4, 5},
                 {0, 1, 5, 6},
                 {0, 1, 2, 3, 4},
                 {0, 1, 2, 3, 5},
                 {0, 1, 2, 3, 4, 5},
                 {0, 1, 2, 3, 5, 6}});
  }
  std::vector<std::vector<bool>> free;
  for (const std::vector<int>& set : sets) {
    std::vector<bool>& terms = free.emplace_back(kPinholeValues + count, false);
    std::fill_n(terms.begin(), kPinholeValues, true);
    for (const int i : set) terms[kPinholeValues + static_cast<std::size_t>(i)] = true;
  }
  free.emplace_back(kPinholeValues + count, true);
  return free;
}

// Schwarz's criterion: twice the negative log likelihood plus a penalty per parameter.
double Criterion(const CameraEstimate& estimate,
                 const std::vector<bool>& free,
                 std::size_t corners) {
  const double numbers = 2 * static_cast<double>(corners);
  const auto values = static_cast<double>(std::count(free.begin(), free.end(), true));
  return numbers * std::log(std::max(estimate.squares_px2, 1e-12) / numbers) +
         values * std::log(numbers);
}

// True when the model is valid in the whole image.
bool ReachesCorners(const Lens& lens) {
  for (const double u : {0.0, lens.width_px - 1.0}) {
    for (const double v : {0.0, lens.height_px - 1.0}) {
      if (!lens.Ray({u, v})) return false;
    }
  }
  return true;
}

// A set of coefficients with its fit.
struct Candidate {
  CameraEstimate estimate;
  std::vector<bool> free;
  double criterion = std::numeric_limits<double>::infinity();
};

// The best candidate. A model that ends before the corners of the image, where no board was, yields
// to one that reaches them and fits nearly as well.
const Candidate* Choose(const std::vector<Candidate>& candidates) {
  constexpr double kNearlyAsWell = 1.1;  // ratio of the RMS
  const Candidate* best = nullptr;
  const Candidate* reaching = nullptr;
  for (const Candidate& candidate : candidates) {
    if (!best || candidate.criterion < best->criterion) best = &candidate;
    if (reaching && candidate.criterion >= reaching->criterion) continue;
    if (ReachesCorners(candidate.estimate.lens)) reaching = &candidate;
  }
  const bool nearly = reaching && reaching->estimate.squares_px2 <=
                                      kNearlyAsWell * kNearlyAsWell * best->estimate.squares_px2;
  return nearly ? reaching : best;
}

std::optional<CameraSolution> SolveOnce(const CameraProblem& problem, const SolverParams& params) {
  const std::optional<CameraEstimate> start = problem.Start();
  if (!start) return std::nullopt;
  std::vector<Candidate> candidates;
  for (const std::vector<bool>& free : TermSets(params)) {
    CameraEstimate estimate = *start;
    for (std::size_t i = kPinholeValues; i < free.size(); ++i) {
      if (!free[i]) estimate.lens.distortion[i - kPinholeValues] = 0;
    }
    problem.Minimise(free, estimate);
    if (!std::isfinite(estimate.squares_px2)) continue;
    const double criterion = Criterion(estimate, free, problem.UsedCorners());
    candidates.push_back({std::move(estimate), free, criterion});
  }
  const Candidate* const best = Choose(candidates);
  if (best == nullptr) return std::nullopt;
  return problem.Solution(best->estimate, best->free);
}

// The view with the largest residuals, if it does not belong to the same board and camera.
std::optional<std::size_t> Outlier(const CameraSolution& solution, double factor) {
  constexpr std::size_t kMinToRemove = 4;  // three must remain
  if (solution.UsedViews() < kMinToRemove) return std::nullopt;
  std::vector<double> rms_px;
  const SolvedView* worst = nullptr;
  for (const SolvedView& view : solution.views) {
    if (!view.used) continue;
    rms_px.push_back(view.rms_px);
    if (worst == nullptr || view.rms_px > worst->rms_px) worst = &view;
  }
  const auto middle = rms_px.begin() + static_cast<std::ptrdiff_t>(rms_px.size() / 2);
  std::nth_element(rms_px.begin(), middle, rms_px.end());
  if (worst == nullptr || worst->rms_px <= factor * *middle) return std::nullopt;
  return worst->view;
}

// The direction of a pixel, or of the last pixel on the line to it that has a direction.
std::optional<Eigen::Vector3d> RayTowards(const Lens& lens, const Eigen::Vector2d& pixel) {
  constexpr int kSteps = 20;
  const Eigen::Vector2d centre(lens.cx, lens.cy);
  for (int step = kSteps; step > 0; --step) {
    const double fraction = static_cast<double>(step) / kSteps;
    if (auto ray = lens.Ray(centre + fraction * (pixel - centre))) return ray;
  }
  return std::nullopt;
}

// A variance that is not a number, or negative, is that of an undetermined value.
double RootOf(double variance) {
  return variance >= 0 ? std::sqrt(variance) : std::numeric_limits<double>::infinity();
}

}  // namespace

double CameraSolution::Sigma(Index i) const {
  return RootOf(covariance(i, i));
}

std::size_t CameraSolution::UsedViews() const {
  return static_cast<std::size_t>(
      std::count_if(views.begin(), views.end(), [](const SolvedView& view) { return view.used; }));
}

double CameraSolution::CornerSigma() const {
  const double right = lens.width_px - 1;
  const double bottom = lens.height_px - 1;
  double greatest = 0;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0),
                                        Eigen::Vector2d(right, 0),
                                        Eigen::Vector2d(0, bottom),
                                        Eigen::Vector2d(right, bottom)}) {
    const std::optional<Eigen::Vector3d> ray = RayTowards(lens, corner);
    if (!ray) return std::numeric_limits<double>::infinity();
    const MatrixXd by_lens =
        calib::ProjectWithDerivatives(lens, *ray).by_lens.leftCols(covariance.cols());
    const Eigen::Matrix2d spread = by_lens * covariance * by_lens.transpose();
    greatest = std::max(greatest, RootOf(spread.trace()));
  }
  return greatest;
}

std::optional<CameraSolution> SolveCamera(const Board& board,
                                          const std::vector<BoardView>& views,
                                          cv::Size size,
                                          const SolverParams& params) {
  CameraProblem problem(board, views, size, params.model);
  std::optional<CameraSolution> solution = SolveOnce(problem, params);
  while (solution) {
    const std::optional<std::size_t> outlier = Outlier(*solution, kOutlierFactor);
    if (!outlier) break;
    problem.LeaveOut(*outlier);
    solution = SolveOnce(problem, params);
  }
  return solution;
}

}  // namespace ceilmap::calibration
