#include "app/commands/heading_inputs.hpp"

#include <algorithm>
#include <cmath>

#include "app/files/tum.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::commands {
namespace {

std::vector<StampedPose> PosesIn(const std::filesystem::path& file) {
  return file.empty() ? std::vector<StampedPose>{} : files::ReadTum(file);
}

}  // namespace

KnownTravel::KnownTravel(const std::filesystem::path& file, const Eigen::Vector2d& camera)
    : poses_(PosesIn(file)), forecast_(camera) {}

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

KnownTilts::KnownTilts(const std::filesystem::path& file) : poses_(PosesIn(file)) {}

std::optional<Tilt> KnownTilts::At(double stamp_s) {
  const auto later = std::lower_bound(
      poses_.begin(), poses_.end(), stamp_s, [](const StampedPose& pose, double stamp) {
        return pose.stamp_s < stamp;
      });
  const StampedPose* nearest = nullptr;
  double nearest_s = kMaxPoseDtS;
  for (const auto& at : {later, later == poses_.begin() ? later : later - 1}) {
    if (at == poses_.end() || std::abs(at->stamp_s - stamp_s) > nearest_s) continue;
    nearest = &*at;
    nearest_s = std::abs(at->stamp_s - stamp_s);
  }
  if (nearest == nullptr) return std::nullopt;
  ++used_;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(nearest->orientation);
  return FromSpace(T).tilt;
}

}  // namespace ceilmap::commands
