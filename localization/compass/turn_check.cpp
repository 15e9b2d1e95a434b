#include "localization/compass/turn_check.hpp"

#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {
namespace {

using wheels::RelativeTurn;

// A turn contradicts another when it differs by more standard deviations, and by more than an angle
// that a disturbed panorama is wrong by without stating it, rad.
constexpr double kSigmas = 4;
constexpr double kFloorRad = 0.01;
// Wheels slip by less at a time, rad. More is a panorama of a place that looks alike in two
// directions.
constexpr double kMaxSlipRad = 1;
// So many frames after each other that contradict the wheels by the same angle tell a slip.
constexpr int kSlipFrames = 5;

std::optional<RelativeTurn> Joined(const std::optional<RelativeTurn>& a,
                                   const std::optional<RelativeTurn>& b) {
  if (!a || !b) return std::nullopt;
  return *a + *b;
}

}  // namespace

void TurnCheck::Begin(const std::optional<RelativeTurn>& turn) {
  since_measured_ = Joined(since_measured_, turn);
  since_reference_ = Joined(since_reference_, turn);
  latest_variance_ = turn ? turn->Variance() : 0;
  disagreement_rad2_ = 0;
}

double TurnCheck::Offset(double seen_rad) const {
  return WrapAngle(seen_rad - since_measured_->turn_rad);
}

bool TurnCheck::Contradicts(double seen_rad, double variance_rad2) const {
  if (!since_measured_) return false;
  const double sigma = std::sqrt(since_measured_->Variance() + variance_rad2);
  return std::abs(Offset(seen_rad)) > kSigmas * sigma + kFloorRad;
}

TurnCheck::Verdict TurnCheck::Judge(double seen_rad, double variance_rad2) {
  if (!Contradicts(seen_rad, variance_rad2)) {
    steady_ = 0;
    return Verdict::kAgrees;
  }
  const double offset = Offset(seen_rad);
  if (since_measured_->may_slip) {
    // While the panoramas turn as the wheels do, neither follows a moving object nor slips.
    const double change = std::abs(WrapAngle(offset - offset_rad_));
    const bool steady =
        steady_ > 0 && change < kSigmas * std::sqrt(latest_variance_ + variance_rad2) + kFloorRad;
    steady_ = steady ? steady_ + 1 : 1;
    offset_rad_ = offset;
    if (steady_ >= kSlipFrames && std::abs(offset) < kMaxSlipRad) {
      steady_ = 0;
      since_reference_.reset();
      return Verdict::kSlipped;
    }
    disagreement_rad2_ = offset * offset;
  }
  return Verdict::kDropped;
}

bool TurnCheck::Waits() const {
  return disagreement_rad2_ > 0 && steady_ < kSlipFrames;
}

void TurnCheck::Measured() {
  since_measured_ = kNone;
  to_measured_ = since_reference_;
}

void TurnCheck::RefersToThis() {
  since_reference_ = kNone;
  to_measured_ = kNone;
}

std::optional<RelativeTurn> TurnCheck::RefersToMeasured() {
  const std::optional<RelativeTurn> turn = to_measured_;
  since_reference_ = since_measured_;
  to_measured_ = kNone;
  return turn;
}

}  // namespace ceilmap::compass
