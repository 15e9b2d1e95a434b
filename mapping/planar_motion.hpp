#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/registration/registration.hpp"

/// Planar motion of a level robot from the motion of its ceiling images, and related operations
/// (calib/README.md, "Motion of a level robot").
namespace ceilmap::mapping {

/// T_ref_cur, p_ref = T_ref_cur * p_cur in base frames, from the motion that takes pixels of the
/// reference image to pixels of the current one. The scale is taken as 1 (one camera, level
/// floor).
Pose2 BaseMotion(const calib::CeilingView& view, const registration::ImageMotion& motion);

/// The inverse of BaseMotion: the image motion that a base motion causes.
registration::ImageMotion ImageMotionOf(const calib::CeilingView& view, const Pose2& T_ref_cur);

/// Fraction of the reference image that is also visible in the current one, 0..1
/// (registration::OverlapOf).
double OverlapOf(const calib::CeilingView& view, const Pose2& T_ref_cur);

/// Map units across an image's longer side.
double SpanOf(const calib::CeilingView& view);

/// Covariance of BaseMotion's (x, y, yaw), first order, from that of (tx_px, ty_px, theta_rad).
Eigen::Matrix3d BaseMotionCovariance(const calib::CeilingView& view,
                                     const registration::ImageMotion& motion,
                                     const Eigen::Matrix3d& image_covariance);

/// Errors that the residuals of one registration do not show, added to each edge's covariance:
/// compression, exposure time, things below the ceiling. The values are the errors of single
/// registrations on rendered recordings with exact truth.
struct EdgeNoise {
  double systematic_px = 0.02;   ///< of tx and ty, > 0
  double systematic_rad = 3e-5;  ///< of the rotation, > 0
};

/// The edge that a registration (reference: keyframe `from`, current: keyframe `to`) measures.
graph::Edge MeasuredEdge(const calib::CeilingView& view,
                         const registration::Registration& registration,
                         std::int64_t from,
                         std::int64_t to,
                         const EdgeNoise& noise);

/// Covariance of the position of the robot's foot caused by an error of the tilt: the height under
/// the ceiling times the tilt error. Covariance of (x, y) in the reference frame, first order.
/// @param view  of a rig. @param tilt_covariance  of (pitch, roll), rad^2.
Eigen::Matrix2d TiltCovariance(const calib::CeilingView& view,
                               const Pose2& T_ref_base,
                               const Eigen::Matrix2d& tilt_covariance);

/// Adds to an edge's covariance the uncertainty of the tilt that was removed from the image of `to`
/// (TiltCovariance).
void InflateTiltCovariance(const calib::CeilingView& view, const Tilt& tilt, graph::Edge& edge);

/// Adds an uncertainty to an edge's covariance. @param sigma  standard deviation, equal in x and y,
/// map units, >= 0. @param sigma_yaw  rad, >= 0.
void InflateCovariance(double sigma, double sigma_yaw, graph::Edge& edge);

}  // namespace ceilmap::mapping
