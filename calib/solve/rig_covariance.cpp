#include "calib/solve/rig_covariance.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kKnown = kRigUnknowns;
using Influence = Eigen::Matrix<double, kKnown, 1>;

// Derivatives of the known parameters by the free ones, which are in the order of
// RigProblem::blocks.
MatrixXd Asked(const RigParameters& parameters, int columns) {
  MatrixXd asked = MatrixXd::Zero(kKnown, columns);
  asked.topLeftCorner<4, 4>().setIdentity();
  const bool has_yaw = !parameters.straight.empty();
  if (parameters.readout_is_free) asked(kReadout, has_yaw ? 5 : 4) = 1;
  if (!has_yaw) return asked;
  asked(kYaw, 4) = 1;
  const Vector2d travel = TravelOf(parameters);
  const Vector2d along = travel.normalized();
  const Pose2 last{0, 0, parameters.straight.back()[2]};
  const Eigen::Matrix2d R = last.Rotation();
  const Vector2d c(parameters.centre[0], parameters.centre[1]);
  const Vector2d turned = R * c;
  asked.block<1, 2>(kTravel, 2) = along.transpose() * (R - Eigen::Matrix2d::Identity());
  asked.block<1, 2>(kTravel, columns - 3) = along.transpose();
  asked(kTravel, columns - 1) = along.dot(Vector2d(-turned.y(), turned.x()));
  return asked;
}

struct Hessians {
  MatrixXd hessian;  // of the robust cost
  MatrixXd gauss_newton;
};

Hessians NormalOf(const RigProblem& problem, const Linearized& at) {
  const int n = at.jacobian.num_cols;
  Hessians normal{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
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
        touched.push_back(i);
        gradient[i] += a * at.residuals[r];
      });
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const int i : touched) {
      for (const int j : touched) normal.hessian(i, j) += term.bend * gradient[i] * gradient[j];
    }
    for (const int i : touched) gradient[i] = 0;
    row += static_cast<std::size_t>(term.rows);
  }
  normal.hessian += normal.gauss_newton;
  return normal;
}

// Rows: change of the known parameters by each free parameter's gradient.
MatrixXd InfluenceOf(const Hessians& normal, const MatrixXd& asked) {
  const Eigen::LLT<MatrixXd> exact(normal.hessian);
  if (exact.info() == Eigen::Success) return exact.solve(asked.transpose()).transpose();
  const Eigen::LDLT<MatrixXd> fallback(normal.gauss_newton);
  return fallback.solve(asked.transpose()).transpose();
}

// Errors of a lens model at a ray, each with a length of at most 1, which it reaches at the edge:
// principal point, focal length, skew, radial and tangential distortion.
constexpr int kLensErrors = 7;
using LensErrors = Eigen::Matrix<double, 2, kLensErrors>;

LensErrors LensErrorsAt(const Vector2d& ray, double edge) {
  const Vector2d at = ray / edge;
  const double x = at.x();
  const double y = at.y();
  const double r2 = at.squaredNorm();
  LensErrors errors;
  errors << 1, 0, x, y, r2 * x, 2 * x * y / 3, (r2 + 2 * x * x) / 3,  //
      0, 1, y, 0, r2 * y, (r2 + 2 * y * y) / 3, 2 * x * y / 3;
  return errors;
}

double EdgeOf(const Recording& spin, const Recording& straight) {
  double edge = 0;
  for (const Recording* recording : {&spin, &straight}) {
    for (const ViewPair& pair : recording->pairs) {
      for (const PointCorrespondence& place : pair.places) {
        edge = std::max({edge, place.first.norm(), place.second.norm()});
      }
    }
  }
  return edge;
}

// Effect of lens errors on the fit: change of each residual, and of the known parameters.
class LensUncertainty {
 public:
  LensUncertainty(const RigParameters& parameters, const RigSolverParams& params, double sigma_px)
      : parameters_(parameters),
        focal_px_(params.focal_px),
        lens_sigma_(params.lens_sigma_px / params.focal_px),
        sigma_px_(sigma_px) {}

