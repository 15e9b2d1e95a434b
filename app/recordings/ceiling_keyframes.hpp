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

/// An image of the ceiling that is kept for measurements.
struct CeilingKeyframe {
  cv::Mat raw;             ///< as the camera took it
  std::int64_t frame = 0;  ///< index in the recording
  /// Rough pose of the camera, from image to image; in units of the distance to the ceiling.
  Pose2 T_first_camera;
};

/// Keyframes of a recording of the ceiling, with a minimum distance between them; the first and the
/// last frame are included.
struct CeilingKeyframes {
  std::string source;
  std::vector<CeilingKeyframe> frames;
  std::int64_t read = 0;
  std::int64_t lost = 0;  ///< frames without a match
};

/// Tracks a recording image by image.
/// @param view  Of the approximate camera; tilt errors of a few degrees are allowed.
/// @throws InputError when tracking is lost for longer than a moment.
CeilingKeyframes ReadCeiling(FrameSource& source,
                             const calib::CeilingView& view,
                             const std::string& label);

/// Measures corresponding points of pairs of images: of neighbours, and of more distant views as
/// long as they overlap.
/// @param up  The approximate camera. @param cameras  Approximate poses of the keyframes' cameras.
/// @param known  True when these are accurate to one or two pixels over the image; otherwise pairs
/// are registered first, including the tilt.
calibration::Recording MeasureCeiling(const CeilingKeyframes& keyframes,
                                      const calib::MountedCamera& up,
                                      double ceiling_height_m,
                                      const std::vector<Pose2>& cameras,
                                      bool known);

}  // namespace ceilmap::recordings
