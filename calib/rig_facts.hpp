#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// Full angles of what a camera sees, between the outer edges of its images, rad.
struct FieldOfView {
  double horizontal_rad = 0;
  double vertical_rad = 0;
  double diagonal_rad = 0;
};

/// What the values of an upward camera mean for a level robot.
struct UpFacts {
  std::optional<FieldOfView> field_of_view;  ///< nothing where the lens model is not valid
  double tilt_rad = 0;                       ///< of the optical axis from the vertical
  double distance_m = 0;                     ///< of camera and ceiling
  cv::Size view_px;                          ///< of the virtual upward image (CeilingView)
  FieldOfView view;                          ///< of that image
  double m_per_px = 0;                       ///< on the ceiling, in that image
  Eigen::Vector2d ceiling_m = Eigen::Vector2d::Zero();  ///< width and height of that image there
  /// Direction in base to which the top of the image points: 0 ahead, counter-clockwise seen from
  /// above, so that pi/2 is the robot's left.
  double top_yaw_rad = 0;
  double right_yaw_rad = 0;  ///< the same for the right of the image
  /// Points of the ceiling in base that the corners of the image show, of a wide lens those of the
  /// virtual image: top left, top right, bottom right, bottom left; nothing where the lens model is
  /// not valid or a ray does not meet it.
  std::optional<std::array<Eigen::Vector2d, 4>> corners_m;
};

/// The same of a forward camera.
struct ForwardFacts {
  std::optional<FieldOfView> field_of_view;
  double height_m = 0;       ///< above the floor
  double yaw_rad = 0;        ///< of its optical axis: 0 ahead, > 0 to the left
  double elevation_rad = 0;  ///< of its optical axis, > 0 above the horizon
  bool upside_down = false;
  /// Row of the image, from its top, that shows the horizon in the vertical plane of the optical
  /// axis; nothing where it is outside the image.
  std::optional<double> horizon_row_px;
};

/// The same of a camera under a mirror.
struct OmniFacts {
  double height_m = 0;
  double tilt_rad = 0;     ///< of the optical axis from the vertical
  double top_yaw_rad = 0;  ///< as UpFacts
  /// The known circles in the image, and their centre.
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double outer_radius_px = 0;
  std::optional<double> inner_radius_px;    ///< of a mirror of unknown shape
  std::optional<double> rim_elevation_rad;  ///< of a mirror of known shape: the highest it shows
};

struct RigFacts {
  std::optional<UpFacts> up;
  std::optional<ForwardFacts> forward;
  std::optional<OmniFacts> omni;
};

/// Derives what the values of a rig mean. An omni camera without a mirror is left out.
RigFacts DescribeRig(const Rig& rig);

}  // namespace ceilmap::calib
