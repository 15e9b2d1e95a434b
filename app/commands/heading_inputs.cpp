#include "app/commands/heading_inputs.hpp"

#include "app/files/tum.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::commands {
KnownTravel::KnownTravel(const std::filesystem::path& file, const Eigen::Vector2d& camera)
    : forecast_(camera) {
  if (!file.empty()) poses_ = files::ReadTum(file);
}

std::optional<Eigen::Vector2d> KnownTravel::To(double stamp_s) {
  const std::size_t seen = next_;
  while (next_ < poses_.size() && poses_[next_].stamp_s <= stamp_s + kMaxPoseDtS) ++next_;
  if (next_ > seen) {
    const StampedPose& pose = poses_[next_ - 1];
    forecast_.Add(pose.stamp_s, Pose2{pose.position.x(), pose.position.y(), YawOf(pose)});
  }
  std::optional<Eigen::Vector2d> travel;
  if (last_s_) travel = forecast_.Between(*last_s_, stamp_s);
  reported_ += travel ? 1 : 0;
  last_s_ = stamp_s;
  return travel;
}

}  // namespace ceilmap::commands
