#include "mapping/registration/evidence_lattice.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace ceilmap::registration {
namespace {

// Curvature of the waves that chance makes in the evidence, nats per squared step and block.
constexpr double kWavesPerBlock = 0.5;
// Smallest information that counts as some, 1 / px^2 of the level.
constexpr double kMinInformation = 1e-4;

}  // namespace

std::size_t EvidenceLattice::Index(int turn, int y, int x) const {
  const int side = Side();
  return (static_cast<std::size_t>(turn + turns) * static_cast<std::size_t>(side) +
          static_cast<std::size_t>(y + reach)) *
             static_cast<std::size_t>(side) +
         static_cast<std::size_t>(x + reach);
}

bool Settle(const EvidenceLattice& lattice,
            const EvidencePeak& peak,
            Eigen::Vector3d& offset,
            Eigen::Matrix3d& information) {
  if (std::abs(peak.turn) >= lattice.turns || std::abs(peak.y) >= lattice.reach ||
      std::abs(peak.x) >= lattice.reach) {
    return false;
  }
  const auto at = [&](int dx, int dy, int dturn) -> double {
    return lattice.At(peak.turn + dturn, peak.y + dy, peak.x + dx);
  };
  const auto along = [&](int axis, int step) {
    return at(axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0);
  };
  const auto both = [&](int a, int b, int step_a, int step_b) {
    std::array<int, 3> d = {0, 0, 0};
    d.at(static_cast<std::size_t>(a)) = step_a;
    d.at(static_cast<std::size_t>(b)) = step_b;
    return at(d[0], d[1], d[2]);
  };
  Eigen::Vector3d gradient;
  for (int a = 0; a < 3; ++a) {
    gradient[a] = 0.5 * (along(a, 1) - along(a, -1));
    information(a, a) = 2 * at(0, 0, 0) - along(a, 1) - along(a, -1);
    for (int b = 0; b < a; ++b) {
      information(a, b) = information(b, a) =
          -0.25 * (both(a, b, 1, 1) - both(a, b, 1, -1) - both(a, b, -1, 1) + both(a, b, -1, -1));
    }
  }
  // Along an edge the evidence is a ridge, with some waves of noise.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  const Eigen::Vector3d values = eigen.eigenvalues().cwiseMax(kMinInformation);
  information = eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
  offset = information.inverse() * gradient;
  const double largest = offset.cwiseAbs().maxCoeff();
  if (largest > 1) offset /= largest;
  return true;
}

Eigen::Matrix3d CovarianceOf(const Eigen::Matrix3d& information, std::size_t blocks) {
  constexpr double kMin = 0.05;  // part of the information that is left
  Eigen::Matrix3d covariance = information.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance.topLeftCorner<2, 2>());
  const double waves = kWavesPerBlock * static_cast<double>(blocks);
  for (int i = 0; i < 2; ++i) {
    const double variance = eigen.eigenvalues()[i];
    const double left = std::max(1 - waves * variance, kMin);
    const Eigen::Vector2d axis = eigen.eigenvectors().col(i);
    covariance.topLeftCorner<2, 2>() += variance * (1 / left - 1) * axis * axis.transpose();
  }
  return kCountedTimes * covariance;
}

}  // namespace ceilmap::registration
