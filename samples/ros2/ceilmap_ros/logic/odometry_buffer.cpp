#include "ceilmap_ros/logic/odometry_buffer.hpp"

#include <algorithm>
#include <iterator>

#include "calib/base/pose_with_covariance.hpp"

namespace ceilmap_ros {
namespace {

constexpr Stamp kKept = 10 * kSecond;
constexpr Stamp kLargestGap = kSecond / 2;

}  // namespace

const char* ToString(OdometryAnswer::Kind kind) {
  switch (kind) {
    case OdometryAnswer::Kind::kKnown:
      return "known";
    case OdometryAnswer::Kind::kNone:
      return "no odometry came";
    case OdometryAnswer::Kind::kNotYet:
      return "odometry ends before the image";
    case OdometryAnswer::Kind::kTooOld:
      return "odometry begins after the image";
    case OdometryAnswer::Kind::kGap:
      return "odometry has a gap at the image";
  }
  return "";
}

void OdometryBuffer::Add(const OdometryPose& sample) {
  samples_.push_back(sample);
  while (samples_.front().stamp < sample.stamp - kKept) samples_.pop_front();
}

OdometryAnswer OdometryBuffer::At(Stamp stamp) const {
  using Kind = OdometryAnswer::Kind;
  if (samples_.empty()) return {Kind::kNone, {}};
  const auto after = std::lower_bound(
      samples_.begin(), samples_.end(), stamp, [](const OdometryPose& sample, Stamp at) {
        return sample.stamp < at;
      });
  if (after == samples_.end()) return {Kind::kNotYet, {}};
  if (after->stamp == stamp) return {Kind::kKnown, after->T_odom_base};
  if (after == samples_.begin()) return {Kind::kTooOld, {}};
  const OdometryPose& before = *std::prev(after);
  const Stamp span = after->stamp - before.stamp;
  if (span > kLargestGap) return {Kind::kGap, {}};
  const double part = ToSeconds(stamp - before.stamp) / ToSeconds(span);
  const Pose2 T_before_after = before.T_odom_base.Inverse() * after->T_odom_base;
  return {Kind::kKnown, before.T_odom_base * ceilmap::Interpolate(T_before_after, part)};
}

std::optional<Stamp> OdometryBuffer::Newest() const {
  if (samples_.empty()) return std::nullopt;
  return samples_.back().stamp;
}

}  // namespace ceilmap_ros
