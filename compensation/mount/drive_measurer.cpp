#include "compensation/mount/drive_measurer.hpp"

#include <algorithm>
#include <utility>

#include "compensation/mount/ceiling_pairs.hpp"

namespace ceilmap::mount {
namespace {

// The velocity of the camera at a keyframe, from the frames before and after.
Twist2 VelocityAt(const CeilingRecording& part, double stamp_s) {
  const auto& track = part.track;
  const auto at = std::lower_bound(
      track.begin(), track.end(), stamp_s, [](const TrackedFrame& frame, double stamp) {
        return frame.stamp_s < stamp;
      });
  if (at == track.end()) return {};
  const auto before = at == track.begin() ? at : at - 1;
  const auto after = at + 1 == track.end() ? at : at + 1;
  const double duration_s = after->stamp_s - before->stamp_s;
  if (duration_s <= 0) return {};
  return Twist2::Mean(before->T_first_camera.Inverse() * after->T_first_camera, duration_s);
}

}  // namespace

DriveMeasurer::DriveMeasurer(double ceiling_height_m, const std::vector<CeilingRecording>& parts)
    : ceiling_height_m_(ceiling_height_m), parts_(parts) {
  for (const CeilingRecording& part : parts) {
    std::vector<Pose2> cameras;
    for (const CeilingKeyframe& keyframe : part.keyframes) {
      cameras.push_back(keyframe.T_first_camera);
      velocities_.push_back(VelocityAt(part, keyframe.stamp_s));
      stamps_s_.push_back(keyframe.stamp_s);
    }
    cameras_.push_back(std::move(cameras));
  }
}

calibration::Drive DriveMeasurer::Measure(const calib::MountedCamera& up, bool accurate) const {
  calibration::Drive drive;
  drive.velocities = velocities_;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const std::size_t start = drive.cameras.size();
    drive.starts.push_back(start);
    calibration::Recording measured =
        MeasurePairs(parts_[i], up, ceiling_height_m_, cameras_[i], accurate);
    for (calibration::ViewPair& pair : measured.pairs) {
      pair.first += static_cast<int>(start);
      pair.second += static_cast<int>(start);
      drive.pairs.push_back(std::move(pair));
    }
    drive.cameras.insert(drive.cameras.end(), measured.cameras.begin(), measured.cameras.end());
  }
  return drive;
}

void DriveMeasurer::Improve(const std::vector<Pose2>& cameras) {
  std::size_t next = 0;
  for (std::vector<Pose2>& part : cameras_) {
    for (Pose2& camera : part) camera = cameras[next++];
  }
}

bool DriveMeasurer::HasDepth() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const CeilingRecording& part) {
    return part.has_depth;
  });
}

std::vector<DriveStep> DriveMeasurer::Steps() const {
  std::vector<DriveStep> steps;
  std::size_t view = 0;
  for (const std::vector<Pose2>& part : cameras_) {
    for (std::size_t i = 0; i < part.size(); ++i, ++view) {
      if (i == 0) continue;
      const Pose2 step = part[i - 1].Inverse() * part[i];
      steps.push_back({stamps_s_[view - 1],
                       stamps_s_[view],
                       Pose2{0, 0, -0.5 * step.yaw} * step.Translation(),
                       step.yaw});
    }
  }
  return steps;
}

}  // namespace ceilmap::mount
