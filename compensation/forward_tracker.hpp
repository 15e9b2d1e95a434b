#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/forward_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

/// What the forward camera measures between a frame (A of the paper, perhaps tilted) and the
/// reference (B, level).
struct ForwardMotion {
  /// tan(th1), th1 the depression angle at which the reference sees the point on the frame's level
  /// axis. > 0: the frame looks lower, nose down.
  double tan_shift = 0;
  /// Size of objects in the reference relative to the frame: > 1 when the reference was taken
  /// nearer to them.
  double zoom = 1;
  /// Rotation of the camera about its axis against the reference, rad. For a camera that looks
  /// straight ahead this is the roll of the robot. > 0: left side up.
  double roll_rad = 0;
  double sigma_tan_shift = 0;
  double sigma_zoom = 0;
  double sigma_roll_rad = 0;
  int inliers = 0;
  int blocks = 0;
};

/// Shift, rotation and zoom of the forward camera's image against a level keyframe, by RI-POC.
/// Moving objects are outliers in the agreement of the blocks. A frame that cannot be registered
/// with the keyframe is registered with the frame before (bridging).
class ForwardTracker {
 public:
  struct Frame {
    registration::FrameSpectrum spectrum;
    double stamp_s = 0;
    registration::ImageMotion from_reference;  ///< as measured
    double variance_px2 = 0;                   ///< added to its shift by bridging frames
  };

  /// @param view  Must outlive the tracker.
  explicit ForwardTracker(const calib::ForwardView& view);

  [[nodiscard]] bool HasReference() const { return reference_.has_value(); }

  /// @param image  CV_8UC1, rectified.
  Frame Analyze(const cv::Mat& image, double stamp_s);
  /// Measures a frame against the reference, sets frame.from_reference, and stores the frame.
  /// @return nothing when registration fails: a dark, textureless or covered image, or another
  ///   place.
  std::optional<ForwardMotion> Measure(Frame& frame);
  /// True when the image has no texture that another frame could be compared with.
  [[nodiscard]] bool IsBare(const Frame& frame);
  /// Makes this frame, which may be an earlier one, the reference.
  void SetReference(const Frame& frame);

 private:
  [[nodiscard]] registration::ImageMotion Predict(double stamp_s) const;
  bool Against(Frame& from, Frame& frame, registration::Registration& found);
  [[nodiscard]] ForwardMotion Describe(const Frame& frame,
                                       const registration::Registration& found) const;

  const calib::ForwardView& view_;
  registration::Registrar registrar_;
  registration::Registrar following_;  // near a prediction
  std::optional<Frame> reference_;
  std::optional<Frame> last_;
  std::optional<Frame> before_;
};

}  // namespace ceilmap::compensation
