#include "app/files/trajectory_bag.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::files {
namespace {

using Level = bags::DiagnosticsMessage::Level;

Level LevelOf(graph::TrackingStatus status) {
  switch (status) {
    case graph::TrackingStatus::kTracking:
      return Level::kOk;
    case graph::TrackingStatus::kRelocalized:
    case graph::TrackingStatus::kPredicted:
    case graph::TrackingStatus::kAmbiguous:
      return Level::kWarn;
    case graph::TrackingStatus::kLost:
      break;
  }
  return Level::kError;
}

// Of x, y, z and the rotations about the map's axes. Pitch and roll are about the axes of the level
// robot, which its yaw turns into those of the map. The height is that of the floor.
std::array<double, 36> CovarianceOf(const graph::FramePose& frame) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  constexpr std::array<int, 3> kPlanar = {0, 1, 5};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      covariance(kPlanar[row], kPlanar[column]) = frame.covariance(row, column);
    }
  }
  const Eigen::Matrix2d& tilt = frame.tilt.covariance;  // of pitch (about y), roll (about x)
  Eigen::Matrix2d level;
  level << tilt(1, 1), tilt(1, 0), tilt(0, 1), tilt(0, 0);
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(frame.T_map_base.yaw).toRotationMatrix();
  covariance.block<2, 2>(3, 3) = turn * level * turn.transpose();
  std::array<double, 36> rows{};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = covariance(static_cast<int>(i) / 6, static_cast<int>(i) % 6);
  }
  return rows;
}

// As in a status file.
TrajectoryBag::Values PoseValues(const graph::FramePose& frame) {
  const auto sigma = [&](int i) { return std::sqrt(frame.covariance(i, i)); };
  return {{"sigma_x", fmt::format("{:.6f}", sigma(0))},
          {"sigma_y", fmt::format("{:.6f}", sigma(1))},
          {"sigma_yaw_deg", fmt::format("{:.5f}", kDegPerRad * sigma(2))},
          {"pitch_deg", fmt::format("{:.5f}", kDegPerRad * frame.tilt.pitch_rad)},
          {"roll_deg", fmt::format("{:.5f}", kDegPerRad * frame.tilt.roll_rad)}};
}

}  // namespace

bags::Transform TransformOf(const graph::FramePose& frame) {
  const StampedPose pose = ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt);
  const Eigen::Quaterniond q = pose.orientation.normalized();
  return {{pose.position.x(), pose.position.y(), pose.position.z()}, {q.x(), q.y(), q.z(), q.w()}};
}

TrajectoryBag::TrajectoryBag(bags::McapWriter& writer)
    : writer_(writer),
      pose_(writer.Add(kPoseTopic, bags::kPoseType)),
      transforms_(writer.Add(kTransformsTopic, bags::kTransformsType)),
      diagnostics_(writer.Add(kDiagnosticsTopic, bags::kDiagnosticsType)) {}

void TrajectoryBag::Add(const graph::FramePose& frame, bool with_pose, const Values& values) {
  const std::int64_t stamp_ns = bags::Nanoseconds(frame.stamp_s);
  const bags::Header header{stamp_ns, kMapFrame};
  if (with_pose) {
    const bags::Transform pose = TransformOf(frame);
    writer_.Write(
        pose_, stamp_ns, bags::Encode(bags::PoseMessage{header, pose, CovarianceOf(frame)}));
    writer_.Write(transforms_,
                  stamp_ns,
                  bags::Encode(std::vector<bags::TransformStamped>{{header, kBaseFrame, pose}}));
  }
  bags::DiagnosticsMessage::Status status;
  status.level = LevelOf(frame.status);
  status.name = kDiagnosticsName;
  status.message = graph::ToString(frame.status);
  status.hardware_id = "up";
  status.values = values;
  if (with_pose || frame.status == graph::TrackingStatus::kPredicted) {
    for (auto& value : PoseValues(frame)) status.values.push_back(std::move(value));
  }
  writer_.Write(diagnostics_, stamp_ns, bags::Encode(bags::DiagnosticsMessage{header, {status}}));
}

}  // namespace ceilmap::files
