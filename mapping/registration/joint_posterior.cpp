#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mapping/registration/joint_stage.hpp"

namespace ceilmap::registration {
namespace {

// Evidence of chance: the best of the motions near a wrong one has a quarter of a nat per block, as
// all have, and this for the root of their number, nats.
constexpr double kMeanChanceNats = 0.25;
constexpr double kChanceNats = 6;
// Where either sign of a correlation counts, the mean doubles, and the deviation grows by the root
// of 0.5 / 0.3125, the variances of z^2/2 of both signs and of one.
constexpr double kBothSigns = 1.26;
// Content that is turned by less looks the same within a block, rad.
constexpr double kRigidTurn = 0.012;

}  // namespace

/// Evidence that the best of wrong motions has, nats.
double JointStage::Chance() const {
  const auto count = static_cast<double>(compared_);
  const double one_sign = kMeanChanceNats * count;
  const double beyond = kChanceNats * std::sqrt(count);
  return either_contrast_ ? 2 * one_sign + kBothSigns * beyond : one_sign + beyond;
}

/// Motions of the expectation's lattice whose own lattices cover it together; empty: too many.
std::vector<Eigen::Vector3d> JointStage::Centres(const Lattice& lattice,
                                                 double sigma_px,
                                                 double sigma_rad) const {
  // Of a part of the expectation the right motion may be outside, and one that is a period of the
  // ceiling away inside.
  constexpr double kCovered = 2.5;  // standard deviations
  static constexpr int kMaxCentres = 75;
  const auto on_each_side = [](double wanted, int reach) {
    const double lattices = std::ceil((wanted - reach) / (2 * reach + 1) - 1e-9);
    return static_cast<int>(std::clamp<double>(lattices, 0, kMaxCentres));
  };
  const int shifts = on_each_side(kCovered * sigma_px / frame_.factor, lattice.reach);
  const int turns = on_each_side(kCovered * sigma_rad / lattice.turn_step, lattice.turns);
  std::vector<Eigen::Vector3d> centres;
  if ((2 * shifts + 1) * (2 * shifts + 1) * (2 * turns + 1) > kMaxCentres) return centres;
  const int turn_side = 2 * lattice.turns + 1;
  for (int turn = -turns; turn <= turns; ++turn) {
    for (int y = -shifts; y <= shifts; ++y) {
      for (int x = -shifts; x <= shifts; ++x) {
        centres.emplace_back(x * lattice.Side(), y * lattice.Side(), turn * turn_side);
      }
    }
  }
  return centres;
}

/// Adds the posterior over one lattice.
/// @param centre  of the lattice, from the expectation, lattice steps.
/// @param information  of the expectation, lattice steps.
void JointStage::Accumulate(const Lattice& lattice,
                            const Eigen::Vector3d& centre,
                            const Eigen::Matrix3d& information,
                            Moments& moments) const {
  const double chance = Chance();
  const Eigen::Vector2d middle =
      Eigen::Rotation2Dd(centre.z() * lattice.turn_step) * centre.head<2>();
  for (int turn = -lattice.turns; turn <= lattice.turns; ++turn) {
    const double at_turn = centre.z() + turn;
    const Eigen::Matrix2d turned =
        Eigen::Rotation2Dd(at_turn * lattice.turn_step).toRotationMatrix();
    for (int y = -lattice.reach; y <= lattice.reach; ++y) {
      for (int x = -lattice.reach; x <= lattice.reach; ++x) {
        Eigen::Vector3d at;
        at << middle + turned * Eigen::Vector2d(x, y), at_turn;
        const double nats = (lattice.At(turn, y, x) - chance) / kCountedTimes;
        // Or this image tells nothing.
        const double weight = (1 + std::exp(nats)) * std::exp(-0.5 * at.dot(information * at));
        moments.weight += weight;
        moments.sum += weight * at;
        moments.squares += weight * at * at.transpose();
      }
    }
  }
}

Registration JointStage::Posterior(const Images& images,
                                   const ImageMotion& expected,
                                   const Eigen::Matrix3d& covariance) {
  Registration result;
  result.jointly = true;
  result.motion = expected;
  ImageMotion start = frame_.FromFull(expected);
  start.scale = 1;
  const double sigma_px = std::sqrt(covariance.topLeftCorner<2, 2>().trace());
  const double sigma_rad = std::sqrt(covariance(2, 2));
  Lattice lattice = LatticeFor(sigma_px, sigma_rad);
  const Eigen::Matrix3d axes = FullAxes(lattice, start);
  const Eigen::Matrix3d information = axes.transpose() * covariance.inverse() * axes;
  Moments moments;
  bool tells = false;
  for (const Eigen::Vector3d& centre : Centres(lattice, sigma_px, sigma_rad)) {
    // Where nothing can be compared, the robot stays as likely as expected.
    const bool measured =
        MeasureEvidence(images, MotionAt(lattice, start, centre), kRigidTurn, lattice);
    const float most = *std::max_element(lattice.nats.begin(), lattice.nats.end());
    tells = tells || (measured && most >= Chance());
    Accumulate(lattice, centre, information, moments);
  }
  if (!tells) {
    // Chance must not narrow the expectation, nor must a part of it.
    if (!MeasureSurfaces(images, start, middle_)) return result;
    result.blocks = static_cast<int>(middle_.blocks.size());
    result.verdict = Verdict::kOk;
    result.covariance.topLeftCorner<3, 3>() = covariance;
    return result;
  }
  const Eigen::Vector3d mean = moments.sum / moments.weight;
  // The lattice is coarser than a narrow posterior.
  constexpr double kLatticeVariance = 1.0 / 12;
  const Eigen::Matrix3d spread = moments.squares / moments.weight - mean * mean.transpose() +
                                 kLatticeVariance * Eigen::Matrix3d::Identity();
  const ImageMotion found = Compose(start, {mean.x(), mean.y(), mean.z() * lattice.turn_step, 1});
  result.motion = frame_.ToFull(found);
  result.covariance.topLeftCorner<3, 3>() = axes * spread * axes.transpose();
  // What agrees there.
  lattice.reach = 0;
  lattice.turns = 0;
  if (!MeasureEvidence(images, found, kRigidTurn, lattice)) return result;
  result.verdict = Verdict::kOk;
  result.overlap = OverlapOf(found, frame_.size);
  result.blocks = static_cast<int>(middle_.blocks.size());
  result.inliers = CountAgreeing(lattice, {});
  const double all = kMaxBlockNats * result.blocks;
  result.peak = lattice.At(0, 0, 0) / all;
  result.runner_up = Chance() / all;
  return result;
}

}  // namespace ceilmap::registration
