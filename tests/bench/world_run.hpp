#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "app/files/tum.hpp"
#include "calib/base/pose2.hpp"
#include "compensation/tilt_estimator.hpp"
#include "mapping/mapper.hpp"
#include "samples/simulator/scene.hpp"

/// A simulated world, rendered on the fly and mapped: for worlds too large to keep as a recording.
namespace ceilmap::bench {

/// Cost of a stretch of a run.
struct CostSample {
  std::int64_t frame = 0;  ///< end of the stretch
  double map_m2 = 0;       ///< ceiling that the keyframes cover by then
  double wall_ms = 0;      ///< Mapper::Process of a frame, mean of the stretch
  double cpu_ms = 0;       ///< of all threads and a frame, rendering not counted
  double resident_mb = 0;  ///< of the process, the simulator included
};

/// A closure that the map kept, against the truth.
struct ClosureCheck {
  std::int64_t from = 0;
  std::int64_t to = 0;
  double error_m = 0;
};

struct WorldRun {
  std::vector<CostSample> curve;
  std::vector<StampedPose> truth;
  std::vector<StampedPose> estimate;
  std::vector<StampedPose> live;     ///< as the odometry had them, parts that were left out too
  std::vector<StampedPose> compass;  ///< its headings as yaw, where it was asked
  graph::MapGraph graph;
  mapping::MapperReport report;
  std::vector<ClosureCheck> closures;
  double peak_mb = 0;  ///< largest resident memory of the whole run, mosaic included
  double seconds = 0;  ///< mapping alone, from the first frame to the written map
  double file_mb = 0;
};

struct WorldOptions {
  int samples = 1;  ///< stretches of the curve
  std::function<void(std::int64_t, std::int64_t)> progress =
      {};  ///< done, total frames; may be empty
  /// How tilt is measured and taken out; unset: frames are taken as level. The forward camera is
  /// rendered where the method has use for it.
  std::optional<compensation::TiltMethod> tilt = {};
  bool omni = false;  ///< headings by the fft compass, from the camera under the mirror
};

/// @param file  the map, replaced.
WorldRun RunWorld(const simulator::Scene& scene,
                  const std::filesystem::path& file,
                  const WorldOptions& options = {});

}  // namespace ceilmap::bench
