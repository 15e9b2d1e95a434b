#include "calib/solve/drive_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "calib/ceiling_view.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct HeightPrior {
  double rho = 1;

  template <typename T>
  bool operator()(const T* height, T* residual) const {
    residual[0] = (height[0] - rho) / kHeightSigma;
    return true;
  }
};

struct PriorResidual {
  std::array<double, kCameraErrors> at;

  template <typename T>
  bool operator()(const T* errors, T* residual) const {
    for (std::size_t i = 0; i < at.size(); ++i) residual[i] = (errors[i] - at[i]) / kPriorSigma[i];
    return true;
  }
};

// Prepares the rays of a camera.
class LevelRays {
 public:
  explicit LevelRays(const calib::MountedCamera& up)
      : lens_(up.camera),
        focal_px_(std::sqrt(up.camera.fx * up.camera.fy)),
        // The axes of a level camera that is rotated about z like the mounted one.
        R_level_cam_(calib::CeilingView(up, up.T_base_cam.translation().z() + 1)
                         .T_base_camera()
                         .linear()
                         .transpose() *
                     up.T_base_cam.linear()) {}

  [[nodiscard]] std::optional<Vector2d> PixelOf(const Vector2d& ray) const {
    return lens_.Project(ray.homogeneous());
  }
  [[nodiscard]] double RadiusPx(const Vector2d& pixel) const {
    return focal_px_ * Normalized(pixel).norm();
  }
  [[nodiscard]] std::optional<LevelRay> Prepare(const Vector2d& ray, double edge_px) const {
    const std::optional<Vector2d> pixel = PixelOf(ray);
    if (!pixel) return std::nullopt;
    LevelRay sight;
    sight.slope = SlopeOf(ray.homogeneous());
    const double radius_px = RadiusPx(*pixel);
    constexpr double kStepPx = 0.5;
    if (radius_px < 2 * kStepPx) return sight;  // at the centre nothing changes
    const Vector2d out = Normalized(*pixel).normalized() * kStepPx / focal_px_;
    const Vector2d step(out.x() * lens_.fx, out.y() * lens_.fy);
    const std::optional<Vector3d> inner = lens_.Ray(*pixel - step);
    const std::optional<Vector3d> outer = lens_.Ray(*pixel + step);
    if (!inner || !outer) return std::nullopt;
    const Vector2d by_radius = (SlopeOf(*outer) - SlopeOf(*inner)) / (2 * kStepPx);
    const double ratio = radius_px / edge_px;
    sight.by_lens.col(0) = -radius_px * by_radius;
    sight.by_lens.col(1) = std::pow(ratio, 3) * by_radius;
    sight.by_lens.col(2) = std::pow(ratio, 5) * by_radius;
    return sight;
  }

 private:
  [[nodiscard]] Vector2d Normalized(const Vector2d& pixel) const {
    return {(pixel.x() - lens_.cx) / lens_.fx, (pixel.y() - lens_.cy) / lens_.fy};
  }
  [[nodiscard]] Vector2d SlopeOf(const Vector3d& p_cam) const {
    return (R_level_cam_ * p_cam).hnormalized();
  }

  const calib::Lens& lens_;
  double focal_px_;
  Eigen::Matrix3d R_level_cam_;
};

double EdgePx(const LevelRays& sights, const Drive& drive) {
  double edge_px = 1;
  for (const ViewPair& pair : drive.pairs) {
    for (const PointCorrespondence& place : pair.places) {
      for (const Vector2d& ray : {place.first, place.second}) {
        if (const auto pixel = sights.PixelOf(ray)) {
          edge_px = std::max(edge_px, sights.RadiusPx(*pixel));
        }
      }
    }
  }
  return edge_px;
}

// Of an error in units of Z. Where the ceiling has depth, and the heights are no unknowns, a
// point's place along the travel counts nearly nothing: heights belong to places, so that their
// errors do not average out.
Matrix2d WeightOf(const DrivePoint& point,
                  const DriveParameters& parameters,
                  double focal_px,
                  const DriveScales& scales) {
  Matrix2d measured = focal_px / scales.place_px * point.whitening;
  if (scales.depth_ratio <= 0 || point.height >= 0) return measured;
  constexpr double kDepthSigmas = 20;
  const auto& first = parameters.cameras[static_cast<std::size_t>(point.first)];
  const auto& second = parameters.cameras[static_cast<std::size_t>(point.second)];
  const double size = 1 / (1 - parameters.errors[kCameraFocal]);  // as that of the errors
  const Vector2d travel =
      size * kDepthSigmas * scales.depth_ratio *
      (Eigen::Rotation2Dd(-first[2]) * Vector2d(second[0] - first[0], second[1] - first[1]));
  const Matrix2d information = measured.transpose() * measured;
  // Sherman and Morrison: (C + t t')^-1.
  const Vector2d pulled = information * travel;
  const Matrix2d reduced = information - pulled * pulled.transpose() / (1 + travel.dot(pulled)) +
                           1e-9 * Matrix2d::Identity();
  return Eigen::LLT<Matrix2d>(reduced).matrixU();
}

}  // namespace

