#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/ceiling_view.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/compensation/bumpy_drive.hpp"

/// A simulated robot whose mounts are known, its turn on the spot and its straight drive.
namespace ceilmap::mount::synthetic {

inline simulator::Scene Robot() {
  simulator::Scene scene = compensation::synthetic::Lab();
  scene.axle_behind_mast_m = 0.12;
  scene.camera.mount_y_m = 0.02;
  scene.camera.mount_yaw_deg = 3;
  scene.camera.mount_pitch_deg = 1;
  scene.camera.mount_roll_deg = -0.6;
  scene.forward->mount_yaw_deg = 2;
  scene.forward->mount_pitch_deg = 4;
  scene.forward->mount_roll_deg = -1;
  return scene;
}

/// A rig with the intrinsics, the cameras' heights, and cameras that point straight up and ahead.
inline calib::Rig RoughRig(const calib::Rig& truth) {
  calib::Rig rig = truth;
  rig.axle_behind_mast_m = 0;
  Eigen::Isometry3d& up = rig.up->T_base_cam;
  up.linear() = Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.translation().head<2>().setZero();
  rig.forward->T_base_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return rig;
}

/// @param axle_behind_mast_m  of the robot that turns about its axle. @param deg  the whole turn.
inline std::vector<simulator::Frame> Spin(double axle_behind_mast_m, int frames, double deg = 360) {
  std::vector<simulator::Frame> spin;
  for (int i = 0; i <= frames; ++i) {
    const double yaw = WrapAngle(deg * kRadPerDeg * i / frames);
    spin.push_back(compensation::synthetic::FrameAt(
        i,
        {3.5 + axle_behind_mast_m * std::cos(yaw), 3 + axle_behind_mast_m * std::sin(yaw), yaw}));
  }
  return spin;
}

inline std::vector<simulator::Frame> Straight(double length_m, int frames) {
  std::vector<simulator::Frame> straight;
  for (int i = 0; i <= frames; ++i) {
    straight.push_back(compensation::synthetic::FrameAt(i, {2.6 + length_m * i / frames, 3, 0}));
  }
  return straight;
}

inline CeilingRecording Record(const std::string& name,
                               const simulator::Renderer& renderer,
                               const calib::CeilingView& view,
                               const std::vector<simulator::Frame>& frames) {
  CeilingRecorder recorder(name, view);
  for (const simulator::Frame& frame : frames) recorder.Add(renderer.Render(frame));
  return recorder.Finish();
}

}  // namespace ceilmap::mount::synthetic
