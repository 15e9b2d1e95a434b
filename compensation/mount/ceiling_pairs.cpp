#include "compensation/mount/ceiling_pairs.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "compensation/mount/ceiling_registrar.hpp"
#include "compensation/mount/steady_light.hpp"

namespace ceilmap::mount {
namespace {

using registration::PlaneMotion;

class PairRegistrar {
 public:
  PairRegistrar(const CeilingRecording& recording,
                const calib::MountedCamera& up,
                double ceiling_height_m,
                const KnownMotion& motion)
      : view_(up, ceiling_height_m),
        camera_(registration::PlaneCameraOf(view_)),
        lens_(up.camera),
        R_cam_view_(up.T_base_cam.linear().transpose() * view_.T_base_camera().linear()),
        registrar_(CeilingRegistrar(view_)) {
    const double distance_m = ceiling_height_m - up.T_base_cam.translation().z();
    cv::Mat buffer;
    for (std::size_t i = 0; i < recording.keyframes.size(); ++i) {
      velocities_.push_back(InBase(motion.velocities[i], view_.T_base_camera(), distance_m));
      spectra_.push_back(
          registrar_.Analyze(view_.Rectify(recording.keyframes[i].image, buffer, velocities_[i])));
      if (motion.heights.empty()) continue;
      spectra_.back().SetHeights(motion.heights[i] ? motion.heights[i] : Plane());
    }
  }

  std::vector<calibration::PointCorrespondence> Measure(std::size_t first,
                                                        std::size_t second,
                                                        const Pose2& T_first_second,
                                                        bool accurate,
                                                        int blocks) {
    PlaneMotion motion = LevelMotion(T_first_second);
    const bool deep = spectra_[first].Heights() != nullptr;
    if (!accurate && !deep) {
      const registration::PlaneFit fit =
          registrar_.RefinePlane(spectra_[first], spectra_[second], camera_, motion);
      if (!fit.ok) return {};
      motion = fit.motion;
    }
    std::vector<calibration::PointCorrespondence> points;
    const std::vector<registration::PlaneShift> shifts =
        deep ? registrar_.MeasureWithDepth(spectra_[first], spectra_[second], motion, blocks)
             : registrar_.MeasurePlane(spectra_[first], spectra_[second], camera_, motion);
    for (const registration::PlaneShift& shift : shifts) {
      const auto point = CorrespondenceOf(shift, velocities_[first], velocities_[second]);
      if (point) points.push_back(*point);
    }
    return points;
  }

  [[nodiscard]] double Overlap(const Pose2& T_first_second) const {
    return registration::OverlapOf(ImageMotionOf(camera_, T_first_second), view_.Size());
  }

 private:
  // All cells in the plane, as a first guess.
  [[nodiscard]] std::shared_ptr<const heights::HeightField> Plane() const {
    constexpr heights::HeightCell kInPlane{1, 0.05F};
    auto plane = std::make_shared<heights::HeightField>(registrar_.EmptyHeights());
    std::fill(plane->cells.begin(), plane->cells.end(), kInPlane);
    return plane;
  }

  // What shows a pixel of the view: a ray of the camera, and its row.
  struct RowRay {
    Eigen::Vector2d ray;
    double row = 0;
  };

  // The ray of the row that took the pixel: the view is drawn as at the time of the middle row.
  // @param px  From the middle of the view.
  [[nodiscard]] std::optional<RowRay> RowRayOf(const Eigen::Vector2d& px,
                                               const Twist2& velocity) const {
    const Eigen::Vector2d middle(0.5 * (view_.Size().width - 1), 0.5 * (view_.Size().height - 1));
    const std::optional<Eigen::Vector2d> raw = view_.RawPixel(middle + px, velocity);
    if (!raw) return std::nullopt;
    const double row = raw->y() / (lens_.height_px - 1) - 0.5;
    if (!view_.HasRollingShutter()) {
      const Eigen::Vector2d slope = (px - camera_.principal_px) / camera_.focal_px;
      return RowRay{(R_cam_view_ * slope.homogeneous()).hnormalized(), row};
    }
    const std::optional<Eigen::Vector3d> ray = lens_.Ray(*raw);
    if (!ray || ray->z() <= 0) return std::nullopt;
    return RowRay{ray->hnormalized(), row};
  }

  [[nodiscard]] std::optional<calibration::PointCorrespondence> CorrespondenceOf(
      const registration::PlaneShift& shift,
      const Twist2& first_velocity,
      const Twist2& second_velocity) const {
    const std::optional<RowRay> first = RowRayOf(shift.block.point, first_velocity);
    const std::optional<RowRay> second = RowRayOf(shift.seen, second_velocity);
    if (!first || !second) return std::nullopt;
    const Eigen::Matrix2d information = shift.block.quality * shift.block.sharpness;
    const Eigen::LLT<Eigen::Matrix2d> root(information + 1e-9 * Eigen::Matrix2d::Identity());
    return calibration::PointCorrespondence{first->ray,
                                            second->ray,
                                            first->row,
                                            second->row,
                                            root.matrixU().toDenseMatrix(),
                                            shift.index,
                                            shift.rho};
  }

  calib::CeilingView view_;
  registration::PlaneCamera camera_;
  calib::Lens lens_;
  Eigen::Matrix3d R_cam_view_;
  registration::Registrar registrar_;
  std::vector<Twist2> velocities_;  // of base, at the keyframes
  std::vector<registration::FrameSpectrum> spectra_;
};

}  // namespace

Twist2 InBase(const calibration::ViewVelocity& velocity,
              const Eigen::Isometry3d& T_base_camera,
              double distance_m) {
  const Eigen::Vector2d at = T_base_camera.translation().head<2>();
  const Eigen::Matrix2d R = T_base_camera.linear().topLeftCorner<2, 2>();
  return {
      distance_m * (R * velocity.linear) - velocity.yaw_rad_s * Eigen::Vector2d(-at.y(), at.x()),
      velocity.yaw_rad_s};
}

calibration::Recording MeasurePairs(const CeilingRecording& recording,
                                    const calib::MountedCamera& up,
                                    double ceiling_height_m,
                                    const KnownMotion& motion,
                                    bool accurate,
                                    int blocks) {
  constexpr std::array<std::size_t, 12> kDistances{1, 2, 3, 5, 8, 12, 18, 26, 36, 48, 62, 78};
  constexpr double kMinOverlap = 0.35;
  const std::vector<Pose2>& cameras = motion.cameras;
  PairRegistrar registrar(
      WithoutFlicker(recording, cameras, up, ceiling_height_m), up, ceiling_height_m, motion);
  calibration::Recording measured;
  measured.velocities = motion.velocities;
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
      pair.places = registrar.Measure(first, second, T_first_second, accurate, blocks);
      if (!pair.places.empty()) measured.pairs.push_back(std::move(pair));
    }
  }
  return measured;
}

}  // namespace ceilmap::mount
