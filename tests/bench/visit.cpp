#include "tests/bench/visit.hpp"

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>

namespace ceilmap::bench {

simulator::Scene AnotherRobot(simulator::Scene scene) {
  scene.robot = "another robot";
  scene.axle_behind_mast_m = 0.1;
  scene.camera.focal_px *= 1.08;
  scene.camera.mount_height_m += 0.15;
  scene.camera.mount_x_m = 0.03;
  scene.picture.exposure_gain *= 0.75;
  scene.picture.exposure_drift = 0.05;
  if (scene.ceiling.lamps_off_share > 0) scene.ceiling.lamps_off_share += 0.1;
  return scene;
}

calib::Pose2 Planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
}

calib::Pose2 FindMap(const mapping::MapReader& map, const std::vector<simulator::Frame>& mapping) {
  const std::vector<mapping::Keyframe> keyframes = map.ReadKeyframes();
  Eigen::Vector2d mean_map = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_room = Eigen::Vector2d::Zero();
  const auto truth = [&](const mapping::Keyframe& keyframe) {
    return Planar(mapping.at(static_cast<std::size_t>(keyframe.pose.frame_index)).T_map_base);
  };
  for (const mapping::Keyframe& keyframe : keyframes) {
    mean_map += keyframe.pose.T_map_base.Translation();
    mean_room += truth(keyframe).Translation();
  }
  const auto n = static_cast<double>(keyframes.size());
  mean_map /= n;
  mean_room /= n;
  double sine = 0;
  double cosine = 0;
  for (const mapping::Keyframe& keyframe : keyframes) {
    const Eigen::Vector2d a = keyframe.pose.T_map_base.Translation() - mean_map;
    const Eigen::Vector2d b = truth(keyframe).Translation() - mean_room;
    sine += a.x() * b.y() - a.y() * b.x();
    cosine += a.dot(b);
  }
  calib::Pose2 T_room_map{0, 0, std::atan2(sine, cosine)};
  const Eigen::Vector2d shift = mean_room - T_room_map.Rotation() * mean_map;
  T_room_map.x = shift.x();
  T_room_map.y = shift.y();
  return T_room_map;
}

std::vector<simulator::Frame> Drive(const calib::Pose2& T_room_base,
                                    const Eigen::Vector3d& velocity,
                                    int frames,
                                    double period_s,
                                    const simulator::Scene& scene) {
  const auto at = [&](double time_s) {
    // Along the arc of a constant twist.
    const double turn = velocity.z() * time_s;
    const double s = std::abs(turn) < 1e-9 ? time_s : std::sin(turn) / velocity.z();
    const double c = std::abs(turn) < 1e-9 ? 0 : (1 - std::cos(turn)) / velocity.z();
    const calib::Pose2 moved = T_room_base * calib::Pose2{s * velocity.x() - c * velocity.y(),
                                                          c * velocity.x() + s * velocity.y(),
                                                          turn};
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(moved.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = Eigen::Vector3d(moved.x, moved.y, 0);
    return T;
  };
  std::vector<simulator::Frame> drive;
  drive.reserve(static_cast<std::size_t>(frames));
  const double half_s = 0.5 * scene.camera.exposure_time_s;
  for (int i = 0; i < frames; ++i) {
    const double time_s = i * period_s;
    drive.push_back({i, time_s, at(time_s), at(time_s - half_s), at(time_s + half_s)});
  }
  return drive;
}

Visitor::Visitor(const simulator::Scene& scene,
                 const mapping::MapReader& map,
                 const calib::Pose2& T_map_room,
                 const localization::LocalizerParams& params)
    : renderer_(scene), map_(map), T_map_room_(T_map_room), params_(params) {
  SwitchOn();
}

void Visitor::SwitchOn() {
  if (!localizer_) {
    localizer_ = std::make_unique<localization::Localizer>(map_, *renderer_.GetRig().up, params_);
  } else {
    localizer_->Reset();
  }
}

Visit Visitor::See(const simulator::Frame& frame) {
  constexpr double kPeriod_s = 0.1;
  Visit visit;
  visit.T_map_base = T_map_room_ * Planar(frame.T_map_base);
  simulator::Frame now = frame;
  now.index = next_index_;  // the noise of no two pictures is the same
  const cv::Mat picture = renderer_.Render(now);
  const double stamp_s = kPeriod_s * static_cast<double>(next_index_);
  const auto start = std::chrono::steady_clock::now();
  visit.location = localizer_->Locate({picture, next_index_, stamp_s, std::nullopt});
  visit.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ++next_index_;
  if (!visit.location.Placed()) return visit;
  const calib::Pose2& found = visit.location.pose.T_map_base;
  const Eigen::Vector2d error = found.Translation() - visit.T_map_base.Translation();
  visit.error_m = error.norm();
  visit.error_rad = std::abs(calib::WrapAngle(found.yaw - visit.T_map_base.yaw));
  const Eigen::Matrix2d covariance = visit.location.pose.covariance.topLeftCorner<2, 2>();
  visit.nees = error.dot(covariance.ldlt().solve(error));
  return visit;
}

}  // namespace ceilmap::bench
