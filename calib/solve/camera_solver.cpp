#include "calib/solve/camera_solver.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "calib/solve/board_pose.hpp"
#include "calib/solve/lens_covariance.hpp"

namespace ceilmap::calibration {
namespace {

// A view is left out whose RMS is more than so many times the views' median, > 1.
constexpr double kOutlierFactor = 3;

using Eigen::Index;
using Eigen::MatrixXd;

BoardPose PoseOf(const double* values) {
  return {{values[0], values[1], values[2]}, {values[3], values[4], values[5]}};
}

// The first coefficients of a model, which are always estimated: k1, k2, p1, p2 or k1, k2.
Index OpenTerms(LensModel model) {
  return model == LensModel::kEquidistant ? 2 : 4;
}

// Residuals of one view, as functions of the lens and the view's pose.
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(const Lens& lens,
           std::vector<cv::Point3d> points,
           const std::vector<cv::Point2d>& measured)
      : lens_(lens),
        values_(lens.Values().size()),
        points_(std::move(points)),
        measured_(measured) {
    set_num_residuals(2 * static_cast<int>(points_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(values_));
    mutable_parameter_block_sizes()->push_back(kPoseValues);
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    Lens lens = lens_;
    lens.SetValues(Eigen::Map<const Eigen::VectorXd>(parameters[0], values_));
    const BoardPose pose = PoseOf(parameters[1]);
    if (!(lens.fx > 0 && lens.fy > 0)) return false;
    MatrixXd by_lens;
    MatrixXd by_pose;
    const bool derive = jacobians != nullptr;
    const std::vector<cv::Point2d> modelled =
        Project(lens, pose, points_, derive ? &by_lens : nullptr, derive ? &by_pose : nullptr);
    for (std::size_t i = 0; i < modelled.size(); ++i) {
      residuals[2 * i] = modelled[i].x - measured_[i].x;
      residuals[2 * i + 1] = modelled[i].y - measured_[i].y;
      if (!std::isfinite(residuals[2 * i] + residuals[2 * i + 1])) return false;
    }
    if (derive) {
      Copy(by_lens, jacobians[0]);
      Copy(by_pose, jacobians[1]);
    }
    return true;
  }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static void Copy(const MatrixXd& from, double* to) {
    if (to != nullptr) Eigen::Map<RowMajor>(to, from.rows(), from.cols()) = from;
  }

  Lens lens_;  // its model; the values are the parameters
  Index values_;
  std::vector<cv::Point3d> points_;
  std::vector<cv::Point2d> measured_;
};

// A lens and the poses of some of the views.
struct CameraEstimate {
  Lens lens;
  std::vector<std::array<double, kPoseValues>> poses;
  double squares_px2 = std::numeric_limits<double>::infinity();  // sum of squared residuals
};

class Problem {
 public:
  Problem(const Board& board, const std::vector<BoardView>& views, cv::Size size, LensModel model)
      : board_(board), views_(views), size_(size), model_(model), used_(views.size(), true) {
    for (const BoardView& view : views) points_.push_back(BoardPoints(board, view));
  }

  void LeaveOut(std::size_t view) { used_[view] = false; }
  [[nodiscard]] bool IsUsed(std::size_t view) const { return used_[view]; }
  [[nodiscard]] std::size_t UsedCorners() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) count += used_[i] ? points_[i].size() : 0;
    return count;
  }

  [[nodiscard]] std::optional<CameraEstimate> Start() const;
  void Minimise(const std::vector<bool>& free, CameraEstimate& estimate) const;
  [[nodiscard]] CameraSolution Solution(const CameraEstimate& estimate,
                                        std::vector<bool> free) const;

 private:
  [[nodiscard]] std::vector<double> FocalGuesses() const;
  [[nodiscard]] std::optional<CameraEstimate> StartAt(double focal_px) const;
  void SetViews(const CameraEstimate& estimate, CameraSolution& solution) const;
  [[nodiscard]] MatrixXd Covariance(const CameraSolution& solution,
                                    const std::vector<bool>& free) const;

  const Board& board_;
  const std::vector<BoardView>& views_;
  cv::Size size_;
  LensModel model_;
  std::vector<bool> used_;
  std::vector<std::vector<cv::Point3d>> points_;
};

// Zhang's closed form for small distortion; and typical values of wide lenses.
std::vector<double> Problem::FocalGuesses() const {
  const double width_px = std::max(size_.width, size_.height);
  if (model_ == LensModel::kEquidistant)
    return {0.25 * width_px, 0.33 * width_px, 0.5 * width_px, width_px};
  std::vector<double> guesses = {0.4 * width_px, 0.7 * width_px, 1.2 * width_px, 2.5 * width_px};
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (!used_[i]) continue;
    points.emplace_back(points_[i].begin(), points_[i].end());
    pixels.emplace_back(views_[i].corners_px.begin(), views_[i].corners_px.end());
  }
  const cv::Mat K = cv::initCameraMatrix2D(points, pixels, size_, 1);
  const double focal_px = K.at<double>(0, 0);
  if (std::isfinite(focal_px) && focal_px > 0.1 * width_px && focal_px < 50 * width_px) {
    guesses.insert(guesses.begin(), focal_px);
  }
  return guesses;
}

