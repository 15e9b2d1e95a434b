#include "compensation/tilt_model.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap::compensation {
namespace {

constexpr double kMinHeightPerPivot = 1.1;

void CheckTilt(double tilt_rad) {
  if (!(std::abs(tilt_rad) <= kMaxTiltRad)) {
    throw InputError(
        fmt::format("tilt model: tilt_rad = {}, must be in [-pi/4, pi/4]; give radians", tilt_rad));
  }
}

}  // namespace

TiltModel::TiltModel(double pivot_m, double ceiling_height_m)
    : pivot_m_(pivot_m), ceiling_height_m_(ceiling_height_m) {
  if (!std::isfinite(pivot_m)) {
    throw InputError(
        fmt::format("tilt model: pivot_m = {}, must be finite; correct a in the rig", pivot_m));
  }
  if (!(std::isfinite(ceiling_height_m) && ceiling_height_m > 0 &&
        ceiling_height_m > kMinHeightPerPivot * std::abs(pivot_m))) {
    throw InputError(
        fmt::format("tilt model: ceiling_height_m = {}, must be > 0 and > {} |pivot_m| = {}; "
                    "correct h or a in the rig, in metres",
                    ceiling_height_m,
                    kMinHeightPerPivot,
                    kMinHeightPerPivot * std::abs(pivot_m)));
  }
}

double TiltModel::CeilingShift(double tilt_rad) const {
  CheckTilt(tilt_rad);
  return (ceiling_height_m_ - pivot_m_ * std::sin(tilt_rad)) * std::tan(tilt_rad);
}

double TiltModel::MastLength(double tilt_rad, double camera_height_m) const {
  CheckTilt(tilt_rad);
  if (!(camera_height_m > 0 && camera_height_m < ceiling_height_m_)) {
    throw InputError(
        fmt::format("tilt model: camera_height_m = {}, must be between the floor and the ceiling "
                    "at {}; correct d in the rig, in metres",
                    camera_height_m,
                    ceiling_height_m_));
  }
  return camera_height_m + pivot_m_ * std::tan(tilt_rad);
}

double TiltModel::CameraHeight(double tilt_rad, double camera_height_m) const {
  return MastLength(tilt_rad, camera_height_m) * std::cos(tilt_rad);
}

double TiltModel::CameraHeightSlope(double tilt_rad, double camera_height_m) const {
  // L' cos(tilt) - L sin(tilt) with L' = a / cos(tilt)^2
  return pivot_m_ / std::cos(tilt_rad) - MastLength(tilt_rad, camera_height_m) * std::sin(tilt_rad);
}

double TiltModel::BaseShift(double tilt_rad, double camera_height_m, double seen_motion_m) const {
  return seen_motion_m + ceiling_height_m_ * std::tan(tilt_rad) -
         MastLength(tilt_rad, camera_height_m) * std::sin(tilt_rad);
}

double TiltModel::BaseShiftSlope(double tilt_rad, double camera_height_m) const {
  // (L sin(tilt))' = L' sin(tilt) + L cos(tilt) with L' = a / cos(tilt)^2
  const double s = std::sin(tilt_rad);
  const double c = std::cos(tilt_rad);
  return (ceiling_height_m_ - pivot_m_ * s) / (c * c) - MastLength(tilt_rad, camera_height_m) * c;
}

}  // namespace ceilmap::compensation
