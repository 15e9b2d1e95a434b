#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <vector>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/heights/height_field.hpp"
#include "mapping/registration/motion_fit.hpp"

namespace ceilmap::registration {

class SharedNoise;

/// Pinhole geometry of the images: square pixels, no distortion.
struct PlaneCamera {
  double focal_px = 0;  ///< > 0
  /// Principal point from the image's centre ((W-1)/2, (H-1)/2), pixels.
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
};

/// The virtual camera of a view of a rig.
PlaneCamera PlaneCameraOf(const calib::CeilingView& view);

/// Motion of a camera below a plane to which the reference camera is perpendicular (level robot,
/// level ceiling). Axes of the reference's optical frame: x right, y down in the image, z up to the
/// ceiling. The unit of length is the distance of the reference camera from the plane, so that no
/// scale is needed:
///   p_ref = R p_cur + t,   R = Rz(yaw) Ry(tilt_y) Rx(tilt_x).
/// The induced motion of the image is the homography x_cur ~ K R' (I - t n' ) K^-1 x_ref with n =
/// (0, 0, 1).
struct PlaneMotion {
  double x = 0;  ///< t
  double y = 0;
  double height = 0;  ///< z of t: decrease of the distance from the plane
  double yaw = 0;     ///< rad
  double tilt_x = 0;  ///< rad, about the image's u axis
  double tilt_y = 0;  ///< rad, about the image's v axis

  /// Position of the reference pixel x in the current image; both relative to the image's centre.
  /// Only valid in front of the camera (tilts well below 90 degrees).
  /// @param rho  inverse height ratio of the point: the plane's distance from the reference camera
  /// divided by the point's. 1: in the plane; > 1: below it. x_cur ~ K R' (r - rho t).
  [[nodiscard]] Eigen::Vector2d Apply(const PlaneCamera& camera,
                                      const Eigen::Vector2d& x,
                                      double rho = 1) const;
  /// Derivative of Apply by x.
  [[nodiscard]] Eigen::Matrix2d Jacobian(const PlaneCamera& camera,
                                         const Eigen::Vector2d& x,
                                         double rho = 1) const;
  /// The motion without tilt that moves pixels like `motion`.
  static PlaneMotion FromSimilarity(const PlaneCamera& camera, const ImageMotion& motion);
  /// The inverse of FromSimilarity: what the motion does to the images of points in the plane when
  /// its tilts are left out.
  [[nodiscard]] ImageMotion ToSimilarity(const PlaneCamera& camera) const;
  /// How far it displaces the plane apart from its rotation, pixels.
  [[nodiscard]] double TravelPx(const PlaneCamera& camera) const {
    return camera.focal_px * std::hypot(x, y);
  }
};

/// Measurement of one block for a plane motion.
struct PlaneShift {
  BlockShift block;      ///< point and sharpness in the reference
  Eigen::Vector2d seen;  ///< the block's centre in the current image, from its centre
  Eigen::Matrix2d current_from_reference =
      Eigen::Matrix2d::Identity();  ///< local linear part of the sampling
  int index = -1;                   ///< of the block in its grid
  double rho = 1;                   ///< inverse height ratio with which it was sampled ...
  double rho_sigma = 0;             ///< ... and its standard deviation; 0: known
};

struct PlaneFitParams {
  bool fit_height = true;  ///< false: the camera keeps its height (tz = start.height)
  bool fit_tilt = true;    ///< false: level camera; tilts stay as they start
};

struct PlaneFit {
  bool ok = false;
  PlaneMotion motion;
  /// Of (x, y, height, yaw, tilt_x, tilt_y), from the residuals (README.md, "Covariance"); zero
  /// rows and columns for fixed parameters.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of (tilt_x, tilt_y) as if the blocks were independent: what limits of acceptance are compared
  /// with. The errors are larger.
  Eigen::Matrix2d tilt_spread = Eigen::Matrix2d::Zero();
  double sigma_px = 0;  ///< robust standard deviation of a fully informative block, one axis
  int inliers = 0;      ///< within 1 px ...
  int blocks = 0;       ///< ... out of this number
  /// Heights of the reference, refined as if the camera were level (tilt and height 0); only of a
  /// fit with depth.
  std::shared_ptr<const heights::HeightField> level_heights;
};

/// The fit's tilt as pitch and roll of base, for small tilts: within 0.01 degrees up to 4. The
/// covariance is the fit's own.
/// @param view  whose camera took the images.
TiltAngles TiltOf(const PlaneFit& fit, const calib::CeilingView& view);

/// Robust least squares (Ceres; Cauchy loss on a robust scale, estimated twice) of the plane motion
/// over all blocks; objects below the ceiling move by more than the plane and become outliers.
/// Starts from `start`, which should be within a few degrees. Needs at least 6 blocks.
/// @param shared  What the noise of the blocks has in common; nullptr: the covariance stays zero,
/// for a fit that only prepares another.
PlaneFit FitPlaneMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const PlaneFitParams& params = {},
                        const SharedNoise* shared = nullptr);

}  // namespace ceilmap::registration
