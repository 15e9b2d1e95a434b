#include "ceilmap_ros/logic/health.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "mapping/graph/keyframe.hpp"

namespace ceilmap_ros {
namespace {

constexpr Stamp kSilence = 2 * kSecond;

void AddFix(const Fix& fix, Stamp processed_at, Health& health) {
  constexpr double kDegree = std::numbers::pi / 180;
  auto& values = health.values;
  values.emplace_back("status", ceilmap::graph::ToString(fix.estimate.status));
  if (fix.pose) {
    const auto& covariance = fix.pose->covariance;
    const double sigma_m = std::sqrt(0.5 * covariance.topLeftCorner<2, 2>().trace());
    values.emplace_back("position sigma (m)", fmt::format("{:.4f}", sigma_m));
    values.emplace_back("yaw sigma (deg)",
                        fmt::format("{:.3f}", std::sqrt(covariance(2, 2)) / kDegree));
  }
  values.emplace_back("inliers", fmt::format("{}/{}", fix.estimate.inliers, fix.estimate.blocks));
  values.emplace_back("places", std::to_string(fix.estimate.hypotheses));
  values.emplace_back("odometry", ToString(fix.odometry));
  values.emplace_back("age of the image (s)",
                      fmt::format("{:.3f}", ToSeconds(processed_at - fix.stamp)));
}

std::vector<std::pair<std::string, std::string>> CountsOf(const HealthFacts& facts) {
  const InboxCounts& counts = facts.counts;
  return {
      {"map", facts.map},
      {"images", std::to_string(counts.images)},
      {"images processed", std::to_string(facts.frames)},
      {"images with a pose", std::to_string(facts.sure)},
      {"poses without odometry", std::to_string(facts.untransformed)},
      {"images dropped", std::to_string(counts.dropped)},
      {"images in the future", std::to_string(counts.future)},
      {"images without a stamp", std::to_string(counts.unstamped)},
      {"out of order", std::to_string(counts.out_of_order)},
      {"clock resets", std::to_string(counts.clock_resets)},
  };
}

std::pair<Health::Level, std::string> Verdict(const HealthFacts& facts, Stamp now) {
  using Level = Health::Level;
  if (facts.end) return {facts.ended_well ? Level::kOk : Level::kError, *facts.end};
  if (!facts.error.empty()) return {Level::kError, facts.error};
  if (facts.map.empty()) {
    return {Level::kError,
            facts.map_error.empty() ? "no map is loaded; call load_map" : facts.map_error};
  }
  if (facts.waits_for_camera) return {Level::kWarn, "waiting for camera_info"};
  const bool silent = !facts.fix || now - facts.processed_at > kSilence;
  if (silent && facts.counts.future > 0) {
    return {Level::kError,
            fmt::format("images are {:.3f} s in the future; synchronize the camera's clock",
                        facts.counts.future_s)};
  }
  if (silent && facts.counts.unstamped > 0) {
    return {Level::kError, "images have no stamp; let the camera's driver set it"};
  }
  if (silent) return {Level::kStale, "no images"};
  if (!facts.camera_mismatch.empty()) return {Level::kWarn, facts.camera_mismatch};
  const char* status = ceilmap::graph::ToString(facts.fix->estimate.status);
  if (!facts.fix->pose) return {Level::kWarn, status};
  if (!facts.fix->map_to_odom) return {Level::kWarn, ToString(facts.fix->odometry)};
  return {facts.fix->estimate.HasPose() ? Level::kOk : Level::kWarn, status};
}

}  // namespace

Health Judge(const HealthFacts& facts, Stamp now) {
  Health health;
  std::tie(health.level, health.message) = Verdict(facts, now);
  health.values = CountsOf(facts);
  if (facts.fix) AddFix(*facts.fix, facts.processed_at, health);
  return health;
}

void HealthRecord::SetMap(const std::string& file) {
  const std::scoped_lock lock(mutex_);
  facts_.map = file;
  facts_.fix.reset();
}

void HealthRecord::SetMapError(const std::string& error) {
  const std::scoped_lock lock(mutex_);
  facts_.map_error = error;
}

void HealthRecord::SetCamera(bool ready, const std::string& mismatch) {
  const std::scoped_lock lock(mutex_);
  facts_.waits_for_camera = !ready;
  facts_.camera_mismatch = mismatch;
}

void HealthRecord::Note(const std::optional<Fix>& fix, Stamp now) {
  const std::scoped_lock lock(mutex_);
  facts_.error.clear();
  if (!fix) return;
  facts_.fix = fix;
  facts_.processed_at = now;
  ++facts_.frames;
  if (fix->pose) ++facts_.sure;
  if (fix->pose && !fix->map_to_odom) ++facts_.untransformed;
}

void HealthRecord::NoteError(const std::string& error) {
  const std::scoped_lock lock(mutex_);
  facts_.error = error;
}

void HealthRecord::NoteEnd(bool ended_well, const std::string& message) {
  const std::scoped_lock lock(mutex_);
  facts_.ended_well = ended_well;
  facts_.end = message;
}

Health HealthRecord::Judge(const InboxCounts& counts, Stamp now) const {
  HealthFacts facts;
  {
    const std::scoped_lock lock(mutex_);
    facts = facts_;
  }
  facts.counts = counts;
  return ceilmap_ros::Judge(facts, now);
}

}  // namespace ceilmap_ros
