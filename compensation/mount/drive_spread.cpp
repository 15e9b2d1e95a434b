#include "compensation/mount/drive_spread.hpp"

#include <array>
#include <utility>
#include <vector>

namespace ceilmap::mount {
namespace {

using calibration::Drive;
using calibration::DriveSolution;
using calibration::ViewPair;

using Covariance = decltype(DriveSolution::covariance);

// The pairs of each part, as many parts as `part_of` knows.
template <typename PartOf>
std::vector<Drive> Divide(const Drive& drive, std::size_t parts, const PartOf& part_of) {
  std::vector<Drive> divided(parts);
  for (Drive& part : divided) {
    part.cameras = drive.cameras;
    part.velocities = drive.velocities;
    part.starts = drive.starts;
  }
  for (const ViewPair& pair : drive.pairs) divided[part_of(pair)].pairs.push_back(pair);
  return divided;
}

// Mean square of the differences between the parts and the whole.
Covariance Spread(const calib::MountedCamera& up,
                  const std::vector<Drive>& parts,
                  const calibration::DriveUnknowns& unknowns,
                  const DriveSolution& whole) {
  Covariance sum = Covariance::Zero();
  int count = 0;
  for (const Drive& part : parts) {
    const DriveSolution solution = calibration::SolveDrive(up, part, unknowns);
    if (!solution.ok) continue;
    const calibration::CameraErrors difference = solution.errors - whole.errors;
    sum += difference * difference.transpose();
    ++count;
  }
  return count < 2 ? Covariance::Zero() : Covariance(sum / (count - 1));
}

}  // namespace

void AddSpreadOfParts(const calib::MountedCamera& up,
                      const Drive& drive,
                      const calibration::DriveUnknowns& unknowns,
                      DriveSolution& solution) {
  constexpr std::size_t kQuarters = 4;
  constexpr std::array kNear{2, 5};  // keyframes from one to the other
  Drive solved = drive;
  solved.cameras = solution.cameras;
  const std::size_t views = drive.cameras.size();
  const auto quarter = [&](const ViewPair& pair) {
    return static_cast<std::size_t>(pair.first + pair.second) * kQuarters / (2 * views);
  };
  const auto distance = [&](const ViewPair& pair) {
    const int apart = pair.second - pair.first;
    return static_cast<std::size_t>(apart > kNear[0]) + static_cast<std::size_t>(apart > kNear[1]);
  };
  // The quarters are independent: the whole is their mean.
  solution.covariance +=
      Spread(up, Divide(solved, kQuarters, quarter), unknowns, solution) / kQuarters +
      Spread(up, Divide(solved, kNear.size() + 1, distance), unknowns, solution);
}

}  // namespace ceilmap::mount
