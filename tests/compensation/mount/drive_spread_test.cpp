#include "compensation/mount/drive_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calib/solve/drive_world.hpp"

namespace ceilmap::mount {
namespace {

using calibration::Drive;
using calibration::DriveSolution;
using calibration::kCameraReadout;
using calibration::synthetic::DriveWorld;
using calibration::synthetic::Fisheye;

struct Deviations {
  double readout_s = 0;
  double before_s = 0;  ///< of the whole drive alone
  double after_s = 0;
};

Deviations Measure(const Drive& drive) {
  DriveSolution solution = calibration::SolveDrive(Fisheye(), drive, {});
  EXPECT_TRUE(solution.ok);
  Deviations result;
  const auto sigma = [&] { return std::sqrt(solution.covariance(kCameraReadout, kCameraReadout)); };
  result.readout_s = solution.errors[kCameraReadout];
  result.before_s = sigma();
  AddSpreadOfParts(Fisheye(), drive, {}, solution);
  result.after_s = sigma();
  return result;
}

/// A drive of whose pairs some show another read-out time.
Drive Mixed(double readout_s, double other_s, bool (*is_other)(const calibration::ViewPair&)) {
  Drive drive = DriveWorld({.readout_s = readout_s}).GetDrive();
  const Drive other = DriveWorld({.readout_s = other_s}).GetDrive();
  for (std::size_t i = 0; i < drive.pairs.size(); ++i) {
    if (is_other(drive.pairs[i])) drive.pairs[i] = other.pairs[i];
  }
  return drive;
}

TEST(DriveSpread, PartsThatAgreeAddNothing) {
  const Deviations found = Measure(DriveWorld({.readout_s = 0.02}).GetDrive());
  EXPECT_NEAR(found.readout_s, 0.02, 2e-4);
  EXPECT_LT(found.after_s, 2e-4);
}

TEST(DriveSpread, ErrorsThatChangeWithTimeAreInTheDeviation) {
  const Deviations found = Measure(Mixed(
      0.02, 0.01, [](const calibration::ViewPair& pair) { return pair.first + pair.second > 40; }));
  EXPECT_GT(found.after_s, 0.002);
  EXPECT_LT(found.after_s, 0.015);
  EXPECT_GT(found.after_s, found.before_s);
}

TEST(DriveSpread, ErrorsThatGrowWithTheDistanceAreInTheDeviation) {
  const Deviations found = Measure(Mixed(
      0.02, 0.01, [](const calibration::ViewPair& pair) { return pair.second - pair.first < 3; }));
  EXPECT_GT(found.after_s, std::abs(found.readout_s - 0.02) / 2);
  EXPECT_GT(found.after_s, 0.003);
}

}  // namespace
}  // namespace ceilmap::mount
