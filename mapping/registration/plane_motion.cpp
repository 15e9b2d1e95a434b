#include "mapping/registration/plane_motion.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace ceilmap::registration {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Parameters = std::array<double, 6>;  // x, y, height, yaw, tilt_x, tilt_y

// Current image position of a reference pixel; the point lies at distance 1 / rho.
template <typename T>
Eigen::Matrix<T, 2, 1> Project(const PlaneCamera& camera,
                               const T* p,
                               const Eigen::Vector2d& x,
                               double rho = 1) {
  using std::cos;
  using std::sin;
  const Eigen::Vector2d ray = (x - camera.principal_px) / camera.focal_px;
  const T dx = T(ray.x()) - rho * p[0];
  const T dy = T(ray.y()) - rho * p[1];
  const T dz = T(1.0) - rho * p[2];
  // R' = Rx(-tilt_x) Ry(-tilt_y) Rz(-yaw), one after another.
  const T ax = cos(p[3]) * dx + sin(p[3]) * dy;
  const T ay = -sin(p[3]) * dx + cos(p[3]) * dy;
  const T bx = cos(p[5]) * ax - sin(p[5]) * dz;
  const T bz = sin(p[5]) * ax + cos(p[5]) * dz;
  const T cy = cos(p[4]) * ay + sin(p[4]) * bz;
  const T cz = -sin(p[4]) * ay + cos(p[4]) * bz;
  return {camera.focal_px * bx / cz + camera.principal_px.x(),
          camera.focal_px * cy / cz + camera.principal_px.y()};
}

Parameters ToArray(const PlaneMotion& m) {
  return {m.x, m.y, m.height, m.yaw, m.tilt_x, m.tilt_y};
}

PlaneMotion FromArray(const Parameters& p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

// Residual of a block in reference pixels, weighted by its accuracy.
struct BlockResidual {
  const PlaneCamera* camera;
  const PlaneShift* shift;
  Eigen::Matrix2d whitening;

  template <typename T>
  bool operator()(const T* const p, T* residual) const {
    const Eigen::Matrix<T, 2, 1> error =
        Project(*camera, p, shift->block.point) - shift->seen.cast<T>();
    const Eigen::Matrix<T, 2, 1> weighted = whitening.cast<T>() * error;
    residual[0] = weighted[0];
    residual[1] = weighted[1];
    return true;
  }
};

Eigen::Matrix2d Whitening(const PlaneShift& shift) {
  // W'W = quality * sharpness, transformed to the current image by the local linear part.
  const Eigen::Matrix2d information = shift.block.quality * shift.block.sharpness;
  const Eigen::LLT<Eigen::Matrix2d> llt(information + 1e-9 * Eigen::Matrix2d::Identity());
  return llt.matrixU().toDenseMatrix() * shift.current_from_reference.inverse();
}

}  // namespace

