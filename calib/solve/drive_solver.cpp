#include "calib/solve/drive_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/statistics.hpp"
#include "calib/solve/drive_covariance.hpp"
#include "calib/solve/drive_problem.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr double kMinRaySigmaPx = 0.005;
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
  constexpr double kMinTravel = 0.05;  // of Z; less shows no heights
  constexpr double kMinDepth = 0.003;  // fixtures close to a plane ceiling
  std::vector<double> across_px;
  std::vector<double> along;
  for (const DrivePoint& point : points) {
    const Vector2d error = DriveError(parameters, point);
    const Vector2d weighted = focal_px * point.whitening * error;
    const Vector2d travel = TravelBetween(parameters, point);
    const double length = travel.norm();
    if (length < kMinTravel) {
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
  scales.place_px = std::max(kMinRaySigmaPx, Median(across_px) / kMedianOfAxis);
  if (!parameters.heights.empty()) {
    along.clear();
    for (const double rho : parameters.heights) along.push_back(std::abs(rho - 1));
  }
  if (!along.empty()) {
    const double depth = Median(along) / kMedianOfAxis;
    if (depth > kMinDepth) scales.depth_ratio = depth;
  }
  return scales;
}

// The heights that the pairs of each point show under rough poses: their weighted median.
void StartHeights(const std::vector<DrivePoint>& points,
                  const std::vector<KnownHeight>& known,
                  DriveParameters& parameters) {
  std::vector<std::vector<std::pair<double, double>>> seen(known.size());  // rho, weight
  for (const DrivePoint& point : points) {
    if (point.height < 0) continue;
    const Vector2d still = point.whitening * DriveErrorAt(0, parameters, point);
    const Vector2d moved = point.whitening * DriveErrorAt(1, parameters, point) - still;
    if (moved.norm() <= 0) continue;
    seen[static_cast<std::size_t>(point.height)].emplace_back(
        -moved.dot(still) / moved.squaredNorm(), moved.norm());
  }
  for (std::size_t i = 0; i < known.size(); ++i) {
    double half = 0;
    for (const auto& [rho, weight] : seen[i]) half += 0.5 * weight;
    std::sort(seen[i].begin(), seen[i].end());
    double sum = 0;
    double start = known[i].rho;
    for (const auto& [rho, weight] : seen[i]) {
      sum += weight;
      if (sum < half) continue;
      start = rho;
      break;
    }
    constexpr double kFarthest = 0.5;
    constexpr double kNearest = 4;
    parameters.heights.push_back(std::clamp(start, kFarthest, kNearest));
  }
}

DriveParameters StartOf(const calib::MountedCamera& up, const Drive& drive) {
  DriveParameters parameters;
  parameters.errors[kCameraReadout] = up.readout_time_s;
  for (const Pose2& camera : drive.cameras) {
    parameters.cameras.push_back({camera.x, camera.y, camera.yaw});
  }
  return parameters;
}

std::vector<PointHeight> DescribeHeights(const std::vector<DrivePoint>& points,
                                         const std::vector<KnownHeight>& known,
                                         const DriveParameters& parameters,
                                         double focal_px,
                                         double sigma_px) {
  std::vector<double> information(known.size(), 1 / (kHeightSigma * kHeightSigma));
  for (const DrivePoint& point : points) {
    if (point.height < 0) continue;
    const Vector2d by_height =
        focal_px * point.whitening *
        (DriveErrorAt(1, parameters, point) - DriveErrorAt(0, parameters, point));
    information[static_cast<std::size_t>(point.height)] +=
        by_height.squaredNorm() / (sigma_px * sigma_px);
  }
  std::vector<PointHeight> heights;
  for (std::size_t i = 0; i < known.size(); ++i) {
    heights.push_back(
        {known[i].view, known[i].index, parameters.heights[i], 1 / std::sqrt(information[i])});
  }
  return heights;
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
  std::vector<KnownHeight> heights;
  const std::vector<DrivePoint> points =
      PreparePoints(up, drive, solution.edge_px, params.heights ? &heights : nullptr);
  if (drive.cameras.size() < 3 || points.empty()) return solution;
  DriveParameters parameters = StartOf(up, drive);
  StartHeights(points, heights, parameters);
  DriveScales scales = EstimateScales(points, parameters, focal_px);
  scales.depth_ratio = 0;  // until the poses are better than rough
  constexpr int kRounds = 4;
  constexpr int kIterations = 30;  // of a round, at most
  for (int round = 0; round < kRounds; ++round) {
    DriveProblem problem(points, drive, focal_px, scales, params, heights, parameters);
    if (!Minimise(problem, kIterations)) return solution;
    if (round + 1 == kRounds) {
      const MatrixXd covariance = DriveCovariance(problem, drive.cameras.size());
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
  solution.heights = DescribeHeights(points, heights, parameters, focal_px, scales.place_px);
  solution.ok = solution.covariance.allFinite();
  return solution;
}

std::vector<PointHeight> HeightsOf(const calib::MountedCamera& up,
                                   const Drive& drive,
                                   const DriveSolution& solution) {
  double edge_px = 0;
  std::vector<KnownHeight> known;
  const std::vector<DrivePoint> points = PreparePoints(up, drive, edge_px, &known);
  DriveParameters parameters;
  for (int i = 0; i < kCameraErrors; ++i) {
    parameters.errors[static_cast<std::size_t>(i)] = solution.errors[i];
  }
  for (const Pose2& camera : solution.cameras) {
    parameters.cameras.push_back({camera.x, camera.y, camera.yaw});
  }
  StartHeights(points, known, parameters);
  const double focal_px = std::sqrt(up.camera.fx * up.camera.fy);
  return DescribeHeights(points, known, parameters, focal_px, solution.sigma_px);
}

}  // namespace ceilmap::calibration
