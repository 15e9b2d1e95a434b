#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/forward_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

struct ForwardTrackerParams {
  /// Of the shift and of the turn, beyond what residuals show: the scene is not at one distance.
  double systematic_px = 0.5;
  double systematic_rad = 4e-4;
  double systematic_zoom = 2e-3;
  /// Of what the zoom beyond 1 makes worse: the nearer the scene comes, the more its depth shows.
  /// Part of (zoom - 1), as shift over focal length and as turn.
  double depth_ratio = 0.01;
  registration::RegistrarParams registration;
};

/// What the forward camera shows between a frame (A of the paper, perhaps tilted) and the reference
/// (B, level).
struct ForwardMotion {
  /// tan(th1): the depression angle at which the reference sees the point that the frame has on its
  /// level axis. > 0: the frame looks lower, its nose is down.
  double tan_shift = 0;
  /// How much larger the reference shows things than the frame: > 1 when the reference was taken
  /// nearer to them.
  double zoom = 1;
  /// Of the camera about its axis against the reference, rad: the roll of a robot whose camera
  /// looks straight ahead, > 0: left side up.
  double roll_rad = 0;
  double sigma_tan_shift = 0;
  double sigma_zoom = 0;
  double sigma_roll_rad = 0;
  int inliers = 0;
  int blocks = 0;
};

/// Shift, turn and zoom of the forward camera's image by RI-POC, against a level keyframe. What
/// moves in view drops out of the blocks' agreement; what hides the keyframe from a frame is
/// bridged by the frame before.
class ForwardTracker {
 public:
  struct Frame {
    cv::Mat image;                         ///< a copy
    registration::FrameSpectrum spectrum;  ///< of the fine stage
    registration::FrameSpectrum whole;     ///< with the coarse stage, once it was needed
    double stamp_s = 0;
    registration::ImageMotion from_reference;  ///< as measured
    double variance_px2 = 0;                   ///< what bridging has added to its shift
  };

  /// @param view  must outlive the tracker.
  explicit ForwardTracker(const calib::ForwardView& view, const ForwardTrackerParams& params = {});

  [[nodiscard]] bool HasReference() const { return reference_.has_value(); }

  /// @param image  CV_8UC1, rectified.
  Frame Analyze(const cv::Mat& image, double stamp_s);
  /// Measures a frame against the reference, sets frame.from_reference, and remembers the frame.
  /// @return nothing where the image does not tell: dark, bare, covered, another place.
  std::optional<ForwardMotion> Measure(Frame& frame);
  /// Shows nothing that another frame could be compared with.
  [[nodiscard]] bool IsBare(const Frame& frame);
  /// From now on this frame, which may be an earlier one, is the reference.
  void SetReference(const Frame& frame);

 private:
  [[nodiscard]] registration::ImageMotion Predict(double stamp_s) const;
  bool Against(Frame& from, Frame& frame, registration::Registration& found);
  [[nodiscard]] ForwardMotion Describe(const Frame& frame,
                                       const registration::Registration& found) const;

  const calib::ForwardView& view_;
  ForwardTrackerParams params_;
  registration::Registrar registrar_;
  registration::Registrar following_;  // near a prediction
  std::optional<Frame> reference_;
  std::optional<Frame> last_;
  std::optional<Frame> before_;
};

}  // namespace ceilmap::compensation
