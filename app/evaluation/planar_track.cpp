#include "app/evaluation/planar_track.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics.hpp"

namespace ceilmap::evaluation {
namespace {

constexpr double kMinGapS = 1;
constexpr double kGapSteps = 5;

}  // namespace

PlanarTrack::PlanarTrack(const std::vector<StampedPose>& poses) {
  stamps_s_.reserve(poses.size());
  points_.reserve(poses.size());
  std::vector<double> steps_s;
  for (const StampedPose& pose : poses) {
    double yaw = YawOf(pose);
    if (!points_.empty()) {
      yaw = points_.back().yaw + WrapAngle(yaw - points_.back().yaw);
      steps_s.push_back(pose.stamp_s - stamps_s_.back());
    }
    stamps_s_.push_back(pose.stamp_s);
    points_.push_back({pose.position.head<2>(), yaw});
  }
  median_step_s_ = Median(std::move(steps_s));
}

std::optional<PlanarTrack::Point> PlanarTrack::At(double stamp_s) const {
  if (stamp_s < Start() || stamp_s > End()) return std::nullopt;
  const auto later = std::lower_bound(stamps_s_.begin(), stamps_s_.end(), stamp_s);
  const auto j = static_cast<std::size_t>(later - stamps_s_.begin());
  if (*later == stamp_s) return points_[j];
  const double step_s = stamps_s_[j] - stamps_s_[j - 1];
  if (step_s > std::max(kMinGapS, kGapSteps * median_step_s_)) return std::nullopt;
  const double fraction = (stamp_s - stamps_s_[j - 1]) / step_s;
  const Point& a = points_[j - 1];
  const Point& b = points_[j];
  return Point{a.position + fraction * (b.position - a.position),
               a.yaw + fraction * (b.yaw - a.yaw)};
}

}  // namespace ceilmap::evaluation
