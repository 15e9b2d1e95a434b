#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/view_velocities.hpp"
#include "mapping/heights/height_field.hpp"
#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::mount {

/// An image of the ceiling that is kept for the calibration.
struct CeilingKeyframe {
  cv::Mat image;  ///< CV_8UC1, as the camera took it
  /// Rough pose of the camera, from image to image: p_first = T_first_camera * p_camera, with x
  /// right and y down as in a level image. In units of the distance between ceiling and camera.
  Pose2 T_first_camera;
  /// Of the camera, in the same units. Of recordings without stamps: per interval between images.
  calibration::ViewVelocity velocity;
  double stamp_s = 0;  ///< of recordings without stamps: number of the image
  /// Of the view that followed the ceiling; nullptr: it looks plane.
  std::shared_ptr<const heights::HeightField> heights = nullptr;
};

/// A turn on the spot or a drive under the ceiling.
struct CeilingRecording {
  std::string name;  ///< for messages
  /// Among them the first and the last image that matched. At most 96.
  std::vector<CeilingKeyframe> keyframes;
  std::int64_t frames = 0;  ///< all images, with those that did not match
  bool has_stamps = false;  ///< of all images
  bool has_depth = false;   ///< most images show parts below the plane of the ceiling
};

/// Selects the keyframes of a recording: images that are at least a fixed distance or turn apart.
/// This distance is doubled, and every other keyframe removed, when they become too many.
class CeilingRecorder {
 public:
  /// @param name  of the recording, for messages.
  /// @param view  of the upward camera as far as it is known; errors of some degrees of tilt are
  ///   permitted. Must outlive the recorder.
  CeilingRecorder(const std::string& name, const calib::CeilingView& view);

  /// Registers the next image to the last keyframe, or to the last image if it is too far from
  /// that.
  /// @param image  CV_8UC1, as the camera took it, of the view's camera.
  /// @param stamp_s  Its time, later than that of the image before. Needed for the read-out time of
  ///   a rolling shutter; either all images have one, or none.
  /// @return false when it matches neither: the image is not used. Several consecutive ones mean
  ///   that the recording cannot be used.
  bool Add(const cv::Mat& image, std::optional<double> stamp_s = std::nullopt);

  /// The whole recording. To be called once, after the last image.
  CeilingRecording Finish();

 private:
  struct AnalyzedKeyframe {
    CeilingKeyframe keyframe;
    std::size_t path_index = 0;
    registration::FrameSpectrum spectrum;
  };

  std::optional<Pose2> Match(registration::FrameSpectrum& current);
  registration::Registration Register(const registration::FrameSpectrum& current,
                                      const Pose2& expected);
  std::optional<Pose2> Follow(const registration::FrameSpectrum& current, const Pose2& expected);
  [[nodiscard]] Twist2 ExpectedVelocity(double time_s) const;
  [[nodiscard]] bool IsFarFromKeyframe(const Pose2& T_key_current) const;
  void Keep(AnalyzedKeyframe frame);
  void KeepHeights();

  const calib::CeilingView& view_;
  registration::PlaneCamera camera_;
  registration::Registrar registrar_;
  cv::Mat buffer_;
  CeilingRecording recording_;
  std::int64_t matched_with_depth_ = 0;
  std::vector<TimedPose> path_;            // of all images that matched
  std::vector<std::size_t> path_indices_;  // of the keyframes
  AnalyzedKeyframe key_;
  std::optional<AnalyzedKeyframe> last_;  // unless it is the keyframe
  Pose2 T_first_last_;
  Pose2 step_;                 // from the image before to the last one, of those that matched
  double step_s_ = 0;          // and its time
  double min_distance_ratio_;  // between keyframes, of the image's diagonal
  double min_turn_rad_;
};

}  // namespace ceilmap::mount
