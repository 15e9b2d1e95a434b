#include "app/files/bag_estimate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "app/bags/bag_reader.hpp"
#include "app/bags/message_error.hpp"
#include "app/bags/message_types.hpp"
#include "app/bags/result_messages.hpp"
#include "app/files/trajectory_bag.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

constexpr double kLengthTolerance = 1e-3;  // of a quaternion
constexpr double kSecondsPerNs = 1e-9;

bool HoldsPoses(const bags::Topic& topic) {
  return topic.type == bags::kPoseType || topic.type == bags::kOdometryType;
}

std::size_t PoseTopicOf(const std::vector<bags::Topic>& topics, const std::string& file) {
  std::vector<std::size_t> found;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (!HoldsPoses(topics[i])) continue;
    if (topics[i].name == kPoseTopic) return i;
    found.push_back(i);
    names.push_back(topics[i].name);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    throw InputError(fmt::format(
        "{}: has no topic of type {} or {}", file, bags::kPoseType, bags::kOdometryType));
  }
  throw InputError(fmt::format(
      "{}: has poses on the topics {}; give a bag with one of them", file, fmt::join(names, ", ")));
}

// Reads the messages of a bag into an estimate.
class EstimateReader {
 public:
  EstimateReader(std::string file, Estimate& estimate)
      : file_(std::move(file)), estimate_(estimate) {}

  void AddPose(const bags::PoseMessage& message) {
    const auto& [x, y, z, w] = message.pose.rotation;
    const auto& position = message.pose.translation;
    StampedPose pose{kSecondsPerNs * static_cast<double>(message.header.stamp_ns),
                     {position[0], position[1], position[2]},
                     Eigen::Quaterniond(w, x, y, z)};
    if (!pose.position.allFinite() ||
        !(std::abs(pose.orientation.norm() - 1) <= kLengthTolerance)) {
      throw InputError(
          fmt::format("{}: the pose at {:.6f} s is not finite, or its quaternion not "
                      "of unit length",
                      file_,
                      pose.stamp_s));
    }
    if (!estimate_.poses.empty() && pose.stamp_s <= estimate_.poses.back().stamp_s) {
      throw InputError(fmt::format("{}: timestamp {:.6f} is not later than {:.6f} before it",
                                   file_,
                                   pose.stamp_s,
                                   estimate_.poses.back().stamp_s));
    }
    estimate_.poses.push_back(pose);
    estimate_.covariances.push_back(PlanarCovariance(message.covariance));
  }

  void AddStatus(const bags::DiagnosticsMessage& message) {
    for (const auto& status : message.status) {
      if (status.name != kDiagnosticsName) continue;
      statuses_.emplace_back(kSecondsPerNs * static_cast<double>(message.header.stamp_ns),
                             status.message);
    }
  }

  void Finish() {
    const auto known = [](const auto& covariance) { return covariance.has_value(); };
    auto& covariances = estimate_.covariances;
    if (std::none_of(covariances.begin(), covariances.end(), known)) covariances.clear();
    if (!statuses_.empty()) AssignStatuses();
  }

 private:
  // To the poses of the same times.
  void AssignStatuses() {
    std::size_t next = 0;
    for (const auto& [stamp_s, word] : statuses_) {
      ++estimate_.frames_of_status[word];
      while (next < estimate_.poses.size() && estimate_.poses[next].stamp_s < stamp_s) ++next;
      const bool has_pose =
          next < estimate_.poses.size() && estimate_.poses[next].stamp_s == stamp_s;
      const FrameStatus frame{stamp_s, StatusNamed(word, has_pose)};
      (has_pose ? estimate_.placed : estimate_.unplaced).push_back(frame);
    }
    // A bag whose poses and statuses do not belong together.
    if (estimate_.placed.size() == estimate_.poses.size()) return;
    estimate_.placed.clear();
    estimate_.unplaced.clear();
    estimate_.frames_of_status.clear();
  }

  // Of x, y, yaw; nothing where it is not positive definite, as all zeros are: not known.
  static evaluation::PoseCovariance PlanarCovariance(const std::array<double, 36>& rows) {
    constexpr std::array<std::size_t, 3> kPlanar = {0, 1, 5};
    Eigen::Matrix3d covariance;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        covariance(static_cast<int>(row), static_cast<int>(column)) =
            rows[6 * kPlanar[row] + kPlanar[column]];
      }
    }
    if (!covariance.allFinite() || covariance.llt().info() != Eigen::Success) return {};
    return covariance;
  }

  std::string file_;
  Estimate& estimate_;
  std::vector<std::pair<double, std::string>> statuses_;
};

bags::PoseMessage PoseOf(const bags::RawMessage& message, const bags::Topic& topic) {
  if (topic.type == bags::kPoseType) return bags::DecodePose(message.data, topic.encoding);
  const bags::OdometryMessage odometry = bags::DecodeOdometry(message.data, topic.encoding);
  return {odometry.header, odometry.pose, odometry.pose_covariance};
}

}  // namespace

Estimate ReadBagEstimate(const std::filesystem::path& file) {
  const auto bag = bags::BagReader::Open(file);
  const std::vector<bags::Topic>& topics = bag->Topics();
  const std::size_t pose_topic = PoseTopicOf(topics, file.string());
  std::vector<std::size_t> selected = {pose_topic};
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const bool diagnostics = topics[i].type == bags::kDiagnosticsType;
    if (diagnostics && topics[i].name == kDiagnosticsTopic) selected.push_back(i);
  }
  bag->Select(selected);
  Estimate estimate;
  EstimateReader reader(file.string(), estimate);
  for (bags::RawMessage message; bag->Next(message);) {
    const bags::Topic& topic = topics[message.topic];
    try {
      if (message.topic == pose_topic) {
        reader.AddPose(PoseOf(message, topic));
      } else {
        reader.AddStatus(bags::DecodeDiagnostics(message.data, topic.encoding));
      }
    } catch (const bags::MessageError& error) {
      throw InputError(fmt::format("{}: {}: {}", file.string(), topic.name, error.what()));
    }
  }
  reader.Finish();
  estimate.warnings = bag->Warnings();
  if (estimate.poses.empty()) throw InputError(fmt::format("{}: holds no poses", file.string()));
  return estimate;
}

}  // namespace ceilmap::files
