#include "calib/solve/camera_problem.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "calib/solve/board_pose.hpp"
#include "calib/solve/lens_covariance.hpp"

namespace ceilmap::calibration {
namespace {

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

}  // namespace

CameraProblem::CameraProblem(const Board& board,
                             const std::vector<BoardView>& views,
                             cv::Size size,
                             LensModel model)
    : board_(board), views_(views), size_(size), model_(model), used_(views.size(), true) {
  points_.reserve(views.size());
  for (const BoardView& view : views) points_.push_back(BoardPoints(board, view));
}

std::size_t CameraProblem::UsedCorners() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < views_.size(); ++i) count += used_[i] ? points_[i].size() : 0;
  return count;
}

// Zhang's closed form for small distortion; and typical values of wide lenses.
std::vector<double> CameraProblem::FocalGuesses() const {
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

std::optional<CameraEstimate> CameraProblem::StartAt(double focal_px) const {
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
std::optional<CameraEstimate> CameraProblem::Start() const {
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

void CameraProblem::Minimise(const std::vector<bool>& free, CameraEstimate& estimate) const {
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

void CameraProblem::SetViews(const CameraEstimate& estimate, CameraSolution& solution) const {
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

MatrixXd CameraProblem::Covariance(const CameraSolution& solution,
                                   const std::vector<bool>& free) const {
  std::vector<FittedView> fitted;
  for (const SolvedView& view : solution.views) {
    if (view.used) fitted.push_back({view.pose, &points_[view.view], &view.residuals_px});
  }
  return LensCovariance(solution.lens, fitted, free);
}

CameraSolution CameraProblem::Solution(const CameraEstimate& estimate,
                                       std::vector<bool> free) const {
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

}  // namespace ceilmap::calibration
