#include "calib/solve/drive_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/base/statistics.hpp"
#include "calib/solve/drive_problem.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double kLeastSigmaPx = 0.005;
constexpr double kMedianOfAxis = 0.6745;  // of the size of a normal error in one axis

Vector2d TravelBetween(const DriveParameters& parameters, const DrivePoint& point) {
  const auto& first = parameters.cameras[static_cast<std::size_t>(point.first)];
  const auto& second = parameters.cameras[static_cast<std::size_t>(point.second)];
  const double size = 1 / (1 - parameters.errors[kCameraFocal]);  // as that of the errors
  return size *
         (Pose2{0, 0, -first[2]}.Rotation() * Vector2d(second[0] - first[0], second[1] - first[1]));
}

// The noise from the errors across the direction of travel, which heights do not change; the depth
// from those along it.
DriveScales EstimateScales(const std::vector<DrivePoint>& points,
                           const DriveParameters& parameters,
                           double focal_px) {
  constexpr double kLeastTravel = 0.05;  // of Z; less shows no heights
  constexpr double kLeastDepth = 0.003;  // fixtures close to a plane ceiling
  std::vector<double> across_px;
  std::vector<double> along;
  for (const DrivePoint& point : points) {
    const Vector2d error = DriveError(parameters, point);
    const Vector2d weighted = focal_px * point.whitening * error;
    const Vector2d travel = TravelBetween(parameters, point);
    const double length = travel.norm();
    if (length < kLeastTravel) {
      across_px.push_back(std::abs(weighted.x()));
      across_px.push_back(std::abs(weighted.y()));
      continue;
    }
    const Vector2d direction = travel / length;
    const Vector2d side(-direction.y(), direction.x());
    // The part of the weighted error that a step along the travel cannot remove.
    const Vector2d removable = (point.whitening * direction).normalized();
    const Vector2d left = weighted - removable * removable.dot(weighted);
    across_px.push_back(left.norm());
    along.push_back(std::abs(direction.dot(error)) / length);
  }
  DriveScales scales;
  scales.place_px = std::max(kLeastSigmaPx, Median(across_px) / kMedianOfAxis);
  if (!along.empty()) {
    const double depth = Median(along) / kMedianOfAxis;
    if (depth > kLeastDepth) scales.depth_ratio = depth;
  }
  return scales;
}

bool Minimize(DriveProblem& problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 30;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem.problem, &summary);
  return summary.IsSolutionUsable();
}

// Contribution of the points to the normal equations, and of the pairs to the covariance.
class DriveCovariance {
 public:
  static constexpr int kTimes = 8;  // parts of the drive with independent errors

  explicit DriveCovariance(DriveProblem& problem) : problem_(problem) {
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    options.parameter_blocks = problem.blocks;
    for (const BlockOwner& owner : problem.owners) options.residual_blocks.push_back(owner.id);
    problem.problem.Evaluate(options, nullptr, &residuals_, nullptr, &jacobian_);
  }

  // Of the estimated errors, which are the first columns.
  MatrixXd Compute(std::size_t views) const {
    const int n = jacobian_.num_cols;
    const auto asked = static_cast<Eigen::Index>(problem_.estimated.size());
    MatrixXd normal = 1e-9 * MatrixXd::Identity(n, n);
    for (Eigen::Index k = 0; k < asked; ++k) {
      const int value = problem_.estimated[static_cast<std::size_t>(k)];
      normal(k, k) += 1 / (kPriorSigma[Index(value)] * kPriorSigma[Index(value)]);
    }
    for (std::size_t i = 0; i < problem_.owners.size(); ++i) {
      const double weight = WeightOfBlock(i);
      ForRows(i, [&](int row) { AddSquare(row, weight, normal); });
    }
    const Eigen::LDLT<MatrixXd> solver(normal);
    const MatrixXd influence = solver.solve(MatrixXd::Identity(n, asked));
    MatrixXd of_view = MatrixXd::Zero(asked, static_cast<Eigen::Index>(views));
    MatrixXd of_time = MatrixXd::Zero(asked, kTimes);
    MatrixXd of_pair = MatrixXd::Zero(asked, 1);
    MatrixXd pairs = MatrixXd::Zero(asked, asked);
    for (std::size_t i = 0; i < problem_.owners.size(); ++i) {
      const BlockOwner& owner = problem_.owners[i];
      const double weight = WeightOfBlock(i);
      ForRows(i, [&](int row) {
        for (int k = jacobian_.rows[Index(row)]; k < jacobian_.rows[Index(row + 1)]; ++k) {
          of_pair += weight * residuals_[Index(row)] * jacobian_.values[Index(k)] *
                     influence.row(jacobian_.cols[Index(k)]).transpose();
        }
      });
      const bool last = i + 1 == problem_.owners.size() ||
                        problem_.owners[i + 1].first != owner.first ||
                        problem_.owners[i + 1].second != owner.second;
      if (!last) continue;
      of_view.col(owner.first) += of_pair;
      of_view.col(owner.second) += of_pair;
      of_time.col((owner.first + owner.second) * kTimes / (2 * static_cast<int>(views))) += of_pair;
      pairs += of_pair * of_pair.transpose();
      of_pair.setZero();
    }
    MatrixXd covariance = of_view * of_view.transpose() - pairs;
    // Errors that belong to a part of the ceiling are common to all views of it.
    Raise(of_time * of_time.transpose() * (static_cast<double>(kTimes) / (kTimes - 1)), covariance);
    // Values that are not seen have the variance of the curvature.
    Raise(influence.topRows(asked), covariance);
    return covariance;
  }

