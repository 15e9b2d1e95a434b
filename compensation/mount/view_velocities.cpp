#include "compensation/mount/view_velocities.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ceilmap::mount {
namespace {

using calibration::ViewVelocity;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The constant velocity that leads to a pose in unit time: of x, y and yaw, in axes that turn
// along.
Vector3d Log(const Pose2& T_first_second) {
  const double half = 0.5 * T_first_second.yaw;
  const double along = std::abs(half) < 1e-6 ? 1 : half / std::tan(half);
  const Vector2d t = T_first_second.Translation();
  return {along * t.x() + half * t.y(), along * t.y() - half * t.x(), T_first_second.yaw};
}

// Change of the pose by s at one of the views, in the view's axes: a parabola through it and its
// neighbours; at an end, through the three last ones.
Vector3d Slope(const std::vector<double>& s, const std::vector<Pose2>& poses, std::size_t i) {
  const std::size_t n = poses.size();
  const auto step = [&](std::size_t k) { return Log(poses[i].Inverse() * poses[k]); };
  if (n == 2) return step(1 - i) / (s[1 - i] - s[i]);
  const std::size_t middle = std::clamp<std::size_t>(i, 1, n - 2);
  const std::size_t one = i == middle ? middle - 1 : middle;
  const std::size_t other = i == middle ? middle + 1 : i == 0 ? 2 : n - 3;
  const double to_one = s[one] - s[i];
  const double to_other = s[other] - s[i];
  return (step(one) * (to_other / to_one) - step(other) * (to_one / to_other)) /
         (to_other - to_one);
}

}  // namespace

ViewVelocity VelocityAt(const std::vector<TimedPose>& path, std::size_t index) {
  constexpr double kWindowS = 0.1;
  constexpr std::size_t kMinBeside = 2;
  const TimedPose& at = path[index];
  std::size_t first = index - std::min(index, kMinBeside);
  std::size_t last = std::min(index + kMinBeside, path.size() - 1);
  while (first > 0 && at.stamp_s - path[first - 1].stamp_s <= kWindowS) --first;
  while (last + 1 < path.size() && path[last + 1].stamp_s - at.stamp_s <= kWindowS) ++last;
  const auto count = static_cast<Eigen::Index>(last - first + 1);
  if (count < 2) return {};
  const Eigen::Index terms = std::min<Eigen::Index>(count, 3);
  Eigen::MatrixXd A(count, terms);
  Eigen::MatrixXd moved(count, 3);
  for (Eigen::Index k = 0; k < count; ++k) {
    const TimedPose& other = path[first + static_cast<std::size_t>(k)];
    const double time_s = other.stamp_s - at.stamp_s;
    for (Eigen::Index term = 0; term < terms; ++term) {
      A(k, term) = std::pow(time_s, static_cast<double>(term));
    }
    moved.row(k) = Log(at.pose.Inverse() * other.pose);
  }
  const Vector3d rate = A.colPivHouseholderQr().solve(moved).row(1);
  return {rate.head<2>(), rate.z()};
}

std::vector<ViewVelocity> RefineVelocities(const std::vector<Pose2>& rough,
                                           const std::vector<ViewVelocity>& velocities,
                                           const std::vector<Pose2>& accurate) {
  std::vector<double> s{0};  // along the rough path; one radian counts as one unit of length
  for (std::size_t i = 1; i < rough.size(); ++i) {
    constexpr double kMinStep = 1e-6;
    s.push_back(s.back() + std::max(kMinStep, Log(rough[i - 1].Inverse() * rough[i]).norm()));
  }
  std::vector<ViewVelocity> result;
  for (std::size_t i = 0; i < rough.size(); ++i) {
    const Vector3d along = Slope(s, rough, i);
    Vector3d rate;
    rate << velocities[i].linear, velocities[i].yaw_rad_s;
    constexpr double kMinSlope = 0.5;  // below: the path turns back between the views
    const double speed =
        along.norm() > kMinSlope ? rate.dot(along) / along.squaredNorm() : 0;  // ds/dt
    const Vector3d moved = speed * Slope(s, accurate, i);
    result.push_back({moved.head<2>(), moved.z()});
  }
  return result;
}

std::vector<ViewVelocity> VelocitiesOf(const std::vector<TimedPose>& views) {
  std::vector<double> stamps_s;
  std::vector<Pose2> poses;
  for (const TimedPose& view : views) {
    stamps_s.push_back(view.stamp_s);
    poses.push_back(view.pose);
  }
  std::vector<ViewVelocity> result;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Vector3d rate = Slope(stamps_s, poses, i);
    result.push_back({rate.head<2>(), rate.z()});
  }
  return result;
}

}  // namespace ceilmap::mount
