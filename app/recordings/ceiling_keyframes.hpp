#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::recordings {

/// An image of the ceiling that is kept to be measured.
struct CeilingKeyframe {
  cv::Mat raw;             ///< as the camera took it
  std::int64_t frame = 0;  ///< of the recording
  /// Rough pose of the camera, from image to image; units of the ceiling's distance.
  Pose2 T_first_camera;
};

/// Keyframes of a recording of the ceiling, each far enough from the one before, the first and the
/// last frame among them.
struct CeilingKeyframes {
  std::string source;
  std::vector<CeilingKeyframe> frames;
  std::int64_t read = 0;
  std::int64_t lost = 0;  ///< frames that matched nothing
};

/// Follows a recording image by image.
/// @param view  of the camera as far as it is known; tilts of a few degrees do no harm.
/// @throws InputError when the ceiling is lost for longer than a moment.
CeilingKeyframes ReadCeiling(FrameSource& source,
                             const calib::CeilingView& view,
                             const std::string& label);

/// Where both images of many pairs see the same places: of neighbours and of views farther apart,
/// as long as they overlap.
/// @param up  the camera as far as it is known. @param cameras  poses of the keyframes' cameras as
///   far as they are known. @param known  to a pixel or two over the image; else pairs are
///   brought closer first, tilt included.
calibration::Recording MeasureCeiling(const CeilingKeyframes& keyframes,
                                      const calib::MountedCamera& up,
                                      double ceiling_height_m,
                                      const std::vector<Pose2>& cameras,
                                      bool known);

}  // namespace ceilmap::recordings