 private:
  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }
  // Raises variances to those of another estimate where that is larger.
  static void Raise(const MatrixXd& other, MatrixXd& covariance) {
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      const double least = std::max(other(i, i), 1e-300);
      if (covariance(i, i) <= 0) {
        covariance.row(i).setZero();
        covariance.col(i).setZero();
        covariance(i, i) = least;
      } else if (covariance(i, i) < least) {
        const double factor = std::sqrt(least / covariance(i, i));
        covariance.row(i) *= factor;
        covariance.col(i) *= factor;
      }
    }
  }
  void ForRows(std::size_t block, auto&& use) const {
    use(static_cast<int>(2 * block));
    use(static_cast<int>(2 * block) + 1);
  }
  [[nodiscard]] double WeightOfBlock(std::size_t block) const {
    const double x = residuals_[2 * block];
    const double y = residuals_[2 * block + 1];
    return 1 / (1 + (x * x + y * y) / (kCauchy * kCauchy));
  }
  void AddSquare(int row, double weight, MatrixXd& normal) const {
    const int begin = jacobian_.rows[Index(row)];
    const int end = jacobian_.rows[Index(row + 1)];
    for (int i = begin; i < end; ++i) {
      for (int j = begin; j < end; ++j) {
        normal(jacobian_.cols[Index(i)], jacobian_.cols[Index(j)]) +=
            weight * jacobian_.values[Index(i)] * jacobian_.values[Index(j)];
      }
    }
  }

  DriveProblem& problem_;
  std::vector<double> residuals_;
  ceres::CRSMatrix jacobian_;
};

DriveParameters StartOf(const calib::MountedCamera& up, const Drive& drive) {
  DriveParameters parameters;
  parameters.errors[kCameraReadout] = up.readout_time_s;
  for (const Pose2& camera : drive.cameras) {
    parameters.cameras.push_back({camera.x, camera.y, camera.yaw});
  }
  return parameters;
}

void Describe(const std::vector<DrivePoint>& points,
              const DriveParameters& parameters,
              double focal_px,
              const DriveScales& scales,
              DriveSolution& solution) {
  for (int i = 0; i < kCameraErrors; ++i) {
    solution.errors[i] = parameters.errors[static_cast<std::size_t>(i)];
  }
  for (const auto& camera : parameters.cameras) {
    solution.cameras.push_back({camera[0], camera[1], WrapAngle(camera[2])});
  }
  solution.sigma_px = scales.place_px;
  solution.depth_ratio = scales.depth_ratio;
  solution.places = static_cast<int>(points.size());
  solution.view_errors.resize(parameters.cameras.size());
  for (const DrivePoint& point : points) {
    const double error_px = (focal_px * point.whitening * DriveError(parameters, point)).norm();
    if (error_px < 3 * scales.place_px) ++solution.inliers;
    for (const int view : {point.first, point.second}) {
      ViewError& error = solution.view_errors[static_cast<std::size_t>(view)];
      error.rms_px += error_px * error_px;
      ++error.places;
    }
  }
  for (ViewError& error : solution.view_errors) {
    if (error.places > 0) error.rms_px = std::sqrt(0.5 * error.rms_px / error.places);
  }
}

}  // namespace

DriveSolution SolveDrive(const calib::MountedCamera& up,
                         const Drive& drive,
                         const DriveUnknowns& params) {
  DriveSolution solution;
  const double focal_px = std::sqrt(up.camera.fx * up.camera.fy);
  const std::vector<DrivePoint> points = PreparePoints(up, drive, solution.edge_px);
  if (drive.cameras.size() < 3 || points.empty()) return solution;
  DriveParameters parameters = StartOf(up, drive);
  DriveScales scales = EstimateScales(points, parameters, focal_px);
  scales.depth_ratio = 0;  // until the poses are better than rough
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    DriveProblem problem(points, drive, focal_px, scales, params, parameters);
    if (!Minimize(problem)) return solution;
    if (round + 1 == kRounds) {
      const MatrixXd covariance = DriveCovariance(problem).Compute(drive.cameras.size());
      for (std::size_t i = 0; i < problem.estimated.size(); ++i) {
        for (std::size_t j = 0; j < problem.estimated.size(); ++j) {
          solution.covariance(problem.estimated[i], problem.estimated[j]) =
              covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
      break;
    }
    scales = EstimateScales(points, parameters, focal_px);
  }
  Describe(points, parameters, focal_px, scales, solution);
  solution.ok = solution.covariance.allFinite();
  return solution;
}

}  // namespace ceilmap::calibration
