#include "calib/solve/rig_solver.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "calib/solve/rig_problem.hpp"

namespace ceilmap::calibration {
namespace {

using calib::Pose2;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kKnown = 6;  // tilt, centre, yaw, travel
using Influence = Eigen::Matrix<double, kKnown, 1>;

RigParameters StartParameters(const Recording& spin,
                              const Recording& straight,
                              const RigMount& start) {
  RigParameters parameters;
  parameters.tilt = {start.tilt_rad.x(), start.tilt_rad.y()};
  parameters.centre = {start.centre.x(), start.centre.y()};
  parameters.yaw = {start.yaw_rad};
  // Headings are continuous: a spin may go round more than once.
  double heading = 0;
  for (const Pose2& camera : spin.cameras) {
    heading += calib::WrapAngle(camera.yaw - heading);
    parameters.spin.push_back({0, 0, heading});
  }
  // The axle begins at the origin.
  for (const Pose2& camera : straight.cameras) {
    const Vector2d axle = camera.Translation() + start.centre - camera.Rotation() * start.centre;
    parameters.straight.push_back({axle.x(), axle.y(), camera.yaw});
  }
  return parameters;
}

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void AddErrors(const Recording& recording,
               const RigParameters& parameters,
               const std::vector<RigParameters::Pose>& poses,
               double focal_px,
               std::vector<double>& errors_px) {
  for (const ViewPair& pair : recording.pairs) {
    for (const SeenTwice& place : pair.places) {
      errors_px.push_back(PlaceError(parameters, poses, pair, place, focal_px).norm());
    }
  }
}

std::vector<double> ErrorsOf(const Recording& spin,
                             const Recording& straight,
                             const RigParameters& parameters,
                             double focal_px) {
  std::vector<double> errors_px;
  AddErrors(spin, parameters, parameters.spin, focal_px, errors_px);
  AddErrors(straight, parameters, parameters.straight, focal_px, errors_px);
  return errors_px;
}

// Deviations of what is left; of wheels too, once their views are free.
RigScales ScalesOf(const Recording& spin,
                   const Recording& straight,
                   const RigParameters& parameters,
                   const RigSolverParams& params) {
  constexpr double kMedianOfTwo = 1.1774;  // of the length of a normal error in two axes
  RigScales scales;
  std::vector<double> errors_px = ErrorsOf(spin, straight, parameters, params.focal_px);
  scales.place_px = std::max(params.sigma_floor_px, Median(errors_px) / kMedianOfTwo);
  std::vector<double> wander;
  for (const auto& pose : parameters.spin) wander.push_back(std::hypot(pose[0], pose[1]));
  scales.wander = std::max(params.least_wander, Median(wander) / kMedianOfTwo);
  std::vector<double> slip;
  for (std::size_t i = 0; i + 1 < parameters.straight.size(); ++i) {
    slip.push_back(std::abs(SlipOf(parameters, i)));
  }
  constexpr double kMedianOfOne = 0.6745;
  scales.slip = params.least_slip;
  if (!slip.empty()) scales.slip = std::max(scales.slip, Median(slip) / kMedianOfOne);
  return scales;
}

bool Minimise(RigProblem& problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem.problem, &summary);
  return summary.IsSolutionUsable();
}

Vector2d CameraOf(const RigParameters::Pose& pose, const std::array<double, 2>& centre) {
  const Pose2 T_first_axle{pose[0], pose[1], pose[2]};
  return T_first_axle * Vector2d(centre[0], centre[1]);
}

Vector2d TravelOf(const RigParameters& parameters) {
  if (parameters.straight.empty()) return Vector2d::Zero();
  return CameraOf(parameters.straight.back(), parameters.centre) -
         CameraOf(parameters.straight.front(), parameters.centre);
}

// Derivatives of what is asked for by the free parameters.
MatrixXd Asked(const RigParameters& parameters, int columns) {
  MatrixXd asked = MatrixXd::Zero(kKnown, columns);
  asked.topLeftCorner<4, 4>().setIdentity();
  if (parameters.straight.empty()) return asked;
  asked(4, 4) = 1;
  const Vector2d travel = TravelOf(parameters);
  const Vector2d along = travel.normalized();
  const Pose2 last{0, 0, parameters.straight.back()[2]};
  const Eigen::Matrix2d R = last.Rotation();
  const Vector2d c(parameters.centre[0], parameters.centre[1]);
  const Vector2d turned = R * c;
  asked.block<1, 2>(5, 2) = along.transpose() * (R - Eigen::Matrix2d::Identity());
  asked.block<1, 2>(5, columns - 3) = along.transpose();
  asked(5, columns - 1) = along.dot(Vector2d(-turned.y(), turned.x()));
  return asked;
}

// The Jacobian of all residuals, row by row, without the loss.
struct Linearized {
  explicit Linearized(RigProblem& problem) {
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    options.parameter_blocks = problem.blocks;
    for (const BlockOwner& owner : problem.owners) options.residual_blocks.push_back(owner.id);
    problem.problem.Evaluate(options, nullptr, &residuals, nullptr, &jacobian);
  }
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
};

// What one residual block adds.
struct BlockTerm {
  int rows = 0;
  double weight = 1;  // rho'
  double bend = 0;    // 2 rho''
};

BlockTerm TermOf(const BlockOwner& owner,
                 const Linearized& at,
                 std::size_t row,
                 const ceres::Problem& problem) {
  BlockTerm term;
  term.rows = problem.GetCostFunctionForResidualBlock(owner.id)->num_residuals();
  if (!owner.place) return term;
  double square = 0;
  for (int k = 0; k < term.rows; ++k) {
    const double r = at.residuals[row + static_cast<std::size_t>(k)];
    square += r * r;
  }
  term.weight = 1 / (1 + square / (kCauchy * kCauchy));
  term.bend = -2 * term.weight * term.weight / (kCauchy * kCauchy);
  return term;
}

// Sum over the block's rows of J' r; as sparse as the block.
void ForRow(const ceres::CRSMatrix& m, std::size_t row, auto&& use) {
  for (int k = m.rows[row]; k < m.rows[row + 1]; ++k) {
    use(m.cols[static_cast<std::size_t>(k)], m.values[static_cast<std::size_t>(k)]);
  }
}

void AddOuter(const ceres::CRSMatrix& m, std::size_t row, double weight, MatrixXd& H) {
  ForRow(m, row, [&](int i, double a) {
    ForRow(m, row, [&](int j, double b) { H(i, j) += weight * a * b; });
  });
}

struct Normal {
  MatrixXd hessian;  // of the robust cost
  MatrixXd gauss_newton;
};

Normal NormalOf(const RigProblem& problem, const Linearized& at) {
  const int n = at.jacobian.num_cols;
  Normal normal{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
  std::size_t row = 0;
  VectorXd gradient = VectorXd::Zero(n);
  for (const BlockOwner& owner : problem.owners) {
    const BlockTerm term = TermOf(owner, at, row, problem.problem);
    std::vector<int> touched;
    for (int k = 0; k < term.rows; ++k) {
      const std::size_t r = row + static_cast<std::size_t>(k);
      AddOuter(at.jacobian, r, term.weight, normal.gauss_newton);
      if (term.bend == 0) continue;
      ForRow(at.jacobian, r, [&](int i, double a) {
        if (gradient[i] == 0) touched.push_back(i);
        gradient[i] += a * at.residuals[r];
      });
    }
    for (const int i : touched) {
      for (const int j : touched) normal.hessian(i, j) += term.bend * gradient[i] * gradient[j];
    }
    for (const int i : touched) gradient[i] = 0;
    row += static_cast<std::size_t>(term.rows);
  }
  normal.hessian += normal.gauss_newton;
  return normal;
}

// rows: by how much what is asked for moves with each free parameter's gradient.
MatrixXd InfluenceOf(const Normal& normal, const MatrixXd& asked) {
  const Eigen::LLT<MatrixXd> exact(normal.hessian);
  if (exact.info() == Eigen::Success) return exact.solve(asked.transpose()).transpose();
  const Eigen::LDLT<MatrixXd> fallback(normal.gauss_newton);
  return fallback.solve(asked.transpose()).transpose();
}

Eigen::Matrix<double, kKnown, kKnown> CovarianceOf(RigProblem& problem,
                                                   const RigParameters& parameters) {
  const Linearized at(problem);
  const MatrixXd influence =
      InfluenceOf(NormalOf(problem, at), Asked(parameters, at.jacobian.num_cols));
  std::vector<Influence> of_view(parameters.spin.size() + parameters.straight.size(),
                                 Influence::Zero());
  Eigen::Matrix<double, kKnown, kKnown> twice = decltype(twice)::Zero();
  Influence of_pair = Influence::Zero();
  std::size_t row = 0;
  for (std::size_t i = 0; i < problem.owners.size(); ++i) {
    const BlockOwner& owner = problem.owners[i];
    const BlockTerm term = TermOf(owner, at, row, problem.problem);
    for (int k = 0; k < term.rows; ++k, ++row) {
      const double pull = term.weight * at.residuals[row];
      ForRow(at.jacobian, row, [&](int column, double a) {
        of_pair += pull * a * influence.col(column);
      });
    }
    const bool last = i + 1 == problem.owners.size() ||
                      problem.owners[i + 1].first != owner.first ||
                      problem.owners[i + 1].second != owner.second;
    if (!last) continue;
    of_view[static_cast<std::size_t>(owner.first)] += of_pair;
    if (owner.second >= 0) {
      of_view[static_cast<std::size_t>(owner.second)] += of_pair;
      twice += of_pair * of_pair.transpose();
    }
    of_pair.setZero();
  }
  Eigen::Matrix<double, kKnown, kKnown> sum = decltype(sum)::Zero();
  for (const Influence& view : of_view) sum += view * view.transpose();
  // A pair was counted at both its views. Where that is all there is, the difference can lose its
  // sign by rounding: half the sum is what independent pairs give.
  Eigen::Matrix<double, kKnown, kKnown> covariance = sum - twice;
  for (int i = 0; i < kKnown; ++i) {
    if (covariance(i, i) < 0.5 * sum(i, i)) return 0.5 * sum;
  }
  return covariance;
}

std::vector<ViewError> ViewErrors(const Recording& recording,
                                  const RigParameters& parameters,
                                  const std::vector<RigParameters::Pose>& poses,
                                  double focal_px) {
  std::vector<ViewError> errors(poses.size());
  for (const ViewPair& pair : recording.pairs) {
    for (const SeenTwice& place : pair.places) {
      const double square = PlaceError(parameters, poses, pair, place, focal_px).squaredNorm();
      for (const int view : {pair.first, pair.second}) {
        ViewError& error = errors[static_cast<std::size_t>(view)];
        error.rms_px += square;
        ++error.places;
      }
    }
  }
  for (ViewError& error : errors) {
    if (error.places > 0) error.rms_px = std::sqrt(0.5 * error.rms_px / error.places);
  }
  return errors;
}

std::vector<Pose2> ToPoses(const std::vector<RigParameters::Pose>& poses) {
  std::vector<Pose2> result;
  result.reserve(poses.size());
  for (const auto& pose : poses) result.push_back({pose[0], pose[1], pose[2]});
  return result;
}

RigSolution SolutionOf(const Recording& spin,
                       const Recording& straight,
                       const RigParameters& parameters,
                       double focal_px,
                       double sigma_px) {
  RigSolution solution;
  solution.ok = true;
  solution.mount = {{parameters.tilt[0], parameters.tilt[1]},
                    {parameters.centre[0], parameters.centre[1]},
                    calib::WrapAngle(parameters.yaw[0])};
  solution.travel = TravelOf(parameters).norm();
  solution.spin = ToPoses(parameters.spin);
  solution.straight = ToPoses(parameters.straight);
  solution.spin_errors = ViewErrors(spin, parameters, parameters.spin, focal_px);
  solution.straight_errors = ViewErrors(straight, parameters, parameters.straight, focal_px);
  solution.sigma_px = sigma_px;
  const std::vector<double> errors_px = ErrorsOf(spin, straight, parameters, focal_px);
  solution.places = static_cast<int>(errors_px.size());
  solution.inliers = static_cast<int>(std::count_if(
      errors_px.begin(), errors_px.end(), [&](double e) { return e < 3 * sigma_px; }));
  return solution;
}

}  // namespace

Vector2d RigMount::CentreInBase() const {
  return Pose2{0, 0, yaw_rad} * centre;
}

RigMount GuessMount(const Recording& spin, const Recording& straight) {
  RigMount mount;
  // p_i = p_0 + (R_i - 1) c for all views of the spin.
  const auto n = static_cast<Eigen::Index>(spin.cameras.size());
  MatrixXd A(2 * n, 4);
  VectorXd b(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose2& camera = spin.cameras[static_cast<std::size_t>(i)];
    A.block<2, 2>(2 * i, 0) = camera.Rotation() - Eigen::Matrix2d::Identity();
    A.block<2, 2>(2 * i, 2).setIdentity();
    b.segment<2>(2 * i) = camera.Translation();
  }
  const VectorXd x = A.colPivHouseholderQr().solve(b);
  mount.centre = x.head<2>();
  if (straight.cameras.size() < 2) return mount;
  // Forward in the twin's axes is (cos yaw, -sin yaw).
  const Pose2& last = straight.cameras.back();
  const Vector2d way = Pose2{0, 0, -0.5 * last.yaw} * last.Translation();
  mount.yaw_rad = std::atan2(-way.y(), way.x());
  return mount;
}

RigSolution SolveRig(const Recording& spin,
                     const Recording& straight,
                     const RigMount& start,
                     const RigSolverParams& params) {
  RigParameters parameters = StartParameters(spin, straight, start);
  if (parameters.spin.size() < 3 || ErrorsOf(spin, straight, parameters, 1).empty()) return {};
  RigScales scales;  // wide at first: what wheels did is not known yet
  scales.place_px = ScalesOf(spin, straight, parameters, params).place_px;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    RigProblem problem(spin, straight, params.focal_px, scales, parameters);
    if (!Minimise(problem)) return {};
    if (round + 1 == kRounds) {
      RigSolution solution =
          SolutionOf(spin, straight, parameters, params.focal_px, scales.place_px);
      solution.covariance = CovarianceOf(problem, parameters);
      return solution;
    }
    scales = ScalesOf(spin, straight, parameters, params);
  }
  return {};
}

}  // namespace ceilmap::calibration
