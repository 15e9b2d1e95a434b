#include "app/recordings/bag_motion.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "app/bags/message_error.hpp"
#include "app/bags/message_types.hpp"
#include "app/recordings/frame_tree.hpp"
#include "calib/base/error.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::recordings {
namespace {

Pose2 PlanarOf(const Eigen::Isometry3d& pose) {
  return PlanarPose({0, pose.translation(), Eigen::Quaterniond(pose.linear())});
}

bool IsBaseFrame(const std::string& frame_id) {
  const std::string name = LocalName(frame_id);
  return name == "base_link" || name == "base_footprint";
}

}  // namespace

BagSamples::BagSamples(std::unique_ptr<BagStream> stream, BagStamp stamp)
    : stream_(std::move(stream)), stamp_(stamp) {}

std::string BagSamples::Name() const {
  return stream_->Recording().Name() + ":" + stream_->Topic().name;
}

void BagSamples::ReadTo(double stamp_s) {
  // Messages of other topics may be recorded late.
  constexpr double kPatienceS = 1;
  constexpr double kNsPerS = 1e9;
  constexpr double kMaxS = 9e9;
  while (!stream_->Ended() && (!last_s_ || *last_s_ <= stamp_s)) {
    std::int64_t until_ns = std::numeric_limits<std::int64_t>::max();
    const double until_s = stamp_s + log_ahead_s_ + kPatienceS;
    if (last_s_ && until_s < kMaxS) until_ns = std::llround(kNsPerS * until_s);
    if (!stream_->Next(message_, until_ns)) return;
    try {
      Add(message_);
    } catch (const bags::MessageError&) {
      CountUnusable();
    }
  }
}

std::optional<double> BagSamples::StampOf(std::int64_t header_ns) {
  const double log_s = SecondsOf(message_.log_time_ns);
  const bool from_header = stamp_ == BagStamp::kHeader && header_ns != 0;
  const double stamp_s = from_header ? SecondsOf(header_ns) : log_s;
  if (last_s_ && stamp_s <= *last_s_) {
    ++out_of_order_;
    return std::nullopt;
  }
  last_s_ = stamp_s;
  log_ahead_s_ = log_s - stamp_s;
  return stamp_s;
}

std::vector<std::string> BagSamples::Warnings() const {
  std::vector<std::string> warnings;
  if (out_of_order_ > 0) {
    warnings.push_back(
        fmt::format("{}: {} messages were not later than the one before, and were left out",
                    Name(),
                    out_of_order_));
  }
  if (unusable_ > 0) {
    warnings.push_back(fmt::format(
        "{}: {} messages are damaged or without a value, and were left out", Name(), unusable_));
  }
  if (std::string remark = Remark(); !remark.empty()) warnings.push_back(std::move(remark));
  return warnings;
}

BagOdometry::BagOdometry(const std::string& bag, const BagTopic& topic)
    : BagSamples(OpenTopic(bag, topic, TopicUse::kOdometry), topic.stamp) {}

void BagOdometry::Add(const BagMessage& message) {
  const bags::Topic& topic = Stream().Topic();
  if (topic.type == bags::kOdometryType) {
    AddOdometry(bags::DecodeOdometry(message.data, topic.encoding));
    return;
  }
  for (const auto& transform : bags::DecodeTransforms(message.data, topic.encoding)) {
    AddTransform(transform);
  }
}

void BagOdometry::AddOdometry(const bags::OdometryMessage& message) {
  const std::optional<Eigen::Isometry3d> pose = ToIsometry(message.pose);
  const bool has_twist = std::isfinite(message.linear[0]) && std::isfinite(message.linear[1]) &&
                         std::isfinite(message.angular[2]);
  const bool by_twist = pose ? !recording_.speeds.empty() : recording_.poses.empty() && has_twist;
  if ((!pose && !by_twist) || (by_twist && !has_twist)) {
    CountUnusable();
    return;
  }
  const std::optional<double> stamp_s = StampOf(message.header.stamp_ns);
  if (!stamp_s) return;
  if (by_twist) {
    recording_.speeds.push_back(
        {*stamp_s, {{message.linear[0], message.linear[1]}, message.angular[2]}});
  } else {
    recording_.poses.push_back({*stamp_s, PlanarOf(*pose)});
  }
}

// /tf holds other transforms too. Of those to the base, the first one is followed.
void BagOdometry::AddTransform(const bags::TransformStamped& transform) {
  if (!IsBaseFrame(transform.child_frame_id) || IsBaseFrame(transform.header.frame_id)) return;
  if (child_.empty()) {
    parent_ = transform.header.frame_id;
    child_ = transform.child_frame_id;
  }
  if (parent_ != transform.header.frame_id || child_ != transform.child_frame_id) return;
  const std::optional<Eigen::Isometry3d> pose = ToIsometry(transform.transform);
  if (!pose) {
    CountUnusable();
    return;
  }
  if (const auto stamp_s = StampOf(transform.header.stamp_ns)) {
    recording_.poses.push_back({*stamp_s, PlanarOf(*pose)});
  }
}

std::string BagOdometry::Remark() const {
  if (Stream().Topic().type != bags::kTransformsType || !child_.empty()) return "";
  return fmt::format("{}: holds no transform to base_link or base_footprint", Name());
}

BagGyro::BagGyro(const std::string& bag, const BagTopic& topic)
    : BagSamples(OpenTopic(bag, topic, TopicUse::kGyro), topic.stamp),
      bag_(bag),
      bags_(topic.bags ? topic.bags : std::make_shared<OpenBags>()) {}

void BagGyro::Add(const BagMessage& message) {
  const auto imu = bags::DecodeImu(message.data, Stream().Topic().encoding);
  if (!up_imu_) {
    frame_ = FrameName(imu.header.frame_id);
    const FrameTree& frames = bags_->Robot(bag_).Frames();
    const std::optional<std::string> base = frames.BaseOf(frame_);
    assumed_ = !base;
    up_imu_ = Eigen::Vector3d::UnitZ();
    if (base) up_imu_ = frames.Find(*base, frame_)->linear().row(2).transpose();
  }
  const auto& [x, y, z] = imu.angular_velocity;
  const double rate_rad_s = up_imu_->dot(Eigen::Vector3d(x, y, z));
  if (!std::isfinite(rate_rad_s)) {
    CountUnusable();
    return;
  }
  if (const auto stamp_s = StampOf(imu.header.stamp_ns)) {
    recording_.samples.push_back({*stamp_s, rate_rad_s});
  }
}

std::string BagGyro::Remark() const {
  if (!assumed_) return "";
  return fmt::format(
      "{}: /tf_static does not connect its frame {} with base_link; its axes are taken to be those "
      "of base_link",
      Name(),
      frame_.empty() ? "\"\"" : frame_);
}

files::OdometryRecording ReadBagOdometry(const std::string& bag, const BagTopic& topic) {
  BagOdometry odometry(bag, topic);
  odometry.ReadTo(std::numeric_limits<double>::infinity());
  const files::OdometryRecording& recording = odometry.Recording();
  if (recording.poses.size() + recording.speeds.size() < 2) {
    throw InputError(fmt::format("{}: holds fewer than two samples of odometry", odometry.Name()));
  }
  return recording;
}

}  // namespace ceilmap::recordings
