#include "calib/solve/forward_mount.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

namespace ceilmap::calibration {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinDepthM = 0.3;  // nothing is nearer to the camera
// Standard deviation of the initial rotation: all information on an angle that no motion
// determines.
constexpr double kStartSigmaRad = 0.05;
// Standard deviations of each motion, about and along any axis: errors of the ceiling's poses. They
// are estimated with the rotation, because otherwise short motions would have too much weight.
constexpr double kMotionSigmaRad = 2e-4;
constexpr double kMotionSigmaM = 3e-4;

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Vector6 = Eigen::Matrix<T, 6, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

// exp(turn), a rotation about the axes of base.
template <typename T>
Matrix3<T> TurnOf(const T* turn) {
  Matrix3<T> R;
  ceres::AngleAxisToRotationMatrix(turn, R.data());  // column-major, as in Eigen
  return R;
}

// The half of an epipolar line on which a match may lie in the second image, in the second's
// optical frame: direction of the first ray, and position of the first camera.
template <typename T>
struct RayInSecond {
  Vector3<T> direction;  // of the first's ray, z = 1 in the first
  Vector3<T> origin;     // the first camera
};

// @param error  Of the motion: a small rotation about the axes of base, and a translation, m.
template <typename T>
RayInSecond<T> RayOf(const MotionWithMatches& motion,
                     const Match& match,
                     const Matrix3<T>& R_base_cam,
                     const Vector3d& place,
                     const Vector6<T>& error) {
  const Matrix3d R_second_first = motion.T_first_second.linear().transpose();
  // The first camera in the second's base, from the second camera.
  const Vector3d origin = R_second_first * (place - motion.T_first_second.translation()) - place;
  const Vector3<T> ray = R_base_cam * match.first.homogeneous().cast<T>();
  const Vector3<T> turned = R_second_first.cast<T>() * ray;
  return {R_base_cam.transpose() * (turned + error.template head<3>().cross(turned)),
          R_base_cam.transpose() * (origin.cast<T>() + error.template tail<3>())};
}

// Distance of a match from that half line, along it (beyond its ends) and across, in units of the
// focal length. @return false when it is behind the second camera.
template <typename T>
bool MissOf(const RayInSecond<T>& ray, const Vector2d& seen, T* miss) {
  const Vector3<T>& far = ray.direction;
  if (!(far.z() > 1e-3)) return false;
  const Vector2<T> infinity = far.hnormalized();
  // With p(w) = far + w origin, w = 1/depth: d(p.xy / p.z)/dw at 0.
  const Vector2<T> towards = (ray.origin.template head<2>() - infinity * ray.origin.z()) / far.z();
  const Vector2<T> off = seen.cast<T>() - infinity;
  const T length2 = towards.squaredNorm();
  if (!(length2 > 1e-16)) {  // pure rotation of the camera
    miss[0] = off.x();
    miss[1] = off.y();
    return true;
  }
  const Vector2<T> along = towards / ceres::sqrt(length2);
  miss[0] = off.y() * along.x() - off.x() * along.y();
  const T s = off.dot(along);
  const Vector3<T> near = far + ray.origin / T(kMinDepthM);
  miss[1] = T(0);
  if (s < T(0)) {
    miss[1] = s;
  } else if (near.z() > 1e-3) {
    const T most = (near.hnormalized() - infinity).dot(along);
    if (s > most) miss[1] = s - most;
  }
  return true;
}

struct MatchCost {
  const MotionWithMatches* motion;
  const Match* match;
  const Isometry3d* start;
  double per_error;  // focal length / standard deviation

