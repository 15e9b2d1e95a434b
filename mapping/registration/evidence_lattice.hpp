#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ceilmap::registration {

/// Blocks overlap by half, and their noise is not white: the evidence counts the same content this
/// many times.
inline constexpr double kCountedTimes = 20;
/// Largest evidence of one block, nats.
inline constexpr float kMaxBlockNats = 20;

/// Evidence on a lattice of motions: shifts of whole pixels and turns, about a start.
struct EvidenceLattice {
  int reach = 0;         ///< shifts from -reach to reach, level px
  int turns = 0;         ///< turns from -turns to turns steps
  double turn_step = 0;  ///< rad
  std::vector<float> nats;

  [[nodiscard]] int Side() const { return 2 * reach + 1; }
  [[nodiscard]] std::size_t Index(int turn, int y, int x) const;
  [[nodiscard]] float At(int turn, int y, int x) const { return nats[Index(turn, y, x)]; }
};

/// A motion of the lattice.
struct EvidencePeak {
  int turn = 0;
  int y = 0;
  int x = 0;
  double nats = 0;   ///< evidence of the images
  double score = 0;  ///< the same and the log prior
};

/// The maximum of the quadratic form through the evidence around a peak, in lattice steps, and its
/// curvature.
/// @return false at the border of the lattice: there is none.
bool Settle(const EvidenceLattice& lattice,
            const EvidencePeak& peak,
            Eigen::Vector3d& offset,
            Eigen::Matrix3d& information);

/// Covariance in lattice steps. Along an edge the evidence is a ridge on which chance makes waves:
/// their curvature is no information.
/// @param information  Of Settle. @param blocks  whose evidence the lattice has.
Eigen::Matrix3d CovarianceOf(const Eigen::Matrix3d& information, std::size_t blocks);

}  // namespace ceilmap::registration
