#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::compensation {

struct CeilingTrackerParams {
  /// A fit is believed when at least this part of its blocks, and so many, lie within a pixel, and
  /// the others spread by less than this.
  double min_inlier_ratio = 0.4;
  int min_inliers = 10;
  double max_sigma_px = 0.4;
  /// ... and the tilt comes out better than this, rad. A fit that was begun too far off may settle
  /// beside the truth, where half of the blocks agree by chance, badly; it shows here.
  double max_sigma_rad = 5e-3;
  /// A fit that is worse than this is compared with one that was begun anew, rad.
  double vague_sigma_rad = 2e-3;
  /// Larger tilts are no debris but a wrong fit, rad.
  double max_tilt_rad = 0.25;
  /// What residuals cannot show (things below the ceiling, compression), rad, of pitch and roll.
  double systematic_rad = 1.5e-4;
  registration::RegistrarParams registration;
};

/// How a frame stands relative to a reference frame.
struct CeilingMotion {
  /// p_reference = T_reference_base * p_base, where the reference is level: its z is up. Nothing:
  /// the ceiling did not tell.
  Eigen::Isometry3d T_reference_base = Eigen::Isometry3d::Identity();
  /// Of (pitch, roll), rad^2.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double overlap = 0;  ///< part of the reference's image that is seen, 0..1
  int inliers = 0;
  int blocks = 0;
};

/// Pitch and roll from the key-stone of the ceiling (GEOMETRY section 4): many small blocks of a
/// level reference image are found again in the current one, and the motion of a camera in space
/// under a plane is fitted to where they went (Registrar::RefinePlane). Tilt, height and position
/// come out together, absolute against the reference. Needs no forward camera.
class CeilingTracker {
 public:
  /// An image that can become the reference.
  struct Frame {
    cv::Mat image;                                                       ///< a copy
    registration::FrameSpectrum spectrum;                                ///< of the fine stage
    Eigen::Isometry3d T_reference_base = Eigen::Isometry3d::Identity();  ///< as measured
    double stamp_s = 0;
  };

  /// @param view  of a rig; must outlive the tracker.
  explicit CeilingTracker(const calib::CeilingView& view, const CeilingTrackerParams& params = {});

  [[nodiscard]] bool HasReference() const { return !reference_.empty(); }

  /// @param image  CV_8UC1, rectified. Stamps must increase.
  Frame Analyze(const cv::Mat& image, double stamp_s);
  /// Measures a frame against the reference and remembers its motion for the next prediction.
  /// Sets frame.T_reference_base. @return nothing where the ceiling does not tell; what was known
  /// of the motion is then forgotten.
  std::optional<CeilingMotion> Measure(Frame& frame);

  /// Shows nothing that another frame could be compared with.
  [[nodiscard]] bool IsBare(const Frame& frame);

  /// From now on this level frame, which may be an earlier one, is the reference; the motion that
  /// is going on is taken along.
  void SetReference(const Frame& frame);
  /// The same for a frame that stood tilted: `level` is its image drawn level (LevelView).
  void SetReference(const Frame& frame, const cv::Mat& level);

 private:
  struct Moment {
    PlanarTilt at;  // in the reference
    double stamp_s = 0;
  };
  [[nodiscard]] PlanarTilt Predict(double stamp_s) const;
  [[nodiscard]] registration::PlaneMotion ToMotion(const PlanarTilt& at) const;
  [[nodiscard]] Eigen::Isometry3d ToPose(const registration::PlaneMotion& motion) const;
  registration::PlaneFit Find(const Frame& frame);
  [[nodiscard]] bool IsSound(const registration::PlaneFit& fit) const;
  [[nodiscard]] CeilingMotion Describe(const registration::PlaneFit& fit) const;
  void MoveTo(const Eigen::Isometry3d& T_reference_new);

  const calib::CeilingView& view_;
  CeilingTrackerParams params_;
  registration::PlaneCamera camera_;
  double distance_m_;  // of a level camera from the ceiling
  registration::Registrar registrar_;
  registration::FrameSpectrum reference_;
  cv::Mat reference_image_;
  registration::FrameSpectrum whole_reference_;  // with the coarse stage, once it was needed
  std::optional<Moment> last_;
  std::optional<Moment> before_;
};

}  // namespace ceilmap::compensation
