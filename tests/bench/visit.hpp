#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "calib/pose2.hpp"
#include "localization/localizer.hpp"
#include "mapping/map_file.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "samples/simulator/scene.hpp"

/// A second robot in a simulated world, rendered on the fly and located on that world's map.
namespace ceilmap::bench {

/// The world on another day, seen by another robot: higher camera, longer focal length, darker
/// pictures, more lamps off.
simulator::Scene AnotherRobot(simulator::Scene scene);

/// Where the map lies in the room: the planar motion that brings the keyframes to where they were
/// truly taken, least squares. @param mapping  the frames of the mapping run.
calib::Pose2 FindMap(const mapping::MapReader& map, const std::vector<simulator::Frame>& mapping);

/// Frames of a robot that drives at an even speed from a pose.
/// @param velocity  forward, to the left, turning: m/s, m/s, rad/s.
std::vector<simulator::Frame> Drive(const calib::Pose2& T_room_base,
                                    const Eigen::Vector3d& velocity,
                                    int frames,
                                    double period_s,
                                    const simulator::Scene& scene);

/// One frame located, against the truth.
struct Visit {
  localization::Location location;
  calib::Pose2 T_map_base;  ///< true
  double error_m = 0;       ///< of a placed frame
  double error_rad = 0;
  double nees = 0;  ///< normalised squared error of x and y, by the full covariance
  double milliseconds = 0;
};

/// Takes the pictures of frames and locates them, one after the other.
class Visitor {
 public:
  /// @param scene  of the visitor. @param T_map_room  of FindMap, inverted.
  Visitor(const simulator::Scene& scene,
          const mapping::MapReader& map,
          const calib::Pose2& T_map_room,
          const localization::LocalizerParams& params = {});

  /// Forgets where the robot was.
  void SwitchOn();
  /// Renders and locates the frame, at the next moment of the visitor's clock.
  Visit See(const simulator::Frame& frame);

  [[nodiscard]] localization::Localizer& GetLocalizer() { return *localizer_; }
  [[nodiscard]] const simulator::Renderer& GetRenderer() const { return renderer_; }

 private:
  simulator::Renderer renderer_;
  const mapping::MapReader& map_;
  calib::Pose2 T_map_room_;
  localization::LocalizerParams params_;
  std::unique_ptr<localization::Localizer> localizer_;
  std::int64_t next_index_ = 0;
};

calib::Pose2 Planar(const Eigen::Isometry3d& T);

}  // namespace ceilmap::bench
