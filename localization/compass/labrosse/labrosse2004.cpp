#include "localization/compass/labrosse/labrosse2004.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/heading_variance.hpp"
#include "localization/compass/labrosse/column_shift.hpp"
#include "localization/compass/labrosse/constants.hpp"
#include "localization/compass/labrosse/field_distance.hpp"
#include "localization/compass/labrosse/shift_minimum.hpp"

namespace ceilmap::labrosse {
namespace {

std::vector<double> Roots(const std::vector<std::uint64_t>& squared) {
  std::vector<double> roots;
  roots.reserve(squared.size());
  for (const std::uint64_t value : squared) roots.push_back(std::sqrt(static_cast<double>(value)));
  return roots;
}

}  // namespace

std::optional<compass::HeadingEstimate> Labrosse2004::Next(const compass::PanoramaFrame& frame) {
  check_.Take(frame);
  frame.panorama.copyTo(current_);
  const std::vector<float> everywhere(static_cast<std::size_t>(current_.cols), 1);
  const bool textured = RowTexture(current_, everywhere) >= kMinTexture;
  if (check_.Frames() == 1) reference_stamp_s_ = frame.stamp_s;
  if (reference_.empty()) {
    Hold(frame.stamp_s);
    if (textured) {
      estimate_.confidence = 1;
      MakeReference(frame.stamp_s);
    }
    return estimate_;
  }
  squared_ = SquaredShiftDistances(reference_, current_);
  compared_frame_ = reference_frame_;
  shift_columns_ = 0;
  if (textured && Turn()) {
    MakeReference(frame.stamp_s);
  } else {
    Hold(frame.stamp_s);
  }
  return estimate_;
}

/// Measures the turn by the least distance; returns false if the distances do not determine it.
bool Labrosse2004::Turn() {
  const std::optional<int> shift = LeastShift(squared_);
  if (!shift) return false;
  const int columns = current_.cols;
  const std::vector<double> distances = Roots(squared_);
  const auto distance = [&](int at) {
    return distances[static_cast<std::size_t>((at % columns + columns) % columns)];
  };
  const ShiftNeighbours around{distance(*shift - 1), distance(*shift), distance(*shift + 1)};
  const double column_rad = kTurn / columns;
  constexpr double kRounding = 1.0 / 12;
  const double variance = kRounding + ShiftVariance(around, kTurn / kIndependentRad);
  shift_columns_ = 2 * *shift == columns ? -*shift : *shift;
  estimate_.heading_rad = WrapAngle(at_reference_.heading_rad + *shift * column_rad);
  estimate_.variance_rad2 =
      compass::ChainedVariance(at_reference_.variance_rad2, variance * column_rad * column_rad);
  estimate_.confidence = RelativeDepth(distances);
  return true;
}

void Labrosse2004::Hold(double stamp_s) {
  estimate_ = {.heading_rad = at_reference_.heading_rad,
               .variance_rad2 = compass::HeldVariance(
                   at_reference_.variance_rad2, kUnseenRateRadS, stamp_s - reference_stamp_s_),
               .confidence = 0};
}

void Labrosse2004::MakeReference(double stamp_s) {
  std::swap(reference_, current_);
  reference_frame_ = check_.Frames() - 1;
  reference_stamp_s_ = stamp_s;
  at_reference_ = estimate_;
  ++references_;
}

compass::DistanceProfile Labrosse2004::Profile() const {
  return {.distance = Roots(squared_),
          .shift_columns = static_cast<double>(shift_columns_),
          .reference_frame = compared_frame_};
}

}  // namespace ceilmap::labrosse
