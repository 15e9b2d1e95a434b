#include "calib/rig_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/lens_checks.hpp"
#include "calib/rotation_slip.hpp"
#include "calib/unit_slip.hpp"

namespace ceilmap::calib {
namespace {

constexpr double kMinCeilingM = 0.3;  // also the least distance of camera and ceiling
constexpr double kMaxCeilingM = 60;
constexpr double kMaxAsideM = 3;   // of the axle and of a camera from the mast
constexpr double kMaxHeightM = 5;  // of a camera
constexpr double kMinHeightM = 0.01;
constexpr UsualLengths kUsualCeiling{1.5, 15};
constexpr UsualLengths kUsualAxle{0.06, 1};
constexpr UsualLengths kUsualLength{0.06, kMaxAsideM};

constexpr double kSameM = 0.001;
constexpr double kSameHeightM = 0.02;

constexpr const char* kMetres = "millimetres or centimetres? lengths are in metres";

std::string VectorText(const Eigen::Vector3d& v) {
  return fmt::format("[{:g}, {:g}, {:g}]", v.x(), v.y(), v.z());
}

double AngleOf(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Collects the warnings about one rig.
class RigChecks {
 public:
  explicit RigChecks(const Rig& rig) : rig_(rig) {}

  std::vector<std::string> Run() && {
    CheckCeiling();
    CheckAxle();
    CheckForwardHeight();
    CheckCamera("up", rig_.up);
    CheckCamera("forward", rig_.forward);
    CheckCamera("omni", rig_.omni);
    if (rig_.up) CheckUpAxis(*rig_.up);
    if (rig_.forward) CheckForwardAxis(*rig_.forward);
    if (rig_.omni) CheckOmni(*rig_.omni);
    return std::move(warnings_);
  }

 private:
  template <typename... Args>
  void Warn(fmt::format_string<Args...> text, Args&&... args) {
    const std::string file = rig_.file.empty() ? "rig" : rig_.file.string();
    warnings_.push_back(file + ": " + fmt::format(text, std::forward<Args>(args)...));
  }

  void WarnOfUnit(const char* key, double value, const UsualLengths& usual) {
    const auto unit = UnitOf(value, usual);
    Warn("{} = {:g}: {}",
         key,
         value,
         unit ? fmt::format("{}? lengths are in metres: {} = {:.6g}",
                            unit->name,
                            key,
                            value / unit->per_metre)
              : kMetres);
  }

  void CheckCeiling() {
    const double h = rig_.ceiling_height_m;
    if (h > kMaxCeilingM) {
      WarnOfUnit("h", h, kUsualCeiling);
    } else if (h < kMinCeilingM) {
      Warn("h = {:g}: the height of the ceiling above the floor, in metres, is hardly below {:g}",
           h,
           kMinCeilingM);
    } else if (rig_.up) {
      const double z = rig_.up->T_base_cam.translation().z();
      if (h - z >= kMinCeilingM) return;
      Warn(
          "h = {:g}: only {:.3g} m above the upward camera (z = {:g}): was h measured from the "
          "camera? it is measured from the floor",
          h,
          h - z,
          z);
    }
  }

  void CheckAxle() {
    const double a = rig_.axle_behind_mast_m;
    if (std::abs(a) > kMaxAsideM) {
      WarnOfUnit("a", a, kUsualAxle);
    } else if (rig_.up && std::abs(a) > kSameM) {
      const double x = rig_.up->T_base_cam.translation().x();
      if (std::abs(a - x) > kSameM) return;
      Warn(
          "a = {:g}, and the upward camera has x = {:g} too: is the same distance counted twice? a "
          "is measured from the origin of base, not from the camera; with base at the axle, a is 0",
          a,
          x);
    }
  }

  void CheckForwardHeight() {
    if (!rig_.forward_height_m) return;
    const double d = *rig_.forward_height_m;
    if (!rig_.forward) {
      if (!rig_.up || std::abs(d - rig_.up->T_base_cam.translation().z()) > kSameHeightM) return;
      Warn(
          "d = {:g}: is the height of a forward camera, but there is no cameras.forward; the "
          "height "
          "of the upward camera is z of its pose",
          d);
    } else if (d > kMaxHeightM) {
      WarnOfUnit("d", d, kUsualLength);
    } else {
      const double z = rig_.forward->T_base_cam.translation().z();
      if (std::abs(d - z) <= kSameHeightM) return;
      Warn(
          "d = {:g}, but the pose of cameras.forward has z = {:g}: both are its height above the "
          "floor",
          d,
          z);
    }
  }

  void CheckCamera(const char* name, const std::optional<MountedCamera>& camera) {
    if (!camera) return;
    CheckPosition(name, camera->T_base_cam.translation());
    CheckExposure(name, camera->exposure_time_s);
    if (camera->mirror_ring) return;
    const std::string slip =
        camera->mirror ? MirrorSlip(camera->camera, *camera->mirror) : LensSlip(camera->camera);
    if (!slip.empty()) Warn("cameras.{}: {}", name, slip);
  }

  void CheckPosition(const char* name, const Eigen::Vector3d& t_base_cam) {
    const double z = t_base_cam.z();
    if (t_base_cam.head<2>().cwiseAbs().maxCoeff() > kMaxAsideM || z > kMaxHeightM) {
      const auto unit = UnitOf(t_base_cam.cwiseAbs().maxCoeff(), kUsualLength);
      Warn("cameras.{}: its pose has the translation {}: {}",
           name,
           VectorText(t_base_cam),
           unit ? fmt::format("{}? lengths are in metres: {}",
                              unit->name,
                              VectorText(t_base_cam / unit->per_metre))
                : kMetres);
    } else if (z < kMinHeightM) {
      Warn("cameras.{}: z = {:g} in its pose: is its height above the floor missing?", name, z);
    } else if (z >= rig_.ceiling_height_m) {
      Warn("cameras.{}: z = {:g} in its pose is above the ceiling (h = {:g})",
           name,
           z,
           rig_.ceiling_height_m);
    }
  }

  void CheckExposure(const char* name, double exposure_s) {
    constexpr double kMaxExposureS = 0.5;
    constexpr double kMinMicroseconds = 500;
    if (exposure_s <= kMaxExposureS) return;
    const bool micro = exposure_s >= kMinMicroseconds;
    Warn("cameras.{}: exposure_time = {:g}: {}? it is in seconds: {:g}",
         name,
         exposure_s,
         micro ? "microseconds" : "milliseconds",
         exposure_s / (micro ? 1e6 : 1e3));
  }

  void CheckUpAxis(const MountedCamera& up) {
    constexpr double kMaxTilt = 20 * kRadPerDeg;
    const double tilt = AngleOf(up.T_base_cam.linear()(2, 2));
    if (tilt <= kMaxTilt) return;
    Warn(
        "cameras.up: its optical axis is {:.0f} deg from the vertical; cameras that look at the "
        "ceiling are mounted within some degrees: check the rotation of its pose",
        tilt * kDegPerRad);
  }

  void CheckForwardAxis(const MountedCamera& forward) {
    const Eigen::Matrix3d& R = forward.T_base_cam.linear();
    if (!PointsAhead(R)) {
      std::string slip = RotationSlip(R, PointsAhead);
      if (PointsUp(R) && slip.empty()) slip = "is it the upward camera?";
      WarnOfAxis("forward", "point ahead", AngleOf(R(0, 2)), slip);
    } else if (R(2, 1) > 0.5) {  // y_cam, down in the image, points up
      Warn(
          "cameras.forward: its image is upside down by its pose; if it is not, y_cam is down in "
          "the image: check the signs of the rotation");
    }
  }

  void CheckOmni(const MountedCamera& omni) {
    const Eigen::Matrix3d& R = omni.T_base_cam.linear();
    if (!PointsUp(R)) WarnOfAxis("omni", "point up", AngleOf(R(2, 2)), RotationSlip(R, PointsUp));
    if (omni.mirror || omni.mirror_ring) return;
    Warn(
        "cameras.omni: is of type pinhole; a camera under a mirror is of type hyperbolic_mirror or "
        "mirror");
  }

  void WarnOfAxis(const char* name, const char* wanted, double angle_rad, const std::string& slip) {
    Warn("cameras.{}: its optical axis is {:.0f} deg off: it must {} (within 45 deg); {}",
         name,
         angle_rad * kDegPerRad,
         wanted,
         slip.empty() ? "check the rotation of its pose: p_base = R p_cam + t, z_cam along the view"
                      : slip);
  }

  const Rig& rig_;
  std::vector<std::string> warnings_;
};

}  // namespace

std::vector<std::string> RigWarnings(const Rig& rig) {
  return RigChecks(rig).Run();
}

}  // namespace ceilmap::calib
