#include "app/evaluation/pose_errors.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/degrees.hpp"

namespace ceilmap::evaluation {
namespace {

// Accurate also near 0, where the arc cosine of the trace is not. The quaternion may have any
// length.
double AngleOf(const Eigen::Quaterniond& rotation) {
  return 2 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

}  // namespace

double PoseError::RotationPart() const {
  // trace((R - I)^T (R - I)) = 6 - 2 trace(R) = 4 - 4 cos(angle)
  return 2 * std::numbers::sqrt2 * std::sin(angle_rad / 2);
}

double PoseError::Full() const {
  return std::hypot(RotationPart(), translation_m);
}

PoseError AbsoluteError(const PosePair& pair) {
  return {(pair.estimate.position - pair.truth.position).norm(),
          AngleOf(pair.estimate.orientation.conjugate() * pair.truth.orientation)};
}

PoseError RelativeError(const PosePair& i, const PosePair& j) {
  const auto turn = [](const StampedPose& from, const StampedPose& to) {
    return from.orientation.conjugate() * to.orientation;
  };
  const auto shift = [](const StampedPose& from, const StampedPose& to) -> Eigen::Vector3d {
    return from.orientation.normalized().conjugate() * (to.position - from.position);
  };
  return {(shift(i.estimate, j.estimate) - shift(i.truth, j.truth)).norm(),
          AngleOf(turn(i.truth, j.truth).conjugate() * turn(i.estimate, j.estimate))};
}

PoseErrorStatistics Statistics(const std::vector<PoseError>& errors) {
  std::vector<double> translation_m;
  std::vector<double> rotation_deg;
  std::vector<double> rotation_block;
  std::vector<double> full;
  for (std::vector<double>* values : {&translation_m, &rotation_deg, &rotation_block, &full}) {
    values->reserve(errors.size());
  }
  for (const PoseError& error : errors) {
    translation_m.push_back(error.translation_m);
    rotation_deg.push_back(kDegPerRad * error.angle_rad);
    rotation_block.push_back(error.RotationPart());
    full.push_back(error.Full());
  }
  return {Statistics(std::move(translation_m)),
          Statistics(std::move(rotation_deg)),
          Statistics(std::move(rotation_block)),
          Statistics(std::move(full))};
}

}  // namespace ceilmap::evaluation
