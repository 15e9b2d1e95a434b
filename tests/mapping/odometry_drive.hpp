#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "mapping/odometry.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

/// A robot that drives under a synthetic ceiling, for the tests of the odometry.
namespace ceilmap::mapping::synthetic_drive {

using calib::CeilingView;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;

/// Camera ahead of the axis and to its right, turned a little in its mount; 5 mm per pixel, 3.2 m x
/// 2.4 m in view.
inline CeilingView MakeView() {
  calib::MountedCamera up;
  up.camera = {640, 480, 440, 440, 322.5, 238, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(93 * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.12, -0.05, 0.4);
  return {up, 2.6};
}

/// A robot that drives under a synthetic ceiling with images as its only input.
class Drive {
 public:
  explicit Drive(const Pose2& origin = {0.4, -0.3, 0.5}, const OdometryParams& params = {})
      : T_map_base_(origin), odometry_(view_, origin, params) {}

  void Move(double forward_m, double turn_deg) {
    T_map_base_ = T_map_base_ * Pose2{forward_m, 0, turn_deg * kRadPerDeg};
  }
  void Jump(const Pose2& T_map_base) { T_map_base_ = T_map_base; }
  OdometryStep Process() {
    return ProcessImage(ceiling_.Render(kSize, MotionAt(view_, T_map_base_), 1.5, Next()));
  }
  OdometryStep SeeUniform(int grey) {
    Next();
    return ProcessImage(cv::Mat(kSize, CV_8UC1, cv::Scalar(grey)));
  }

  OdometryStep Close() { return odometry_.Close(); }

  [[nodiscard]] const Pose2& Truth() const { return T_map_base_; }
  [[nodiscard]] const std::vector<OdometryStep>& Steps() const { return steps_; }
  [[nodiscard]] const std::vector<Pose2>& Truths() const { return truths_; }
  [[nodiscard]] const CeilingView& View() const { return view_; }

 private:
  static inline const cv::Size kSize{640, 480};

  std::uint32_t Next() { return static_cast<std::uint32_t>(truths_.size()) + 1; }
  OdometryStep ProcessImage(const cv::Mat& image) {
    const auto index = static_cast<std::int64_t>(truths_.size());
    truths_.push_back(T_map_base_);
    steps_.push_back(odometry_.Process(image, index, 0.1 * static_cast<double>(index)));
    return steps_.back();
  }

  SyntheticCeiling ceiling_;
  CeilingView view_ = MakeView();
  Pose2 T_map_base_;
  Odometry odometry_;
  std::vector<OdometryStep> steps_;
  std::vector<Pose2> truths_;
};

inline void ExpectNear(const Pose2& pose, const Pose2& truth, const std::string& what) {
  EXPECT_LT((pose.Translation() - truth.Translation()).norm(), 1e-3) << what;
  EXPECT_LT(std::abs(WrapAngle(pose.yaw - truth.yaw)), 0.02 * kRadPerDeg) << what;
}

inline bool Placed(const OdometryStep& step) {
  return graph::HasPose(step.pose.status);
}

/// Drives evenly, 0.06 m a frame.
inline void DriveEvenly(Drive& drive, int frames = 12) {
  drive.Process();
  for (int i = 0; i < frames; ++i) {
    drive.Move(0.06, 0);
    ASSERT_TRUE(Placed(drive.Process())) << i;
  }
}

}  // namespace ceilmap::mapping::synthetic_drive
