#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/solve/drive_solver.hpp"

/// Exact points of a drive under a ceiling.
namespace ceilmap::calibration::synthetic {

/// Straight up, the top of the image to the front.
inline calib::MountedCamera Fisheye() {
  calib::MountedCamera up;
  up.camera = calib::Lens::WithoutDistortion(calib::LensModel::kEquidistant, {640, 480}, 300);
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(90 * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return up;
}

struct CameraTruth {
  Eigen::Vector2d tilt_rad{0, 0};
  double focal_ratio = 1;
  double readout_s = 0;
  double depth = 0;  ///< most of the points' distance from the plane, of Z
};

/// A drive with straight parts and turns, and what a camera with errors sees of it.
class DriveWorld {
 public:
  explicit DriveWorld(const CameraTruth& truth) : truth_(truth), up_(Fisheye()), lens_(up_.camera) {
    lens_.fx *= truth.focal_ratio;
    lens_.fy *= truth.focal_ratio;
    const Eigen::Vector3d turn(truth.tilt_rad.x(), truth.tilt_rad.y(), 0);
    if (turn.norm() > 0) {
      R_level_cam_ = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    Pose2 at;
    for (int i = 0; i < 40; ++i) {
      const bool turns = i % 12 > 7;
      const ViewVelocity velocity{turns ? Eigen::Vector2d(0.02, 0.05) : Eigen::Vector2d(0.05, 0.3),
                                  turns ? 0.9 : 0.0};
      drive_.cameras.push_back(at);
      drive_.velocities.push_back(velocity);
      constexpr double kStepS = 0.3;
      at = at * Pose2{velocity.linear.x() * kStepS,
                      velocity.linear.y() * kStepS,
                      velocity.yaw_rad_s * kStepS};
    }
    drive_.starts = {0};
    for (int first = 0; first < 40; ++first) {
      points_.push_back(SomePoints(first));
      for (const int apart : {1, 2, 4, 8}) {
        if (first + apart < 40) AddPair(first, first + apart, points_.back());
      }
    }
  }

  [[nodiscard]] DriveSolution Solve(const DriveUnknowns& params) const {
    return SolveDrive(up_, drive_, params);
  }
  [[nodiscard]] const Drive& GetDrive() const { return drive_; }
  /// Z divided by the distance of a point.
  [[nodiscard]] double RhoOf(const PointHeight& point) const {
    return 1 /
           points_[static_cast<std::size_t>(point.view)][static_cast<std::size_t>(point.index)].z();
  }

 private:
  struct Observation {
    Eigen::Vector2d ray;  // as the rig interprets the pixel
    double row = 0;
  };

  Observation See(const Eigen::Vector3d& point, int view) {
    const auto i = static_cast<std::size_t>(view);
    Observation observed;
    for (int round = 0; round < 4; ++round) {  // the row depends on the time
      const double time = truth_.readout_s * observed.row;
      const ViewVelocity& v = drive_.velocities[i];
      const Pose2 at =
          drive_.cameras[i] * Pose2{v.linear.x() * time, v.linear.y() * time, v.yaw_rad_s * time};
      const Eigen::Vector2d seen = at.Inverse() * Eigen::Vector2d(point.head<2>());
      const Eigen::Vector3d p_cam =
          R_level_cam_.transpose() * Eigen::Vector3d(seen.x(), seen.y(), point.z());
      const Eigen::Vector2d pixel = *lens_.Project(p_cam);
      observed.row = pixel.y() / (lens_.height_px - 1) - 0.5;
      observed.ray = up_.camera.Ray(pixel)->hnormalized();
    }
    return observed;
  }

  /// Around a view.
  std::vector<Eigen::Vector3d> SomePoints(int view) {
    std::uniform_real_distribution<double> anywhere(-0.8, 0.8);
    std::uniform_real_distribution<double> height(1 - truth_.depth, 1);
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 30; ++k) {
      const Eigen::Vector2d place = drive_.cameras[static_cast<std::size_t>(view)] *
                                    Eigen::Vector2d(anywhere(random_), anywhere(random_));
      points.emplace_back(place.x(), place.y(), height(random_));
    }
    return points;
  }

  void AddPair(int first, int second, const std::vector<Eigen::Vector3d>& points) {
    std::normal_distribution<double> doubt(1, 0.05);
    ViewPair pair{first, second, {}};
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Observation a = See(points[k], first);
      const Observation b = See(points[k], second);
      pair.places.push_back({a.ray,
                             b.ray,
                             a.row,
                             b.row,
                             Eigen::Matrix2d::Identity(),
                             static_cast<int>(k),
                             doubt(random_) / points[k].z()});
    }
    drive_.pairs.push_back(pair);
  }

  CameraTruth truth_;
  calib::MountedCamera up_;
  calib::Lens lens_;
  Eigen::Matrix3d R_level_cam_ = Eigen::Matrix3d::Identity();
  Drive drive_;
  std::vector<std::vector<Eigen::Vector3d>> points_;  // of the views
  std::mt19937 random_{7};
};

}  // namespace ceilmap::calibration::synthetic