  template <typename T>
  bool operator()(const T* turn, const T* error, T* residual) const {
    const Matrix3<T> R = TurnOf(turn) * start->linear().cast<T>();
    const RayInSecond<T> ray =
        RayOf<T>(*motion, *match, R, start->translation(), Eigen::Map<const Vector6<T>>(error));
    if (!MissOf<T>(ray, match->second, residual)) {
      residual[0] = residual[1] = T(0);  // not informative
    }
    residual[0] *= T(per_error);
    residual[1] *= T(per_error);
    return true;
  }
};

// Prior of a small rotation.
struct TurnCost {
  double per_rad;
  template <typename T>
  bool operator()(const T* turn, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = turn[i] * T(per_rad);
    return true;
  }
};

// Prior of the measured motion.
struct MotionCost {
  double per_rad;
  double per_m;
  template <typename T>
  bool operator()(const T* error, T* residual) const {
    for (int i = 0; i < 6; ++i) residual[i] = error[i] * T(i < 3 ? per_rad : per_m);
    return true;
  }
};

ceres::CostFunction* TurnCostOf(double sigma_rad) {
  return new ceres::AutoDiffCostFunction<TurnCost, 3, 3>(new TurnCost{1 / sigma_rad});
}

// The unknowns.
struct MountEstimate {
  Vector3d turn = Vector3d::Zero();     // of the camera, relative to the start
  std::vector<Vector6<double>> errors;  // of each motion: rotation and translation
};

// Motions [first, last) that a solution leaves out.
struct Range {
  std::size_t first = 0;
  std::size_t last = 0;
};

// Loss function for outliers.
enum class Loss {
  kHuber,   // linear: converges from far away, but is affected by outliers
  kCauchy,  // decreasing influence: for an approximate start
};

ceres::LossFunction* LossOf(Loss loss) {
  if (loss == Loss::kHuber) return new ceres::HuberLoss(1);
  return new ceres::CauchyLoss(2);
}

class Solver {
 public:
  Solver(const std::vector<MotionWithMatches>& motions,
         const Isometry3d& start,
         const ForwardMountParams& params)
      : motions_(motions), start_(start), params_(params) {}

  // @param at  Start. @param curvature  Covariance of the rotation from the curvature, if
  // requested.
  [[nodiscard]] std::optional<MountEstimate> Solve(MountEstimate at,
                                                   double sigma_px,
                                                   Range out,
                                                   Loss loss = Loss::kCauchy,
                                                   Matrix3d* curvature = nullptr) const {
    ceres::Problem problem;
    ceres::Solver::Options options;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    double* const turn = at.turn.data();
    problem.AddParameterBlock(turn, 3);
    options.linear_solver_ordering->AddElementToGroup(turn, 1);
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      if (i >= out.first && i < out.last) continue;
      double* const error = at.errors[i].data();
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<MotionCost, 6, 6>(
                                   new MotionCost{1 / kMotionSigmaRad, 1 / kMotionSigmaM}),
                               nullptr,
                               error);
      options.linear_solver_ordering->AddElementToGroup(error, 0);
      for (const Match& match : motions_[i].matches) {
        auto* cost = new MatchCost{&motions_[i], &match, &start_, params_.focal_px / sigma_px};
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<MatchCost, 2, 3, 6>(cost), LossOf(loss), turn, error);
      }
    }
    problem.AddResidualBlock(TurnCostOf(kStartSigmaRad), nullptr, turn);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.num_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 50;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) return std::nullopt;
    if (curvature == nullptr) return at;
    ceres::Covariance::Options how;
    how.num_threads = options.num_threads;
    ceres::Covariance covariance(how);
    const std::vector<std::pair<const double*, const double*>> blocks{{turn, turn}};
    if (!covariance.Compute(blocks, &problem)) return std::nullopt;
    covariance.GetCovarianceBlock(turn, turn, curvature->data());
    return at;
  }

  // Lengths of the residuals of all matches, in pixels.
  [[nodiscard]] std::vector<double> Errors(const MountEstimate& at) const {
    const Matrix3d R = TurnOf(at.turn.data()) * start_.linear();
    std::vector<double> errors;
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      const MotionWithMatches& motion = motions_[i];
      for (const Match& match : motion.matches) {
        Vector2d miss;
        const auto ray = RayOf<double>(motion, match, R, start_.translation(), at.errors[i]);
        const bool shown = MissOf<double>(ray, match.second, miss.data());
        errors.push_back(shown ? params_.focal_px * miss.norm()
                               : std::numeric_limits<double>::infinity());
      }
    }
    return errors;
  }

  // Standard deviation of one axis, from the median of the lengths, which are mostly across a line.
  [[nodiscard]] double SigmaOf(std::vector<double> errors) const {
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    constexpr double kMadToSigma = 1.4826;
    return std::max(params_.sigma_floor_px, kMadToSigma * *middle);
  }

 private:
  const std::vector<MotionWithMatches>& motions_;
  const Isometry3d& start_;
  const ForwardMountParams& params_;
};

