#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/figures/figure.hpp"

namespace ceilmap::figures {

/// Figures that compare trajectories: over the mosaic, over time, over the way.

/// A pose as figures show it: brought into the frame of the truth (or of the map, without one).
struct FigurePose {
  double time_s = 0;      ///< since the comparison's beginning
  double distance_m = 0;  ///< along the true path, or the run's own without a truth
  double x = 0;
  double y = 0;
  double yaw_deg = 0;  ///< goes on beyond 180 degrees
  double pitch_deg = 0;
  double roll_deg = 0;
  double position_error_m = 0;  ///< >= 0; 0 without a truth
  double yaw_error_deg = 0;     ///< estimate less truth; 0 without a truth
};

/// Mean error of the motion over segments of one length.
struct SegmentError {
  double length_m = 0;
  double translation_ratio = 0;  ///< of the length, 0.01: 1 %
  double rotation_deg_per_m = 0;
};

struct FigureRun {
  std::string name;
  std::vector<FigurePose> poses;  ///< by time
  std::vector<SegmentError> segments;
};

/// An image that lies under paths.
struct FigureMosaic {
  std::string file;  ///< PNG in the folder of the figures
  double min_x = 0;  ///< of its lower left corner, in the frame of the paths
  double min_y = 0;
  double metres_per_px = 0;  ///< > 0
};

struct TrajectoryComparison {
  std::vector<FigurePose> truth;  ///< empty: there is none, and no figure of errors
  /// A run as it was without tilt compensation, its yaw and tilts those of the truth; empty: there
  /// is none.
  std::vector<FigurePose> before;
  std::vector<FigureRun> runs;  ///< at least one, each with at least one pose
  std::optional<FigureMosaic> mosaic;
  std::string unit = "m";  ///< of lengths, "m" or "px"
};

/// In this order, which is that of drawing (the first one brings the data of all):
/// `trajectories` (over the mosaic), `poses` (x, y, yaw over time, and pitch and roll where a pose
/// is tilted); and with a truth `errors` (over time), `errors-way` (over the way), `error-map` (as
/// colour along the paths), `distribution` (boxes, and the part of frames below an error), and
/// `segments` where runs have them.
///
/// A curve has at most a few thousand points however long the run: of each stretch the first pose
/// and the one with the largest error. Boxes and distributions are of all poses. Lines break where
/// a run has no pose for long.
std::vector<Figure> TrajectoryFigures(const TrajectoryComparison& comparison);

}  // namespace ceilmap::figures