std::optional<CameraEstimate> Problem::StartAt(double focal_px) const {
  CameraEstimate estimate{Lens::WithoutDistortion(model_, size_, focal_px), {}};
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const std::optional<BoardPose> pose = FindPose(estimate.lens, board_, views_[i]);
    if (!pose) return std::nullopt;
    const cv::Vec3d& r = pose->rotation;
    const cv::Vec3d& t = pose->translation;
    estimate.poses.push_back({r[0], r[1], r[2], t[0], t[1], t[2]});
  }
  return estimate;
}

// The best of the initial values, by residuals with free focal length and first coefficients.
std::optional<CameraEstimate> Problem::Start() const {
  std::optional<CameraEstimate> best;
  for (const double focal_px : FocalGuesses()) {
    std::optional<CameraEstimate> estimate = StartAt(focal_px);
    if (!estimate) continue;
    std::vector<bool> free(static_cast<std::size_t>(estimate->lens.Values().size()), false);
    std::fill_n(free.begin(), 6, true);
    Minimise(free, *estimate);
    if (!best || estimate->squares_px2 < best->squares_px2) best = std::move(estimate);
  }
  if (best && !std::isfinite(best->squares_px2)) return std::nullopt;
  return best;
}

void Problem::Minimise(const std::vector<bool>& free, CameraEstimate& estimate) const {
  ceres::Problem problem;
  Eigen::VectorXd solved = estimate.lens.Values();
  double* const values = solved.data();
  const auto count = static_cast<int>(solved.size());
  problem.AddParameterBlock(values, count);
  std::vector<int> fixed;
  for (int i = 0; i < count; ++i) {
    if (!free[static_cast<std::size_t>(i)]) fixed.push_back(i);
  }
  if (!fixed.empty()) problem.SetManifold(values, new ceres::SubsetManifold(count, fixed));
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (!used_[i]) continue;
    problem.AddResidualBlock(new ViewCost(estimate.lens, points_[i], views_[i].corners_px),
                             nullptr,
                             values,
                             estimate.poses[i].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  estimate.lens.SetValues(solved);
  estimate.squares_px2 =
      summary.IsSolutionUsable() ? 2 * summary.final_cost : std::numeric_limits<double>::infinity();
}

void Problem::SetViews(const CameraEstimate& estimate, CameraSolution& solution) const {
  for (std::size_t i = 0; i < views_.size(); ++i) {
    SolvedView& view = solution.views.emplace_back();
    view.view = i;
    view.used = used_[i];
    view.pose = PoseOf(estimate.poses[i].data());
    if (!view.used) {
      view.pose = FindPose(estimate.lens, board_, views_[i]).value_or(view.pose);
    }
    const std::vector<cv::Point2d> modelled = Project(estimate.lens, view.pose, points_[i]);
    double squares = 0;
    for (std::size_t k = 0; k < modelled.size(); ++k) {
      view.residuals_px.push_back(views_[i].corners_px[k] - modelled[k]);
      squares += view.residuals_px.back().ddot(view.residuals_px.back());
    }
    view.rms_px = std::sqrt(squares / static_cast<double>(modelled.size()));
    cv::Matx33d R;
    cv::Rodrigues(view.pose.rotation, R);
    view.tilt_rad = std::acos(std::min(1.0, std::abs(R(2, 2))));
  }
}

MatrixXd Problem::Covariance(const CameraSolution& solution, const std::vector<bool>& free) const {
  std::vector<FittedView> fitted;
  for (const SolvedView& view : solution.views) {
    if (view.used) fitted.push_back({view.pose, &points_[view.view], &view.residuals_px});
  }
  return LensCovariance(solution.lens, fitted, free);
}

CameraSolution Problem::Solution(const CameraEstimate& estimate, std::vector<bool> free) const {
  CameraSolution solution;
  solution.lens = estimate.lens;
  solution.free = std::move(free);
  solution.corners = UsedCorners();
  solution.rms_px = std::sqrt(estimate.squares_px2 / static_cast<double>(solution.corners));
  SetViews(estimate, solution);
  std::vector<bool> open = solution.free;
  std::fill_n(open.begin(), kPinholeValues + OpenTerms(model_), true);
  solution.covariance = Covariance(solution, open);
  return solution;
}

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

std::optional<CameraSolution> SolveOnce(const Problem& problem, const SolverParams& params) {
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
  Problem problem(board, views, size, params.model);
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
