#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "app/figures/figure.hpp"
#include "app/recordings/ceiling_keyframes.hpp"
#include "app/recordings/motion_calibration.hpp"
#include "app/recordings/rig_calibration.hpp"
#include "calib/rig.hpp"

namespace ceilmap::reports {

/// The camera's circle in the spin with the errors of the views, lateral position and heading on
/// the straight drive, and residuals of each view.
std::vector<figures::Figure> RigFigures(const recordings::RigCalibration& result);

/// The lift of the mast over the pitch, with the fitted lines of the pivots.
figures::Figure StepFigure(const recordings::StepCalibration& step);

/// The mean of the spin's images, aligned by the rig: sharp if the rig is correct, blurred if not.
/// CV_8UC1, 0 outside all images.
/// @param up  The upward camera of that rig. @param headings  Of the views, rad.
cv::Mat SpinMosaic(const recordings::CeilingKeyframes& spin,
                   const std::vector<Pose2>& headings,
                   const calib::MountedCamera& up,
                   double ceiling_height_m,
                   double axle_behind_mast_m);

}  // namespace ceilmap::reports
