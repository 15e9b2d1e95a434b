#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/wheels/dead_reckoning.hpp"
#include "calib/wheels/wheel_calibrator.hpp"
#include "localization/localizer.hpp"
#include "mapping/store/map_file.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "samples/simulator/scene.hpp"

/// A second robot in a simulated world, rendered on the fly and located on that world's map.
namespace ceilmap::bench {

/// From frame to frame.
constexpr double kPeriod_s = 0.1;

/// The world on another day, seen by another robot: higher camera, longer focal length, darker
/// images, more lamps off.
simulator::Scene AnotherRobot(simulator::Scene scene);

/// A world, its map and where that lies in the room.
struct World {
  /// @param file  its map; made from the scene's own drive, with progress on stderr, where there is
  /// none.
  World(const simulator::Scene& world, const std::filesystem::path& file);

  simulator::Scene scene;
  std::unique_ptr<store::MapReader> map;
  Pose2 T_map_room;
};

/// Random poses in the area that was driven through, the same for the same seed.
class Places {
 public:
  Places(const simulator::Scene& scene, unsigned seed);

  /// In the room.
  Pose2 Next();
  /// Frames of a robot that drives from such a pose at an even speed, 0.2 to 0.8 m/s, turning by up
  /// to 0.4 rad/s.
  std::vector<simulator::Frame> NextDrive(int frames);

 private:
  std::array<double, 4> area_;
  double exposure_time_s_;
  std::mt19937 random_;
};

/// One frame located, against the truth.
struct Visit {
  localization::Location location;
  Pose2 T_map_base;    ///< true
  double error_m = 0;  ///< of a placed frame
  double error_rad = 0;
  double nees = 0;  ///< normalised squared error of x and y, by the full covariance
  double milliseconds = 0;

  /// A placed frame within 0.05 m and 0.02 rad of the truth.
  [[nodiscard]] bool Right() const;
};

/// Wheels that report 2 % too much, with 1 % of noise after a metre and 2 degrees of yaw, and what
/// the robot learns of them.
class VisitorWheels {
 public:
  /// Motion since the frame before. @param carried  the wheels stood still meanwhile.
  std::optional<wheels::RelativeMotion> Move(double stamp_s,
                                             const Pose2& T_room_base,
                                             bool carried);
  void Learn(double stamp_s, const localization::Location& location);

 private:
  struct Last {
    double stamp_s;
    Pose2 T_room_base;
  };
  std::optional<Last> last_;
  Pose2 T_odom_base_;
  wheels::DeadReckoning reckoning_;
  wheels::WheelCalibrator calibrator_;
  std::mt19937 random_{5};
  std::normal_distribution<double> normal_;
};

/// Takes the images of frames and locates them, one after the other.
class Visitor {
 public:
  /// @param scene  of the visitor. @param world  must outlive the object.
  Visitor(const simulator::Scene& scene, const World& world, bool has_wheels = false);

  /// Forgets where the robot was.
  void SwitchOn();
  /// The robot is carried to the next frame.
  void Carry() { carried_ = true; }
  /// Renders and locates the frame, at the next moment of the visitor's clock.
  Visit Locate(const simulator::Frame& frame);

  [[nodiscard]] const simulator::Renderer& GetRenderer() const { return renderer_; }

 private:
  simulator::Renderer renderer_;
  const World& world_;
  std::unique_ptr<localization::Localizer> localizer_;
  std::optional<VisitorWheels> wheels_;
  bool carried_ = false;
  std::int64_t next_index_ = 0;
};

}  // namespace ceilmap::bench