  // Changes of residuals, one column per lens error.
  [[nodiscard]] LensErrors Moves(const std::vector<RigParameters::Pose>& poses,
                                 const Recording& recording,
                                 const ViewPair& pair,
                                 const PointCorrespondence& place,
                                 double edge) const {
    const LensErrors first = lens_sigma_ * LensErrorsAt(place.first, edge);
    const LensErrors second = lens_sigma_ * LensErrorsAt(place.second, edge);
    const Vector2d as_is = PlaceError(parameters_, poses, recording, pair, place, focal_px_);
    LensErrors moves;
    for (int k = 0; k < kLensErrors; ++k) {
      PointCorrespondence moved = place;
      moved.first += first.col(k);
      moved.second += second.col(k);
      moves.col(k) = PlaceError(parameters_, poses, recording, pair, moved, focal_px_) - as_is;
    }
    return moves / sigma_px_;
  }

 private:
  const RigParameters& parameters_;
  double focal_px_;
  double lens_sigma_;
  double sigma_px_;
};

// Rows of the problem's points, in its order.
std::vector<LensErrors> LensMoves(const Recording& spin,
                                  const Recording& straight,
                                  const RigParameters& parameters,
                                  const RigSolverParams& params,
                                  double sigma_px) {
  const LensUncertainty lens(parameters, params, sigma_px);
  const double edge = EdgeOf(spin, straight);
  std::vector<LensErrors> moves;
  const auto add = [&](const Recording& recording, const auto& poses) {
    for (const ViewPair& pair : recording.pairs) {
      for (const PointCorrespondence& place : pair.places) {
        moves.push_back(lens.Moves(poses, recording, pair, place, edge));
      }
    }
  };
  add(spin, parameters.spin);
  add(straight, parameters.straight);
  return moves;
}

RigCovarianceMatrix FromLens(const RigProblem& problem,
                             const Linearized& at,
                             const MatrixXd& influence,
                             const std::vector<LensErrors>& moves) {
  Eigen::Matrix<double, kKnown, kLensErrors> shift = decltype(shift)::Zero();
  std::size_t row = 0;
  for (std::size_t i = 0; i < moves.size(); ++i) {  // points come first
    const BlockTerm term = TermOf(problem.owners[i], at, row, problem.problem);
    for (int k = 0; k < term.rows; ++k, ++row) {
      ForRow(at.jacobian, row, [&](int column, double a) {
        shift += term.weight * a * influence.col(column) * moves[i].row(k);
      });
    }
  }
  return shift * shift.transpose();
}

RigCovarianceMatrix FromViews(const std::vector<PairInfluence>& pairs, std::size_t views) {
  std::vector<Influence> of_view(views, Influence::Zero());
  RigCovarianceMatrix twice = decltype(twice)::Zero();
  for (const PairInfluence& pair : pairs) {
    const Influence change = pair.change;
    of_view[static_cast<std::size_t>(pair.first)] += change;
    if (pair.second < 0) continue;
    of_view[static_cast<std::size_t>(pair.second)] += change;
    twice += change * change.transpose();
  }
  RigCovarianceMatrix sum = decltype(sum)::Zero();
  for (const Influence& view : of_view) sum += view * view.transpose();
  // A pair was counted at both of its views. If there are no others, the difference can become
  // negative by rounding: half of the sum is the result for independent pairs.
  RigCovarianceMatrix covariance = sum - twice;
  for (int i = 0; i < kKnown; ++i) {
    if (covariance(i, i) < 0.5 * sum(i, i)) return 0.5 * sum;
  }
  return covariance;
}

}  // namespace

RigCovarianceMatrix RigCovariance(RigProblem& problem,
                                  const Recording& spin,
                                  const Recording& straight,
                                  const RigParameters& parameters,
                                  const RigSolverParams& params,
                                  double sigma_px) {
  const Linearized at(problem);
  const MatrixXd influence =
      InfluenceOf(NormalOf(problem, at), Asked(parameters, at.jacobian.num_cols));
  const std::size_t views = parameters.spin.size() + parameters.straight.size();
  return FromViews(InfluenceOfPairs(problem, at, influence), views) +
         FromLens(problem, at, influence, LensMoves(spin, straight, parameters, params, sigma_px));
}

}  // namespace ceilmap::calibration