std::vector<DrivePoint> PreparePoints(const calib::MountedCamera& up,
                                      const Drive& drive,
                                      double& edge_px,
                                      std::vector<KnownHeight>* heights) {
  const LevelRays sights(up);
  edge_px = EdgePx(sights, drive);
  std::vector<DrivePoint> points;
  std::map<std::pair<int, int>, int> height_of;  // view and index
  for (const ViewPair& pair : drive.pairs) {
    for (const PointCorrespondence& place : pair.places) {
      auto first = sights.Prepare(place.first, edge_px);
      auto second = sights.Prepare(place.second, edge_px);
      if (!first || !second) continue;
      first->row = place.first_row;
      first->velocity = drive.velocities[static_cast<std::size_t>(pair.first)];
      second->row = place.second_row;
      second->velocity = drive.velocities[static_cast<std::size_t>(pair.second)];
      points.push_back({pair.first, pair.second, *first, *second, place.whitening});
      if (heights == nullptr || place.index < 0) continue;
      const auto [height, is_new] =
          height_of.try_emplace({pair.first, place.index}, static_cast<int>(heights->size()));
      if (is_new) heights->push_back({pair.first, place.index, place.rho});
      points.back().height = height->second;
    }
  }
  return points;
}

Vector2d DriveError(const DriveParameters& parameters, const DrivePoint& point) {
  const bool in_plane = point.height < 0;
  return DriveErrorAt(
      in_plane ? 1 : parameters.heights[static_cast<std::size_t>(point.height)], parameters, point);
}

Vector2d DriveErrorAt(double rho, const DriveParameters& parameters, const DrivePoint& point) {
  return ErrorOf(point,
                 {parameters.errors.data(),
                  parameters.cameras[static_cast<std::size_t>(point.first)].data(),
                  parameters.cameras[static_cast<std::size_t>(point.second)].data(),
                  rho},
                 nullptr);
}

DriveProblem::DriveProblem(const std::vector<DrivePoint>& points,
                           const Drive& drive,
                           double focal_px,
                           const DriveScales& scales,
                           const DriveUnknowns& params,
                           const std::vector<KnownHeight>& known_heights,
                           DriveParameters& parameters) {
  for (const DrivePoint& point : points) {
    ceres::CostFunction* const cost =
        NewPointCost(point, WeightOf(point, parameters, focal_px, scales));
    std::vector<double*> of{parameters.errors.data(),
                            parameters.cameras[static_cast<std::size_t>(point.first)].data(),
                            parameters.cameras[static_cast<std::size_t>(point.second)].data()};
    if (point.height >= 0) {
      of.push_back(&parameters.heights[static_cast<std::size_t>(point.height)]);
    }
    const auto id = problem.AddResidualBlock(cost, new ceres::CauchyLoss(kCauchy), of);
    owners.push_back({id, point.first, point.second, true});
  }
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<PriorResidual, kCameraErrors, kCameraErrors>(
          new PriorResidual{{0, 0, 0, 0, 0, parameters.errors[kCameraReadout]}}),
      nullptr,
      parameters.errors.data());
  std::vector<int> fixed;
  const auto estimate = [&](int value, bool asked) {
    (asked ? estimated : fixed).push_back(value);
  };
  estimate(kCameraTiltX, true);
  estimate(kCameraTiltY, true);
  estimate(kCameraFocal, params.focal);
  estimate(kCameraRadial3, params.radial);
  estimate(kCameraRadial5, params.radial);
  estimate(kCameraReadout, params.readout);
  if (!fixed.empty()) {
    problem.SetManifold(parameters.errors.data(), new ceres::SubsetManifold(kCameraErrors, fixed));
  }
  blocks.push_back(parameters.errors.data());
  for (std::size_t i = 0; i < parameters.cameras.size(); ++i) {
    double* const camera = parameters.cameras[i].data();
    if (!problem.HasParameterBlock(camera)) continue;
    if (std::find(drive.starts.begin(), drive.starts.end(), i) != drive.starts.end()) {
      problem.SetParameterBlockConstant(camera);
    } else {
      blocks.push_back(camera);
    }
  }
  AddHeights(known_heights, parameters);
}

void DriveProblem::AddHeights(const std::vector<KnownHeight>& known, DriveParameters& parameters) {
  for (std::size_t i = 0; i < known.size(); ++i) {
    double* const height = &parameters.heights[i];
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<HeightPrior, 1, 1>(new HeightPrior{known[i].rho}),
        nullptr,
        height);
    blocks.push_back(height);
  }
  heights = static_cast<int>(known.size());
}

}  // namespace ceilmap::calibration
