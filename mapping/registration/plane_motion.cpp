#include "mapping/registration/plane_motion.hpp"

#include <ceres/jet.h>
#include <ceres/tiny_solver.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/statistics.hpp"
#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/plane_projection.hpp"

namespace ceilmap::registration {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Parameters = std::array<double, 6>;  // x, y, height, yaw, tilt_x, tilt_y

Parameters ToArray(const PlaneMotion& m) {
  return {m.x, m.y, m.height, m.yaw, m.tilt_x, m.tilt_y};
}

PlaneMotion FromArray(const Parameters& p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

// Residual of a block in reference pixels, weighted by its accuracy.
struct BlockResidual {
  const PlaneShift* shift;
  Eigen::Matrix2d whitening;

  template <typename T>
  Eigen::Matrix<T, 2, 1> At(const PlaneProjection<T>& projection) const {
    const Eigen::Matrix<T, 2, 1> error =
        projection.Apply(shift->block.point) - shift->seen.cast<T>();
    return whitening.cast<T>() * error;
  }
};

Eigen::Matrix2d InformationOf(const PlaneShift& shift) {
  return shift.block.quality * shift.block.sharpness + 1e-9 * Eigen::Matrix2d::Identity();
}

Eigen::Matrix2d Whitening(const PlaneShift& shift) {
  // W'W = quality * sharpness, transformed to the current image by the local linear part.
  const Eigen::LLT<Eigen::Matrix2d> llt(InformationOf(shift));
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
  return ProjectionOf(camera, *this).Apply(at, rho);
}

Eigen::Matrix2d PlaneMotion::Jacobian(const PlaneCamera& camera,
                                      const Eigen::Vector2d& at,
                                      double rho) const {
  return ProjectionOf(camera, *this).Jacobian(at, rho);
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

/// The residuals of all blocks under Cauchy's loss, as a function for Ceres' solver of small
/// problems. Each block's residual is shortened so that the sum of squares is that of the losses.
class RobustResiduals {
 public:
  using Scalar = double;
  // As ceres::TinySolver names them.
  // NOLINTBEGIN(readability-identifier-naming)
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };
  // NOLINTEND(readability-identifier-naming)
  using Jet = ceres::Jet<double, NUM_PARAMETERS>;
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, NUM_PARAMETERS>;

  RobustResiduals(const PlaneCamera& camera,
                  const std::vector<PlaneShift>& shifts,
                  const PlaneFitParams& params)
      : camera_(camera),
        free_({true, true, params.fit_height, true, params.fit_tilt, params.fit_tilt}) {
    blocks_.reserve(shifts.size());
    for (const PlaneShift& shift : shifts) blocks_.push_back({&shift, Whitening(shift)});
  }

  /// @param loss  Residuals of this length and more count less.
  void SetLoss(double loss) { loss2_ = loss * loss; }

  [[nodiscard]] int NumResiduals() const { return 2 * static_cast<int>(blocks_.size()); }

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    if (jacobian == nullptr) {
      const PlaneProjection<double> projection(camera_, parameters);
      for (const BlockResidual& block : blocks_) {
        const Eigen::Vector2d residual = block.At(projection);
        const double square = residual.squaredNorm();
        const double shorter = std::sqrt(Loss(square) / std::max(square, kTiny));
        *residuals++ = shorter * residual.x();
        *residuals++ = shorter * residual.y();
      }
      return true;
    }
    Eigen::Map<Jacobian> derivatives(jacobian, NumResiduals(), NUM_PARAMETERS);
    Eigen::Map<Eigen::VectorXd> values(residuals, NumResiduals());
    ForEachBlock(parameters, [&](Eigen::Index i, const Eigen::Vector2d& residual, const auto& j) {
      // With l the loss of a square s, the residual is r sqrt(l(s) / s).
      const double square = std::max(residual.squaredNorm(), kTiny);
      const double shorter = std::sqrt(Loss(square) / square);
      const double slope = (Weight(square) / shorter - shorter) / square;
      values.segment<2>(i) = shorter * residual;
      derivatives.middleRows<2>(i) =
          (shorter * Eigen::Matrix2d::Identity() + slope * residual * residual.transpose()) * j;
    });
    return true;
  }

  /// The information of the residuals on the parameters, each with the weight that the loss gives
  /// it.
  [[nodiscard]] Matrix6d Information(const double* parameters) const {
    Matrix6d information = Matrix6d::Zero();
    ForEachBlock(parameters, [&](Eigen::Index, const Eigen::Vector2d& residual, const auto& j) {
      information += Weight(residual.squaredNorm()) * j.transpose() * j;
    });
    return information;
  }

  /// The blocks for CovarianceOf.
  [[nodiscard]] std::vector<FittedBlock<NUM_PARAMETERS>> Fitted(const double* parameters) const {
    std::vector<FittedBlock<NUM_PARAMETERS>> fitted;
    fitted.reserve(blocks_.size());
    ForEachBlock(parameters, [&](Eigen::Index, const Eigen::Vector2d& residual, const auto& j) {
      const BlockResidual& block = blocks_[fitted.size()];
      // Along the axes of the reference, on which blocks share noise.
      const Eigen::Matrix2d root = RootOf(InformationOf(*block.shift));
      const Eigen::Matrix2d turn =
          root * (block.whitening * block.shift->current_from_reference).inverse();
      FittedBlock<NUM_PARAMETERS> one;
      one.point = block.shift->block.point;
      one.jacobian = turn * j;
      one.residual = turn * residual;
      one.sampling = root * block.shift->block.sampling;
      one.weight = Weight(residual.squaredNorm());
      fitted.push_back(one);
    });
    return fitted;
  }

  [[nodiscard]] std::vector<double> Sizes(const double* parameters) const {
    std::vector<double> sizes;
    sizes.reserve(blocks_.size());
    const PlaneProjection<double> projection(camera_, parameters);
    for (const BlockResidual& block : blocks_) sizes.push_back(block.At(projection).norm());
    return sizes;
  }

  [[nodiscard]] bool IsFree(int parameter) const {
    return free_[static_cast<std::size_t>(parameter)];
  }

 private:
  static constexpr double kTiny = 1e-20;

  [[nodiscard]] double Loss(double square) const { return loss2_ * std::log1p(square / loss2_); }
  [[nodiscard]] double Weight(double square) const { return 1 / (1 + square / loss2_); }

  /// Calls use(row, residual, its derivatives) for each block. Those by fixed parameters are zero.
  template <typename Use>
  void ForEachBlock(const double* parameters, const Use& use) const {
    std::array<Jet, NUM_PARAMETERS> at;
    for (int i = 0; i < NUM_PARAMETERS; ++i) {
      const auto k = static_cast<std::size_t>(i);
      at[k] = free_[k] ? Jet(parameters[i], i) : Jet(parameters[i]);
    }
    const PlaneProjection<Jet> projection(camera_, at.data());
    Eigen::Matrix<double, 2, NUM_PARAMETERS> derivatives;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Eigen::Matrix<Jet, 2, 1> residual = blocks_[i].At(projection);
      derivatives.row(0) = residual.x().v.transpose();
      derivatives.row(1) = residual.y().v.transpose();
      use(static_cast<Eigen::Index>(2 * i),
          Eigen::Vector2d(residual.x().a, residual.y().a),
          derivatives);
    }
  }

