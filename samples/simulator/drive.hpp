#pragma once

#include <array>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A drive along a polyline: straight lines, arcs and turns on the spot, with constant acceleration
/// and deceleration. Lines and arcs between two turns on the spot are driven without stopping.
class Drive {
 public:
  /// @param points_m  At least two; points closer than 1 mm to the one before are skipped.
  /// @param path  Gives speeds and the radius of the corners; at a corner without enough space the
  /// radius is smaller.
  Drive(const std::vector<std::array<double, 2>>& points_m, const Path& path);

  /// Duration of the drive in seconds; the robot is at rest at the start and the end.
  [[nodiscard]] double Duration() const;
  /// The axle's pose, T_map_axle, x along the drive. Before the start and after the end it is at
  /// rest.
  [[nodiscard]] Pose2 PoseAt(double time_s) const;
  /// Distance travelled by the axle in metres; a turn on the spot adds nothing.
  [[nodiscard]] double DistanceAt(double time_s) const;

 private:
  // A line, an arc or a turn on the spot.
  struct Piece {
    Pose2 start;
    double extent = 0;     // metres, radians for a turn on the spot
    double curvature = 0;  // left turn in rad per metre; +-1 for a turn on the spot
    bool on_spot = false;
    double distance_m = 0;  // travelled before this piece
    [[nodiscard]] double DistanceTo(double along) const {
      return distance_m + (on_spot ? 0 : along);
    }
    [[nodiscard]] Pose2 At(double along) const;
  };
  // Pieces [first, last) that are driven with one acceleration and one deceleration.
  struct Stretch {
    std::size_t first = 0;
    std::size_t last = 0;
    double start_s = 0;
    double extent = 0;
    double speed = 0;  // maximum speed
    double acceleration = 0;
    [[nodiscard]] double Duration() const;
    [[nodiscard]] double Along(double time_s) const;
  };

  // Part of a piece.
  struct Place {
    std::size_t piece = 0;
    double along = 0;
  };

  void Add(Piece piece);
  void AddCorner(double turn_rad, double radius_m);
  void MakeStretches(const Path& path);
  [[nodiscard]] Place PlaceAt(double time_s) const;

  std::vector<Piece> pieces_;
  std::vector<Stretch> stretches_;
};

}  // namespace ceilmap::simulator
