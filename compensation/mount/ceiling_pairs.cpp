#include "compensation/mount/ceiling_pairs.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <utility>

#include "calib/ceiling_view.hpp"
#include "compensation/mount/ceiling_registrar.hpp"

namespace ceilmap::mount {
namespace {

using registration::PlaneMotion;

class PairRegistrar {
 public:
  PairRegistrar(const CeilingRecording& recording,
                const calib::MountedCamera& up,
                double ceiling_height_m)
      : view_(up, ceiling_height_m),
        camera_(registration::PlaneCameraOf(view_)),
        R_cam_view_(up.T_base_cam.linear().transpose() * view_.T_base_camera().linear()),
        registrar_(CeilingRegistrar(view_)) {
    cv::Mat buffer;
    for (const CeilingKeyframe& keyframe : recording.keyframes) {
      spectra_.push_back(registrar_.AnalyzeFine(view_.Rectify(keyframe.image, buffer)));
    }
  }

  std::vector<calibration::PointCorrespondence> Measure(std::size_t first,
                                                        std::size_t second,
                                                        const Pose2& T_first_second,
                                                        bool accurate) {
    PlaneMotion motion = LevelMotion(T_first_second);
    if (!accurate) {
      const registration::PlaneFit fit =
          registrar_.RefinePlane(spectra_[first], spectra_[second], camera_, motion);
      if (!fit.ok) return {};
      motion = fit.motion;
    }
    std::vector<calibration::PointCorrespondence> points;
    for (const registration::PlaneShift& shift :
         registrar_.MeasurePlane(spectra_[first], spectra_[second], camera_, motion)) {
      points.push_back(CorrespondenceOf(shift));
    }
    return points;
  }

  [[nodiscard]] double Overlap(const Pose2& T_first_second) const {
    return registration::OverlapOf(ImageMotionOf(camera_, T_first_second), view_.Size());
  }

 private:
  [[nodiscard]] Eigen::Vector2d Ray(const Eigen::Vector2d& px) const {
    const Eigen::Vector2d slope = (px - camera_.principal_px) / camera_.focal_px;
    return (R_cam_view_ * slope.homogeneous()).hnormalized();
  }

  [[nodiscard]] calibration::PointCorrespondence CorrespondenceOf(
      const registration::PlaneShift& shift) const {
    const Eigen::Matrix2d information = shift.block.quality * shift.block.sharpness;
    const Eigen::LLT<Eigen::Matrix2d> root(information + 1e-9 * Eigen::Matrix2d::Identity());
    return {Ray(shift.block.point), Ray(shift.seen), root.matrixU().toDenseMatrix()};
  }

  calib::CeilingView view_;
  registration::PlaneCamera camera_;
  Eigen::Matrix3d R_cam_view_;
  registration::Registrar registrar_;
  std::vector<registration::FrameSpectrum> spectra_;
};

}  // namespace

calibration::Recording MeasurePairs(const CeilingRecording& recording,
                                    const calib::MountedCamera& up,
                                    double ceiling_height_m,
                                    const std::vector<Pose2>& cameras,
                                    bool accurate) {
  constexpr std::array<std::size_t, 12> kDistances{1, 2, 3, 5, 8, 12, 18, 26, 36, 48, 62, 78};
  constexpr double kMinOverlap = 0.35;
  PairRegistrar registrar(recording, up, ceiling_height_m);
  calibration::Recording measured;
  for (const Pose2& camera : cameras) {
    measured.cameras.push_back(cameras.front().Inverse() * camera);
  }
  for (std::size_t first = 0; first < cameras.size(); ++first) {
    for (const std::size_t distance : kDistances) {
      const std::size_t second = first + distance;
      if (second >= cameras.size()) break;
      const Pose2 T_first_second = cameras[first].Inverse() * cameras[second];
      if (registrar.Overlap(T_first_second) < kMinOverlap) continue;
      calibration::ViewPair pair{static_cast<int>(first), static_cast<int>(second), {}};
      pair.places = registrar.Measure(first, second, T_first_second, accurate);
      if (!pair.places.empty()) measured.pairs.push_back(std::move(pair));
    }
  }
  return measured;
}

}  // namespace ceilmap::mount
