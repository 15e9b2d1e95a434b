#include "tests/bench/visit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>
#include <numbers>

#include "calib/base/tilt.hpp"
#include "samples/simulator/path.hpp"
#include "tests/bench/world_run.hpp"

namespace ceilmap::bench {
namespace {

constexpr double kRight_m = 0.05;
constexpr double kRight_rad = 0.02;

void ShowProgress(std::int64_t done, std::int64_t total) {
  if (done % 200 == 0 || done == total) fmt::print(stderr, "\rmapping {}/{} ", done, total);
  if (done == total) fmt::print(stderr, "\n");
}

// Where the map lies in the room: the planar motion that brings the keyframes to where they were
// truly taken, least squares. `mapping` are the frames of the mapping run.
Pose2 FindMap(const store::MapReader& map, const std::vector<simulator::Frame>& mapping) {
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  Eigen::Vector2d mean_map = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_room = Eigen::Vector2d::Zero();
  const auto truth = [&](const graph::Keyframe& keyframe) {
    const auto frame = static_cast<std::size_t>(keyframe.pose.frame_index);
    return FromSpace(mapping.at(frame).T_map_base).pose;
  };
  for (const graph::Keyframe& keyframe : keyframes) {
    mean_map += keyframe.pose.T_map_base.Translation();
    mean_room += truth(keyframe).Translation();
  }
  const auto n = static_cast<double>(keyframes.size());
  mean_map /= n;
  mean_room /= n;
  double sine = 0;
  double cosine = 0;
  for (const graph::Keyframe& keyframe : keyframes) {
    const Eigen::Vector2d a = keyframe.pose.T_map_base.Translation() - mean_map;
    const Eigen::Vector2d b = truth(keyframe).Translation() - mean_room;
    sine += a.x() * b.y() - a.y() * b.x();
    cosine += a.dot(b);
  }
  Pose2 T_room_map{0, 0, std::atan2(sine, cosine)};
  const Eigen::Vector2d shift = mean_room - T_room_map.Rotation() * mean_map;
  T_room_map.x = shift.x();
  T_room_map.y = shift.y();
  return T_room_map;
}

// Frames of a robot that drives at an even speed from a pose. `velocity` is forward, to the left,
// turning: m/s, m/s, rad/s.
std::vector<simulator::Frame> Drive(const Pose2& T_room_base,
                                    const Eigen::Vector3d& velocity,
                                    int frames,
                                    double exposure_time_s) {
  const auto at = [&](double time_s) {
    // Along the arc of a constant twist.
    const double turn = velocity.z() * time_s;
    const double s = std::abs(turn) < 1e-9 ? time_s : std::sin(turn) / velocity.z();
    const double c = std::abs(turn) < 1e-9 ? 0 : (1 - std::cos(turn)) / velocity.z();
    const Pose2 moved =
        T_room_base *
        Pose2{s * velocity.x() - c * velocity.y(), c * velocity.x() + s * velocity.y(), turn};
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(moved.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = Eigen::Vector3d(moved.x, moved.y, 0);
    return T;
  };
  std::vector<simulator::Frame> drive;
  drive.reserve(static_cast<std::size_t>(frames));
  const double half_s = 0.5 * exposure_time_s;
  for (int i = 0; i < frames; ++i) {
    const double time_s = i * kPeriod_s;
    drive.push_back({i, time_s, at(time_s), at(time_s - half_s), at(time_s + half_s)});
  }
  return drive;
}

}  // namespace

simulator::Scene AnotherRobot(simulator::Scene scene) {
  scene.robot = "another robot";
  scene.axle_behind_mast_m = 0.1;
  scene.camera.focal_px *= 1.08;
  scene.camera.mount_height_m += 0.15;
  scene.camera.mount_x_m = 0.03;
  scene.image.exposure_gain *= 0.75;
  scene.image.exposure_drift = 0.05;
  if (scene.ceiling.lamps_off_share > 0) scene.ceiling.lamps_off_share += 0.1;
  return scene;
}

World::World(const simulator::Scene& world, const std::filesystem::path& file) : scene(world) {
  if (!std::filesystem::exists(file)) RunWorld(scene, file, {.progress = ShowProgress});
  map = std::make_unique<store::MapReader>(file);
  T_map_room = FindMap(*map, simulator::MakePath(scene)).Inverse();
}

Places::Places(const simulator::Scene& scene, unsigned seed)
    : area_(scene.path.area_m), exposure_time_s_(scene.camera.exposure_time_s), random_(seed) {}

Pose2 Places::Next() {
  std::uniform_real_distribution<double> x(area_[0], area_[2]);
  std::uniform_real_distribution<double> y(area_[1], area_[3]);
  std::uniform_real_distribution<double> yaw(-std::numbers::pi, std::numbers::pi);
  return {x(random_), y(random_), yaw(random_)};
}

std::vector<simulator::Frame> Places::NextDrive(int frames) {
  std::uniform_real_distribution<double> speed(0.2, 0.8);
  std::uniform_real_distribution<double> turn(-0.4, 0.4);
  const Eigen::Vector3d velocity{speed(random_), 0, turn(random_)};
  return Drive(Next(), velocity, frames, exposure_time_s_);
}

bool Visit::Right() const {
  return location.Placed() && error_m < kRight_m && error_rad < kRight_rad;
}

std::optional<wheels::RelativeMotion> VisitorWheels::Move(double stamp_s,
                                                          const Pose2& T_room_base,
                                                          bool carried) {
  constexpr double kScale = 1.02;
  constexpr double kTravelNoise = 0.01;  // m, after one metre
  constexpr double kYawNoise = 2 * std::numbers::pi / 180;
  if (last_ && !carried) {
    const Pose2 true_step = last_->T_room_base.Inverse() * T_room_base;
    const double root_m = std::sqrt(true_step.Translation().norm());
    const Pose2 arc{kScale * true_step.x + kTravelNoise * root_m * normal_(random_),
                    kScale * true_step.y,
                    true_step.yaw + kYawNoise * root_m * normal_(random_)};
    T_odom_base_ = T_odom_base_ * arc;
  }
  const std::optional<Last> before = last_;
  last_ = {stamp_s, T_room_base};
  reckoning_.Add(wheels::OdometrySample{stamp_s, T_odom_base_});
  return before ? reckoning_.Between(before->stamp_s, stamp_s) : std::nullopt;
}

void VisitorWheels::Learn(double stamp_s, const localization::Location& location) {
  std::optional<PoseWithCovariance> pose;
  if (location.Placed()) pose = {location.pose.T_map_base, location.pose.covariance};
  if (calibrator_.Place(stamp_s, pose, reckoning_)) reckoning_.SetModel(calibrator_.Model());
}

Visitor::Visitor(const simulator::Scene& scene, const World& world, bool has_wheels)
    : renderer_(scene), world_(world) {
  if (has_wheels) wheels_.emplace();
  SwitchOn();
}

void Visitor::SwitchOn() {
  if (!localizer_) {
    localizer_ = std::make_unique<localization::Localizer>(*world_.map, *renderer_.GetRig().up);
  } else {
    localizer_->Reset();
  }
}

Visit Visitor::Locate(const simulator::Frame& frame) {
  Visit visit;
  visit.T_map_base = world_.T_map_room * FromSpace(frame.T_map_base).pose;
  simulator::Frame now = frame;
  now.index = next_index_;  // the noise of no two images is the same
  const cv::Mat image = renderer_.Render(now);
  const double stamp_s = kPeriod_s * static_cast<double>(next_index_);
  localization::CeilingFrame seen{image, next_index_, stamp_s, std::nullopt};
  if (wheels_) seen.wheels = wheels_->Move(stamp_s, visit.T_map_base, carried_);
  carried_ = false;
  const auto start = std::chrono::steady_clock::now();
  visit.location = localizer_->Locate(seen);
  visit.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ++next_index_;
  if (wheels_) wheels_->Learn(stamp_s, visit.location);
  if (!visit.location.Placed()) return visit;
  const Pose2& found = visit.location.pose.T_map_base;
  const Eigen::Vector2d error = found.Translation() - visit.T_map_base.Translation();
  visit.error_m = error.norm();
  visit.error_rad = std::abs(WrapAngle(found.yaw - visit.T_map_base.yaw));
  const Eigen::Matrix2d covariance = visit.location.pose.covariance.topLeftCorner<2, 2>();
  visit.nees = error.dot(covariance.ldlt().solve(error));
  return visit;
}

}  // namespace ceilmap::bench
