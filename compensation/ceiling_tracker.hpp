#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

/// Motion of a frame relative to a reference frame.
struct CeilingMotion {
  /// p_reference = T_reference_base * p_base. The reference is level: its z axis points up.
  Eigen::Isometry3d T_reference_base = Eigen::Isometry3d::Identity();
  /// Covariance of (pitch, roll), rad^2.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double overlap = 0;  ///< visible fraction of the reference's image, 0..1
  int inliers = 0;
  int blocks = 0;
  bool depth = false;  ///< the ceiling has depth: blocks are measured well over short travels only
};

/// Pitch and roll from the keystone (perspective) distortion of the ceiling. Many small blocks of a
/// level reference image are located in the current image, and the motion in space of a camera
/// under a plane is fitted to their displacements (Registrar::RefinePlane). The fit gives tilt,
/// height and position together. They are relative to the reference, so that they do not drift. No
/// forward camera is needed. Equations: compensation/README.md, "Tilt from the ceiling".
///
/// Where the ceiling has depth, things at other heights would be taken for a tilt. The reference
/// then has heights (FrameSpectrum::Heights), learned from level frames.
class CeilingTracker {
 public:
  /// An analysed image, which can become the reference.
  struct Frame {
    registration::AnalyzedImage image;                                   ///< a copy
    Eigen::Isometry3d T_reference_base = Eigen::Isometry3d::Identity();  ///< as measured
    double stamp_s = 0;
  };

  /// @param view  View of a rig; must outlive the tracker.
  explicit CeilingTracker(const calib::CeilingView& view);

  [[nodiscard]] bool HasReference() const { return !reference_.spectrum.empty(); }

  /// @param image  CV_8UC1, rectified. Stamps must increase. @param encoding  Kept in the spectrum.
  Frame Analyze(const cv::Mat& image, double stamp_s, const registration::Encoding& encoding = {});
  /// Measures a frame against the reference and stores its motion for the next prediction. Sets
  /// frame.T_reference_base. A second frame of the same stamp replaces the first.
  /// @return nothing when the motion cannot be measured; the stored motion is then discarded.
  std::optional<CeilingMotion> Measure(Frame& frame);

  /// True when the image has no texture that another frame could be compared with.
  [[nodiscard]] bool IsBare(const Frame& frame);

  /// Makes this level frame, which may be an earlier one, the reference. The stored motion is
  /// transformed into the new reference.
  void SetReference(const Frame& frame);
  /// The same for a tilted frame: `level` is its image drawn level (LevelView).
  void SetReference(const Frame& frame, const cv::Mat& level);

 private:
  struct Moment {
    PlanarTilt at;  // in the reference
    double stamp_s = 0;
  };
  [[nodiscard]] PlanarTilt Predict(double stamp_s) const;
  [[nodiscard]] registration::PlaneMotion ToMotion(const PlanarTilt& at) const;
  [[nodiscard]] Eigen::Isometry3d ToPose(const registration::PlaneMotion& motion) const;
  registration::PlaneFit Find(Frame& frame);
  registration::PlaneFit Fit(const Frame& frame, const registration::PlaneMotion& start);
  bool FindDepth(Frame& frame, const registration::PlaneFit& plane);
  registration::PlaneFit PreferLevel(const Frame& frame, const registration::PlaneFit& tilted);
  void LearnHeights(const registration::PlaneFit& fit);
  [[nodiscard]] bool IsSound(const registration::PlaneFit& fit, double coding_loss) const;
  [[nodiscard]] CeilingMotion Describe(const registration::PlaneFit& fit) const;
  void MoveTo(const Eigen::Isometry3d& T_reference_new);
  void TakeReference(const registration::AnalyzedImage& image, const Eigen::Isometry3d& T_old_new);

  const calib::CeilingView& view_;
  registration::PlaneCamera camera_;
  double distance_m_;  // of a level camera from the ceiling
  registration::Registrar registrar_;
  registration::AnalyzedImage reference_;  // its coarse part is made on demand
  cv::Mat reference_content_;              // mask of the pixels that have content; empty: all
  std::optional<Moment> last_;
  std::optional<Moment> before_;
};

}  // namespace ceilmap::compensation