  PlaneCamera camera_;
  std::vector<BlockResidual> blocks_;
  std::array<bool, NUM_PARAMETERS> free_;
  double loss2_ = 1;
};

/// The robust standard deviation of a whitened residual's axis, at least kSigmaFloorPx.
double RobustScale(const RobustResiduals& residuals, const double* parameters) {
  std::vector<double> sizes = residuals.Sizes(parameters);
  return std::max(kSigmaFloorPx, Median(sizes) / 1.1774);
}

/// As if the blocks were independent, for a standard deviation of one; zero for fixed parameters.
/// Undetermined parameters get a very large variance.
Matrix6d SpreadOf(const RobustResiduals& residuals, const double* parameters) {
  Matrix6d information = residuals.Information(parameters);
  for (int i = 0; i < 6; ++i) {
    if (!residuals.IsFree(i)) information(i, i) = 1;
  }
  Matrix6d covariance = information.inverse();
  for (int i = 0; i < 6; ++i) {
    if (!residuals.IsFree(i)) covariance(i, i) = 0;
  }
  return covariance;
}

}  // namespace

PlaneFit FitPlaneMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const PlaneFitParams& params,
                        const SharedNoise* shared) {
  PlaneFit fit;
  fit.motion = start;
  fit.blocks = static_cast<int>(shifts.size());
  if (shifts.size() < 6) return fit;
  RobustResiduals residuals(camera, shifts, params);
  ceres::TinySolver<RobustResiduals> solver;
  solver.options.max_num_iterations = 20;
  solver.options.function_tolerance = 1e-10;
  Vector6d parameters(ToArray(start).data());
  constexpr int kScales = 3;
  for (int round = 0; round < kScales; ++round) {
    // The scale belongs to the squared residual norm: Cauchy's 2.3849 sigma keeps 95 % efficiency.
    residuals.SetLoss(2.3849 * RobustScale(residuals, parameters.data()));
    solver.Solve(residuals, &parameters);
    if (!parameters.allFinite()) return fit;
  }
  fit.sigma_px = RobustScale(residuals, parameters.data());
  if (shared != nullptr) {
    fit.covariance = CovarianceOf(
        residuals.Fitted(parameters.data()), *shared, kCauchyLoss, kSigmaFloorPx * kSigmaFloorPx);
    fit.tilt_spread = fit.sigma_px * fit.sigma_px *
                      SpreadOf(residuals, parameters.data()).bottomRightCorner<2, 2>();
    if (!fit.covariance.allFinite() || !fit.tilt_spread.allFinite()) return fit;
  }
  fit.motion = FromArray(
      {parameters[0], parameters[1], parameters[2], parameters[3], parameters[4], parameters[5]});
  const PlaneProjection<double> projection = ProjectionOf(camera, fit.motion);
  for (const PlaneShift& shift : shifts) {
    const Eigen::Vector2d error = projection.Apply(shift.block.point) - shift.seen;
    const Eigen::Vector2d in_reference = shift.current_from_reference.inverse() * error;
    fit.inliers += in_reference.dot(shift.block.sharpness * in_reference) < 1 ? 1 : 0;
  }
  fit.ok = true;
  return fit;
}

}  // namespace ceilmap::registration
