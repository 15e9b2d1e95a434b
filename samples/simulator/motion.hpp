#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/drive.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The pose of a robot that stands level on the floor.
Eigen::Isometry3d OnFloor(const Pose2& pose);

/// The robot's true motion at any time, as wheels and gyro measure it. Times are those of the scene
/// (StartStamp). The frame `path` is map, until the robot is carried away (Path::carried): the path
/// then goes on in its own frame, which has another place in map.
///
/// A planned drive is exact at any time. Between the poses of a file (PathKind::kTum) the position
/// and the angles yaw, pitch and roll are monotone cubic splines (Fritsch and Butland 1984) with
/// continuous velocity, so that a gyro shows no steps; a robot that stands between two equal poses
/// stands still.
class Motion {
 public:
  /// @param scene  Valid; stamps of poses of a file increase. @throws InputError when the scene is
  /// of PathKind::kTum and there are no poses.
  explicit Motion(const Scene& scene);

  /// T_path_base, tilted over debris. A planned drive is at rest before its start and after its
  /// end; beyond the poses of a file the velocity is that of its first or last moment.
  [[nodiscard]] Eigen::Isometry3d BaseAt(double time_s) const;
  /// T_path_axle: the middle of the axle, base x = -axle_behind_mast_m, on the floor.
  [[nodiscard]] Pose2 AxleAt(double time_s) const;

  /// T_map_path of the last time that the robot was carried away; nothing before the first.
  [[nodiscard]] std::optional<Eigen::Isometry3d> CarriedAt(double time_s) const;

 private:
  // x, y, z, yaw, pitch, roll; angles without jumps.
  using Channels = std::array<double, 6>;
  struct Knot {
    double time_s = 0;
    Channels value{};
    Channels rate{};
  };
  struct Carry {
    double at_s = 0;
    Eigen::Isometry3d T_map_path;
  };

  void MakeKnots(const Path& path);
  [[nodiscard]] Eigen::Isometry3d BetweenKnots(double time_s) const;

  Debris debris_;
  double axle_behind_mast_m_;
  std::optional<Drive> drive_;  // unless the poses are those of a file
  std::vector<Knot> knots_;
  std::vector<Carry> carries_;
};

}  // namespace ceilmap::simulator
