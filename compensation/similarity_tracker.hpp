#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

/// Motion of the ceiling's image since a reference by the similarity model (rotation and shift),
/// which takes all frames as level: the sum of the motions between adjacent frames, by RI-POC. What
/// a tilt adds to it is the error of Matsumoto et al. 2010, Eq. (2) and (3). Adjacent frames differ
/// little in tilt; a tilted frame and a level one cannot be registered without keystone distortion
/// from about 2.5 degrees on.
class SimilarityTracker {
 public:
  /// An analysed image, which can become the reference.
  struct Frame {
    registration::AnalyzedImage image;         ///< a copy
    registration::ImageMotion from_reference;  ///< as measured
  };

  /// @param view  View of a rig; must outlive the tracker.
  explicit SimilarityTracker(const calib::CeilingView& view);

  /// @param image  CV_8UC1, rectified.
  Frame Analyze(const cv::Mat& image, const registration::Encoding& encoding = {});
  /// Measures a frame against the last one that was measured, and sets frame.from_reference.
  /// @return p_reference = T_reference_base * p_base of a robot that was level in both; nothing
  ///   without a reference, or when the images cannot be registered.
  std::optional<Pose2> Measure(Frame& frame);
  /// True when the image has no texture that another frame could be compared with.
  [[nodiscard]] bool IsBare(const Frame& frame);
  /// Makes this frame the reference. @param frame  one that was measured against the present
  ///   reference.
  void SetReference(const Frame& frame);
  /// Makes a frame the reference that was not measured, as the first one.
  void Restart(const Frame& frame);

 private:
  registration::Registration Register(Frame& frame);

  const calib::CeilingView& view_;
  registration::Registrar registrar_;
  std::optional<Frame> last_;
  std::optional<registration::ImageMotion> step_;  // to the last frame from the one before
};

}  // namespace ceilmap::compensation
