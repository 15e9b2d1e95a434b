#include "samples/simulator/motion.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "samples/simulator/debris.hpp"
#include "samples/simulator/path_points.hpp"
#include "samples/simulator/tum_path.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Of a pose, as seen from above.
Pose2 Planar(const Isometry3d& T) {
  return {T(0, 3), T(1, 3), std::atan2(T(1, 0), T(0, 0))};
}

/// Rate of a channel at a knot between two intervals with mean rates a and b: 0 at an extreme, so
/// that the spline never leaves the range of its knots.
double MonotoneRate(double a, double b, double before_s, double after_s) {
  if (!(a * b > 0)) return 0;
  const double weight = (before_s + 2 * after_s) / (3 * (before_s + after_s));
  return a * b / (weight * b + (1 - weight) * a);
}

}  // namespace

Isometry3d OnFloor(const Pose2& pose) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = AngleAxisd(pose.yaw, Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Vector3d(pose.x, pose.y, 0);
  return T;
}

Motion::Motion(const Scene& scene)
    : debris_(scene.debris), axle_behind_mast_m_(scene.axle_behind_mast_m) {
  if (scene.path.kind == PathKind::kTum) {
    MakeKnots(scene.path);
  } else {
    drive_.emplace(PathPoints(scene), scene.path);
    const double length_m = drive_->DistanceAt(drive_->Duration());
    const std::vector<Bump> ground = UnevenGround(debris_, scene.seed, length_m);
    debris_.bumps.insert(debris_.bumps.end(), ground.begin(), ground.end());
  }
  carries_.reserve(scene.path.carried.size());
  for (const Carried& to : scene.path.carried) {
    const Pose2 T_map_base{to.x_m, to.y_m, to.yaw_deg * kRadPerDeg};
    const Pose2 T_map_path = T_map_base * Planar(BaseAt(to.at_s)).Inverse();
    carries_.push_back({to.at_s, OnFloor(T_map_path)});
  }
}

void Motion::MakeKnots(const Path& path) {
  const std::vector<PathPose>& poses = path.poses;
  CheckPosesRead(path);
  knots_.reserve(poses.size());
  for (const PathPose& pose : poses) {
    const Eigen::Matrix3d R = pose.T_map_base.linear();
    const Vector3d p = pose.T_map_base.translation();
    Knot knot{pose.stamp_s,
              {p.x(),
               p.y(),
               p.z(),
               std::atan2(R(1, 0), R(0, 0)),
               std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
               std::atan2(R(2, 1), R(2, 2))},
              {}};
    for (std::size_t i = 3; i < knot.value.size() && !knots_.empty(); ++i) {
      const double before = knots_.back().value.at(i);
      knot.value.at(i) = before + WrapAngle(knot.value.at(i) - before);
    }
    knots_.push_back(knot);
  }
  for (std::size_t k = 0; k < knots_.size() && knots_.size() > 1; ++k) {
    const Knot& before = knots_[k == 0 ? 0 : k - 1];
    const Knot& after = knots_[std::min(k + 1, knots_.size() - 1)];
    Knot& knot = knots_[k];
    const double before_s = knot.time_s - before.time_s;
    const double after_s = after.time_s - knot.time_s;
    for (std::size_t i = 0; i < knot.value.size(); ++i) {
      const double rate_before = (knot.value.at(i) - before.value.at(i)) / before_s;
      const double rate_after = (after.value.at(i) - knot.value.at(i)) / after_s;
      knot.rate.at(i) = k == 0 ? rate_after
                        : k + 1 == knots_.size()
                            ? rate_before
                            : MonotoneRate(rate_before, rate_after, before_s, after_s);
    }
  }
}

Isometry3d Motion::BetweenKnots(double time_s) const {
  const auto after =
      std::upper_bound(knots_.begin(), knots_.end(), time_s, [](double t, const Knot& knot) {
        return t < knot.time_s;
      });
  Channels at{};
  if (after == knots_.begin() || after == knots_.end()) {
    const Knot& end = after == knots_.begin() ? knots_.front() : knots_.back();
    for (std::size_t i = 0; i < at.size(); ++i) {
      at.at(i) = end.value.at(i) + (time_s - end.time_s) * end.rate.at(i);
    }
  } else {
    const Knot& a = *(after - 1);
    const Knot& b = *after;
    const double gap_s = b.time_s - a.time_s;
    const double u = (time_s - a.time_s) / gap_s;
    const double part = u * u * (3 - 2 * u);  // cubic Hermite
    const double from_a = u * (1 - u) * (1 - u) * gap_s;
    const double from_b = -u * u * (1 - u) * gap_s;
    for (std::size_t i = 0; i < at.size(); ++i) {
      at.at(i) = a.value.at(i) + part * (b.value.at(i) - a.value.at(i)) + from_a * a.rate.at(i) +
                 from_b * b.rate.at(i);
    }
  }
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d(at[0], at[1], at[2]);
  T.rotate(AngleAxisd(at[3], Vector3d::UnitZ()));
  T.rotate(AngleAxisd(at[4], Vector3d::UnitY()));
  T.rotate(AngleAxisd(at[5], Vector3d::UnitX()));
  return T;
}

Isometry3d Motion::BaseAt(double time_s) const {
  if (!drive_) return BetweenKnots(time_s);
  const Pose2 T_path_axle = drive_->PoseAt(time_s);
  const Tilt tilt = TiltAt(debris_, drive_->DistanceAt(time_s));
  if (!tilt.IsLevel()) return TiltedBase(T_path_axle, tilt, axle_behind_mast_m_);
  return OnFloor(T_path_axle * Pose2{axle_behind_mast_m_, 0, 0});
}

Pose2 Motion::AxleAt(double time_s) const {
  if (drive_) return drive_->PoseAt(time_s);
  return Planar(BetweenKnots(time_s) * Eigen::Translation3d(-axle_behind_mast_m_, 0, 0));
}

std::optional<Isometry3d> Motion::CarriedAt(double time_s) const {
  constexpr double kRounding = 1e-9;  // of stamps
  std::optional<Isometry3d> T_map_path;
  for (const Carry& carry : carries_) {
    if (time_s > carry.at_s - kRounding) T_map_path = carry.T_map_path;
  }
  return T_map_path;
}

}  // namespace ceilmap::simulator