PlaneCamera PlaneCameraOf(const calib::CeilingView& view) {
  const cv::Size size = view.Size();
  const Eigen::Vector2d centre(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  return {view.FocalLength(), view.PrincipalPoint() - centre};
}

TiltAngles TiltOf(const PlaneFit& fit, const calib::CeilingView& view) {
  // Small rotations about x and y of the camera are rotations about x and y of base, rotated by the
  // camera's yaw. (roll, pitch) there, (pitch, roll) here.
  const Eigen::Matrix2d turn = view.T_base_camera().linear().topLeftCorner<2, 2>();
  const Eigen::Vector2d about = turn * Eigen::Vector2d(fit.motion.tilt_x, fit.motion.tilt_y);
  const Eigen::Matrix2d spread = turn * fit.covariance.bottomRightCorner<2, 2>() * turn.transpose();
  TiltAngles tilt;
  tilt.angles << about.y(), about.x();
  tilt.covariance << spread(1, 1), spread(1, 0), spread(0, 1), spread(0, 0);
  return tilt;
}

Eigen::Vector2d PlaneMotion::Apply(const PlaneCamera& camera,
                                   const Eigen::Vector2d& at,
                                   double rho) const {
  const Parameters p = ToArray(*this);
  return Project(camera, p.data(), at, rho);
}

Eigen::Matrix2d PlaneMotion::Jacobian(const PlaneCamera& camera,
                                      const Eigen::Vector2d& at,
                                      double rho) const {
  const double h = 1e-3;
  const auto moved = [&](double du, double dv) {
    return Apply(camera, at + Eigen::Vector2d(du, dv), rho);
  };
  Eigen::Matrix2d j;
  j.col(0) = (moved(h, 0) - moved(-h, 0)) / (2 * h);
  j.col(1) = (moved(0, h) - moved(0, -h)) / (2 * h);
  return j;
}

PlaneMotion PlaneMotion::FromSimilarity(const PlaneCamera& camera, const ImageMotion& motion) {
  // x_cur = s R(theta) x_ref + t about the centre; without tilt the model gives
  // x_cur - pp = f Rz(-yaw) ((x_ref - pp) / f - (x, y)) / (1 - height).
  PlaneMotion plane;
  plane.yaw = -motion.theta_rad;
  plane.height = 1 - 1 / motion.scale;
  const Eigen::Vector2d pp = camera.principal_px;
  const Eigen::Vector2d centre_ray = (motion.Apply(pp) - pp) / (camera.focal_px * motion.scale);
  const double c = std::cos(motion.theta_rad);
  const double s = std::sin(motion.theta_rad);
  plane.x = -(c * centre_ray.x() + s * centre_ray.y());
  plane.y = -(-s * centre_ray.x() + c * centre_ray.y());
  return plane;
}

ImageMotion PlaneMotion::ToSimilarity(const PlaneCamera& camera) const {
  PlaneMotion level = *this;
  level.tilt_x = 0;
  level.tilt_y = 0;
  const Eigen::Vector2d t = level.Apply(camera, Eigen::Vector2d::Zero());
  return {t.x(), t.y(), -yaw, 1 / (1 - height)};
}

namespace {

/// The problem of one fit: built once, solved with a changing scale of the loss.
class PlaneProblem {
 public:
  PlaneProblem(const PlaneCamera& camera,
               const std::vector<PlaneShift>& shifts,
               const PlaneMotion& start,
               const PlaneFitParams& params)
      : parameters_(ToArray(start)), loss_(nullptr, ceres::TAKE_OWNERSHIP) {
    residuals_.reserve(shifts.size());
    for (const PlaneShift& shift : shifts) {
      residuals_.push_back({&camera, &shift, Whitening(shift)});
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<BlockResidual, 2, 6>(
                                    &residuals_.back(), ceres::DO_NOT_TAKE_OWNERSHIP),
                                &loss_,
                                parameters_.data());
    }
    std::vector<int> held;
    if (!params.fit_height) held.push_back(2);
    if (!params.fit_tilt) held.insert(held.end(), {4, 5});
    if (!held.empty()) problem_.SetManifold(parameters_.data(), new ceres::SubsetManifold(6, held));
  }

  /// The robust standard deviation of a whitened residual's axis, at least kSigmaFloorPx.
  double Scale() {
    sizes_.clear();
    for (const BlockResidual& residual : residuals_) {
      Eigen::Vector2d whitened;
      residual(parameters_.data(), whitened.data());
      sizes_.push_back(whitened.norm());
    }
    const auto middle = sizes_.begin() + static_cast<std::ptrdiff_t>(sizes_.size() / 2);
    std::nth_element(sizes_.begin(), middle, sizes_.end());
    return std::max(kSigmaFloorPx, *middle / 1.1774);
  }

  bool Solve(double sigma_px) {
    // The scale belongs to the squared residual norm: Cauchy's 2.3849 sigma keeps 95 % efficiency.
    loss_.Reset(new ceres::CauchyLoss(2.3849 * sigma_px), ceres::TAKE_OWNERSHIP);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 20;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  /// For a standard deviation of one; nothing when it cannot be computed.
  std::optional<Matrix6d> Covariance() {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::DENSE_SVD;
    // Undetermined parameters result in a very large variance, without a message on stderr.
    options.min_reciprocal_condition_number = 0;
    ceres::Covariance covariance(options);
    const std::vector<const double*> blocks{parameters_.data()};
    if (!covariance.Compute(blocks, &problem_)) return std::nullopt;
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> unscaled;
    covariance.GetCovarianceBlock(parameters_.data(), parameters_.data(), unscaled.data());
    return unscaled;
  }

  [[nodiscard]] const Parameters& At() const { return parameters_; }

 private:
  static ceres::Problem::Options Options() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  Parameters parameters_;
  std::vector<BlockResidual> residuals_;
  std::vector<double> sizes_;
  ceres::LossFunctionWrapper loss_;
  ceres::Problem problem_{Options()};
};

}  // namespace

PlaneFit FitPlaneMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const PlaneFitParams& params,
                        bool with_covariance) {
  PlaneFit fit;
  fit.motion = start;
  fit.blocks = static_cast<int>(shifts.size());
  if (shifts.size() < 6) return fit;
  PlaneProblem problem(camera, shifts, start, params);
  constexpr int kScales = 3;
  for (int round = 0; round < kScales; ++round) {
    if (!problem.Solve(problem.Scale())) return fit;
  }
  fit.sigma_px = problem.Scale();
  if (with_covariance) {
    const auto unscaled = problem.Covariance();
    if (!unscaled) return fit;
    fit.covariance = fit.sigma_px * fit.sigma_px * *unscaled;
    if (!fit.covariance.allFinite()) return fit;
  }
  fit.motion = FromArray(problem.At());
  for (const PlaneShift& shift : shifts) {
    const Eigen::Vector2d error = fit.motion.Apply(camera, shift.block.point) - shift.seen;
    const Eigen::Vector2d in_reference = shift.current_from_reference.inverse() * error;
    fit.inliers += in_reference.dot(shift.block.sharpness * in_reference) < 1 ? 1 : 0;
  }
  fit.ok = true;
  return fit;
}

}  // namespace ceilmap::registration
