#include "compensation/usual_tilt.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace ceilmap::compensation {

void UsualTilt::Add(const Eigen::Vector2d& pitch_roll_rad) {
  constexpr int kRememberedFrames = 500;
  frames_ = std::min(frames_ + 1, kRememberedFrames);
  variance_ += (0.5 * pitch_roll_rad.squaredNorm() - variance_) / frames_;
}

TiltAngles UsualTilt::Combine(const TiltAngles& predicted) const {
  const double variance = variance_ + 0.5 * predicted.angles.squaredNorm();
  const Eigen::Matrix2d usual = variance * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d weight = usual * (predicted.covariance + usual).inverse();
  return {weight * predicted.angles, weight * predicted.covariance};
}

}  // namespace ceilmap::compensation