// Change of the rotation by a common error of all matches.
std::optional<Matrix3d> Systematic(const std::vector<MotionWithMatches>& motions,
                                   const Isometry3d& start,
                                   const ForwardMountParams& params,
                                   const MountEstimate& at,
                                   double sigma_px) {
  double edge = 0;  // of the images, in units of the focal length
  for (const MotionWithMatches& motion : motions) {
    for (const Match& match : motion.matches) edge = std::max(edge, match.second.norm());
  }
  const double size = params.systematic_px / params.focal_px;
  using Pattern = Vector2d (*)(const Vector2d& at_edge);
  constexpr std::array<Pattern, 4> kPatterns{
      [](const Vector2d& /*p*/) { return Vector2d(1, 0); },
      [](const Vector2d& /*p*/) { return Vector2d(0, 1); },
      [](const Vector2d& p) { return p; },
      [](const Vector2d& p) { return Vector2d(-p.y(), p.x()); }};
  Matrix3d spread = Matrix3d::Zero();
  for (const Pattern pattern : kPatterns) {
    std::vector<MotionWithMatches> shifted = motions;
    for (MotionWithMatches& motion : shifted) {
      for (Match& match : motion.matches) match.second += size * pattern(match.second / edge);
    }
    const auto found = Solver(shifted, start, params).Solve(at, sigma_px, {});
    if (!found) return std::nullopt;
    spread += (found->turn - at.turn) * (found->turn - at.turn).transpose();
  }
  return spread;
}

// Delete-a-group jackknife over intervals of consecutive motions.
std::optional<Matrix3d> Spread(const Solver& solver,
                               std::size_t motions,
                               const MountEstimate& at,
                               double sigma_px) {
  constexpr std::size_t kGroups = 12;
  const std::size_t groups = std::min(kGroups, motions);
  if (groups < 2) return std::nullopt;
  std::vector<Vector3d> without;
  Vector3d mean = Vector3d::Zero();
  for (std::size_t g = 0; g < groups; ++g) {
    const Range out{motions * g / groups, motions * (g + 1) / groups};
    const std::optional<MountEstimate> found = solver.Solve(at, sigma_px, out);
    if (!found) return std::nullopt;
    without.push_back(found->turn);
    mean += found->turn / static_cast<double>(groups);
  }
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& one : without) spread += (one - mean) * (one - mean).transpose();
  return spread * (static_cast<double>(groups - 1) / static_cast<double>(groups));
}

}  // namespace

ForwardMount SolveForwardMount(const std::vector<MotionWithMatches>& motions,
                               const Isometry3d& start,
                               const ForwardMountParams& params) {
  ForwardMount mount;
  mount.R_base_cam = start.linear();
  for (const MotionWithMatches& motion : motions) mount.matches += motion.matches.size();
  constexpr std::size_t kMinMatches = 50;
  if (mount.matches < kMinMatches) return mount;
  const Solver solver(motions, start, params);
  MountEstimate at;
  at.errors.assign(motions.size(), Vector6<double>::Zero());
  // A wrong rotation increases the residuals of all matches: the scale decreases with it.
  mount.sigma_px = solver.SigmaOf(solver.Errors(at));
  constexpr int kMaxRounds = 8;
  constexpr double kSettled = 0.01;
  for (const Loss loss : {Loss::kHuber, Loss::kCauchy}) {
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::optional<MountEstimate> found = solver.Solve(at, mount.sigma_px, {}, loss);
      if (!found) return mount;
      at = *found;
      const double sigma_px = solver.SigmaOf(solver.Errors(at));
      const double change = std::abs(sigma_px / mount.sigma_px - 1);
      mount.sigma_px = sigma_px;
      if (change < kSettled) break;
    }
  }
  const std::optional<Matrix3d> spread = Spread(solver, motions.size(), at, mount.sigma_px);
  Matrix3d curvature;
  if (!solver.Solve(at, mount.sigma_px, {}, Loss::kCauchy, &curvature)) return mount;
  const std::optional<Matrix3d> systematic = Systematic(motions, start, params, at, mount.sigma_px);
  if (!spread || !systematic) return mount;
  for (const double error : solver.Errors(at)) mount.inliers += error < 3 * mount.sigma_px;
  mount.R_base_cam = TurnOf(at.turn.data()) * start.linear();
  // An error of the principal point shifts the image: rotations about the camera's x and y.
  const double lens_rad = params.lens_sigma_px / params.focal_px;
  const Eigen::Matrix<double, 3, 2> axes = mount.R_base_cam.leftCols<2>();
  mount.covariance =
      curvature + *spread + *systematic + lens_rad * lens_rad * axes * axes.transpose();
  mount.covariance.diagonal().array() += params.systematic_rad * params.systematic_rad;
  mount.ok = mount.covariance.allFinite() && 2 * mount.inliers > mount.matches;
  return mount;
}

}  // namespace ceilmap::calibration
