#include "mapping/registration/motion_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/base/statistics.hpp"

namespace ceilmap::registration {
namespace {

constexpr int kIterations = 12;

using Similarity = Eigen::Vector4d;  // tx, ty, theta, ln scale

Eigen::Matrix<double, 2, 4> Jacobian(const Eigen::Vector2d& p) {
  Eigen::Matrix<double, 2, 4> j;
  j << 1, 0, -p.y(), p.x(), 0, 1, p.x(), p.y();
  return j;
}

double Distance(const BlockShift& block, const Similarity& parameters) {
  const Eigen::Vector2d r = block.shift - Jacobian(block.point) * parameters;
  return std::sqrt(std::max(0.0, r.dot(block.sharpness * r)));
}

// The small motion of two blocks; false when they are too close to determine a rotation.
bool FromPair(const BlockShift& a, const BlockShift& b, bool scale, Similarity& out) {
  const Eigen::Vector2d d = b.point - a.point;
  const double length2 = d.squaredNorm();
  if (length2 < 1) return false;
  const Eigen::Vector2d e = b.shift - a.shift;
  const double theta = (d.x() * e.y() - d.y() * e.x()) / length2;
  const double log_scale = scale ? d.dot(e) / length2 : 0.0;
  const Eigen::Vector2d middle = 0.5 * (a.point + b.point);
  Similarity turn(0, 0, theta, log_scale);
  const Eigen::Vector2d t = 0.5 * (a.shift + b.shift) - Jacobian(middle) * turn;
  out << t.x(), t.y(), theta, log_scale;
  return true;
}

struct Normal {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  double weight = 0;
};

Normal Accumulate(const std::vector<BlockShift>& blocks, const std::vector<double>& weights) {
  Normal n;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (weights[i] <= 0) continue;
    const auto j = Jacobian(blocks[i].point);
    const Eigen::Matrix<double, 4, 2> jw =
        weights[i] * blocks[i].quality * j.transpose() * blocks[i].sharpness;
    n.a += jw * j;
    n.b += jw * blocks[i].shift;
    n.weight += weights[i];
  }
  return n;
}

// Solves for the free parameters; a fixed scale remains 0.
bool Solve(const Normal& normal, bool scale, Similarity& out, Eigen::Matrix4d* inverse) {
  const int n = scale ? 4 : 3;
  const Eigen::MatrixXd a = normal.a.topLeftCorner(n, n);
  // Coordinates are hundreds of pixels: scale the equations so that the pivots can be compared.
  const Eigen::VectorXd d = a.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(d.asDiagonal() * a * d.asDiagonal());
  if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < 1e-6) return false;
  out.setZero();
  out.head(n) = d.asDiagonal() * ldlt.solve(d.asDiagonal() * normal.b.head(n));
  if (inverse != nullptr) {
    inverse->setZero();
    inverse->topLeftCorner(n, n) =
        d.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(n, n)) * d.asDiagonal();
  }
  return true;
}

ImageMotion ToMotion(const Similarity& p) {
  return {p[0], p[1], p[2], std::exp(p[3])};
}

}  // namespace

MotionFit FindConsensus(const std::vector<BlockShift>& blocks, const FitParams& params) {
  MotionFit best;
  double best_score = 0;
  Similarity best_parameters = Similarity::Zero();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (std::size_t j = i + 1; j < blocks.size(); ++j) {
      Similarity candidate;
      if (!FromPair(blocks[i], blocks[j], params.estimate_scale, candidate)) continue;
      double score = 0;
      for (const BlockShift& block : blocks) {
        const double ratio = Distance(block, candidate) / params.inlier_px;
        if (ratio < 1) score += block.signal * block.peak * (1 - ratio * ratio);
      }
      if (score > best_score) {
        best_score = score;
        best_parameters = candidate;
      }
    }
  }
  if (best_score <= 0) return best;
  best.weights.resize(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    best.weights[i] = Distance(blocks[i], best_parameters) < params.inlier_px ? 1.0 : 0.0;
    best.inliers += best.weights[i] > 0 ? 1 : 0;
  }
  Similarity refined;
  if (Solve(Accumulate(blocks, best.weights), params.estimate_scale, refined, nullptr)) {
    best_parameters = refined;
  }
  best.ok = best.inliers >= 3;
  best.motion = ToMotion(best_parameters);
  return best;
}

MotionFit FitRobust(const std::vector<BlockShift>& blocks,
                    const FitParams& params,
                    const std::vector<double>& start_weights) {
  MotionFit fit;
  fit.weights = start_weights.empty() ? std::vector<double>(blocks.size(), 1.0) : start_weights;
  if (blocks.size() < 3) return fit;
  Similarity parameters = Similarity::Zero();
  Eigen::Matrix4d inverse;
  std::vector<double> distances(blocks.size());
  std::vector<double> standard(blocks.size());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Similarity next;
    if (!Solve(Accumulate(blocks, fit.weights), params.estimate_scale, next, &inverse)) return fit;
    const double change = (next - parameters).head<2>().norm();
    parameters = next;
    for (std::size_t i = 0; i < blocks.size(); ++i) distances[i] = Distance(blocks[i], parameters);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      standard[i] = distances[i] * std::sqrt(blocks[i].quality);
    }
    // Median of |r| of a 2-D normal deviate is 1.1774 sigma.
    fit.sigma_px = std::max(kSigmaFloorPx, Median(standard) / 1.1774);
    const double cut = 4.685 * fit.sigma_px;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double u = standard[i] / cut;
      fit.weights[i] = u < 1 ? (1 - u * u) * (1 - u * u) : 0.0;
    }
    if (iteration > 1 && change < 1e-5) break;
  }
  double squares = 0;
  double total = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    squares += fit.weights[i] * standard[i] * standard[i];
    total += fit.weights[i];
    fit.inliers += distances[i] < params.inlier_px ? 1 : 0;
  }
  const double freedom = std::max(1.0, 2 * total - (params.estimate_scale ? 4 : 3));
  const double variance = std::max(squares / freedom, kSigmaFloorPx * kSigmaFloorPx);
  fit.covariance = variance * inverse;
  fit.motion = ToMotion(parameters);
  fit.ok = true;
  return fit;
}

}  // namespace ceilmap::registration
