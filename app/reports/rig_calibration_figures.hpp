#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "app/figures/figure.hpp"
#include "calib/rig.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/up_mount.hpp"

namespace ceilmap::reports {

/// The camera's circle in the spin with what each view is off by, the straight drive's way aside
/// and its heading, and what is left at the places of each view.
std::vector<figures::Figure> RigFigures(const mount::UpMount& result);

/// The mean of the spin's images, brought together as the rig has it: sharp where the rig is
/// right, smeared where it is not. CV_8UC1, 0 where no image looked.
/// @param up  the upward camera of that rig. @param headings  of the views, rad.
cv::Mat SpinMosaic(const mount::CeilingRecording& spin,
                   const std::vector<Pose2>& headings,
                   const calib::MountedCamera& up,
                   double ceiling_height_m,
                   double axle_behind_mast_m);

}  // namespace ceilmap::reports
