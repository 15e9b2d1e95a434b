#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/registration/registration.hpp"

/// Planar motion of a level robot from the motion of its ceiling images, and the algebra around
/// it (GEOMETRY section 2).
namespace ceilmap::mapping {

/// T_ref_cur, p_ref = T_ref_cur * p_cur in base frames, from the motion that takes pixels of the
/// reference image to pixels of the current one. The scale is taken as 1 (one camera, level
/// floor).
Pose2 BaseMotion(const calib::CeilingView& view, const registration::ImageMotion& motion);

/// The inverse of BaseMotion: the image motion that a base motion causes.
registration::ImageMotion ImageMotionOf(const calib::CeilingView& view, const Pose2& T_ref_cur);

/// Part of the reference image that the current one shows too, 0..1 (registration::OverlapOf).
double OverlapOf(const calib::CeilingView& view, const Pose2& T_ref_cur);

/// Map units across an image's longer side.
double SpanOf(const calib::CeilingView& view);

/// Covariance of BaseMotion's (x, y, yaw), first order, from that of (tx_px, ty_px, theta_rad).
Eigen::Matrix3d BaseMotionCovariance(const calib::CeilingView& view,
                                     const registration::ImageMotion& motion,
                                     const Eigen::Matrix3d& image_covariance);

/// What the residuals of one registration cannot show, added to each edge's covariance:
/// compression, exposure time, things below the ceiling. From the errors of single registrations on
/// rendered recordings with exact truth.
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

/// How far off the foot of a robot stands whose tilt is not what it was taken for: by its height
/// under the ceiling times the error. Covariance of (x, y) in the reference frame, first order.
/// @param view  of a rig. @param tilt_covariance  of (pitch, roll), rad^2.
Eigen::Matrix2d TiltCovariance(const calib::CeilingView& view,
                               const Pose2& T_ref_base,
                               const Eigen::Matrix2d& tilt_covariance);

/// Adds to an edge's covariance what is not known of the tilt that was taken out of the image of
/// `to` (TiltCovariance).
void InflateTiltCovariance(const calib::CeilingView& view, const Tilt& tilt, graph::Edge& edge);

/// Adds a doubt of the place to an edge's covariance: the same in x and y. @param sigma  map units,
/// >= 0.
void InflatePlaceCovariance(double sigma, graph::Edge& edge);

}  // namespace ceilmap::mapping
