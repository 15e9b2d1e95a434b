#include "localization/submap_evidence.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

namespace ceilmap::localization {

namespace {

constexpr double kMinLead = 1.35;  // of one search
// ... and of several together.
constexpr std::size_t kMinAgreeing = 3;
constexpr std::size_t kMaxAgreeing = 4;
constexpr double kMinLeads = 1.55;
// Places of two searches that are the same: what the robot's own motion is off between them.
constexpr double kAgreeRatio = 0.15;  // of the span
constexpr double kAgreeRad = 15 * std::numbers::pi / 180;

}  // namespace

void SubmapEvidence::Clear() {
  *this = {};
}

void SubmapEvidence::Add(const SubmapSearch::Result& found,
                         const Pose2& T_submap_base,
                         double span) {
  const Pose2 T_map_submap = found.pose.pose * T_submap_base.Inverse();
  bool agrees = false;
  if (T_map_submap_) {
    const Pose2 off = found.pose.pose.Inverse() * (*T_map_submap_ * T_submap_base);
    agrees = off.Translation().norm() < kAgreeRatio * span && std::abs(off.yaw) < kAgreeRad;
  }
  if (!agrees) leads_.clear();
  leads_.push_back(found.Lead());
  if (leads_.size() > kMaxAgreeing) leads_.pop_front();
  T_map_submap_ = T_map_submap;
}

bool SubmapEvidence::IsClear() const {
  if (leads_.empty()) return false;
  if (leads_.back() > kMinLead) return true;
  const double product = std::accumulate(leads_.begin(), leads_.end(), 1.0, std::multiplies<>());
  return leads_.size() >= kMinAgreeing && product > kMinLeads;
}

}  // namespace ceilmap::localization
