#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "app/figures/figure.hpp"
#include "calib/rig.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/up_mount.hpp"

namespace ceilmap::reports {

/// The camera's circle in the spin with the errors of the views, lateral position and heading on
/// the straight drive, and residuals of each view.
std::vector<figures::Figure> RigFigures(const mount::UpMount& result);

/// The mean of the spin's images, aligned by the rig: sharp if the rig is correct, blurred if not.
/// CV_8UC1, 0 outside all images.
/// @param up  The upward camera of that rig. @param headings  Of the views, rad.
cv::Mat SpinMosaic(const mount::CeilingRecording& spin,
                   const std::vector<Pose2>& headings,
                   const calib::MountedCamera& up,
                   double ceiling_height_m,
                   double axle_behind_mast_m);

}  // namespace ceilmap::reports
