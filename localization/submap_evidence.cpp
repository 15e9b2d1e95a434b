#include "localization/submap_evidence.hpp"

#include <cmath>
#include <numbers>

namespace ceilmap::localization {

namespace {

constexpr double kMinLead = 1.35;  // of one search
// ... and of several together.
constexpr int kMinAgreeing = 3;
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
  if (!agrees) {
    agreeing_ = 0;
    leads_ = 1;
  }
  last_lead_ = found.Lead();
  ++agreeing_;
  leads_ *= last_lead_;
  T_map_submap_ = T_map_submap;
}

bool SubmapEvidence::IsClear() const {
  return last_lead_ > kMinLead || (agreeing_ >= kMinAgreeing && leads_ > kMinLeads);
}

}  // namespace ceilmap::localization
