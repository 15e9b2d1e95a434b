#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/figures/figure.hpp"

namespace ceilmap::figures {

/// Figures that compare trajectories: over the mosaic, over time, over the distance travelled.

/// A pose in the figures: in the frame of the truth (or of the map, without a truth).
struct FigurePose {
  double time_s = 0;      ///< since the beginning of the comparison
  double distance_m = 0;  ///< along the true path, or the run's own without a truth
  double x = 0;
  double y = 0;
  double yaw_deg = 0;  ///< continuous beyond 180 degrees
  double pitch_deg = 0;
  double roll_deg = 0;
  double position_error_m = 0;  ///< >= 0; 0 without a truth
  double yaw_error_deg = 0;     ///< estimate minus truth; 0 without a truth
};

/// Mean error of the motion over segments of one length.
struct SegmentError {
  double length_m = 0;
  double translation_ratio = 0;  ///< relative to the length, 0.01: 1 %
  double rotation_deg_per_m = 0;
};

struct FigureRun {
  std::string name;
  std::vector<FigurePose> poses;  ///< by time
  std::vector<SegmentError> segments;
};

/// An image below the paths.
struct FigureMosaic {
  std::string file;  ///< PNG in the folder of the figures
  double min_x = 0;  ///< of its lower left corner, in the frame of the paths
  double min_y = 0;
  double metres_per_px = 0;  ///< > 0
};

struct TrajectoryComparison {
  std::vector<FigurePose> truth;  ///< empty: none, and no figures of errors
  /// A run without tilt compensation, with the yaw and tilt of the truth; empty: none.
  std::vector<FigurePose> before;
  std::vector<FigureRun> runs;  ///< at least one, each with at least one pose
  std::optional<FigureMosaic> mosaic;
  std::string unit = "m";  ///< of lengths, "m" or "px"
};

/// In the order of drawing (the data of all figures belong to the first one): `trajectories` (over
/// the mosaic), `poses` (x, y, yaw over time, and pitch and roll if a pose is tilted); and with a
/// truth `errors` (over time), `errors-way` (over the distance travelled), `error-map` (as colour
/// along the paths), `distribution` (boxes, and the fraction of frames below an error), and
/// `segments` if runs have them.
///
/// A curve has at most a few thousand points: of each interval the first pose and the one with the
/// largest error. Boxes and distributions use all poses. Lines are interrupted where a run has no
/// pose for long.
std::vector<Figure> TrajectoryFigures(const TrajectoryComparison& comparison);

}  // namespace ceilmap::figures
