#include "compensation/mount/ceiling_registrar.hpp"

namespace ceilmap::mount {

registration::Registrar CeilingRegistrar(const calib::CeilingView& view) {
  registration::RegistrarParams params;
  SetForView(view, params);
  return registration::Registrar(view.Size(), params);
}

registration::PlaneMotion LevelMotion(const Pose2& T_reference_current) {
  registration::PlaneMotion motion;
  motion.x = T_reference_current.x;
  motion.y = T_reference_current.y;
  motion.yaw = T_reference_current.yaw;
  return motion;
}

registration::ImageMotion ImageMotionOf(const registration::PlaneCamera& camera,
                                        const Pose2& T_reference_current) {
  const registration::PlaneMotion plane = LevelMotion(T_reference_current);
  const Eigen::Vector2d centre = plane.Apply(camera, Eigen::Vector2d::Zero());
  return {centre.x(), centre.y(), -plane.yaw, 1};
}

}  // namespace ceilmap::mount
