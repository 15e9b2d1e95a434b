#include "localization/compass/labrosse/labrosse2006.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/fields_of_view.hpp"
#include "localization/compass/heading_variance.hpp"
#include "localization/compass/labrosse/constants.hpp"
#include "localization/compass/labrosse/field_distance.hpp"
#include "localization/compass/labrosse/shift_minimum.hpp"

namespace ceilmap::labrosse {
namespace {

// A minimum with a smaller normalised amplitude, [0, 1), is rejected: the panoramas do not show
// the same surroundings.
constexpr double kMinAmplitude = 0.05;
// Standard deviation of the sub-pixel minimum between panoramas that agree, columns, > 0.
constexpr double kInterpolationSigmaColumns = 0.05;

}  // namespace

/// Distances of two panoramas at any shift.
class Labrosse2006::Distances {
 public:
  Distances(const cv::Mat& reference, const cv::Mat& current, const std::vector<float>& weights)
      : squared_(reference, current, weights), columns_(current.cols) {}

  [[nodiscard]] double At(int shift) const {
    return std::sqrt(static_cast<double>(squared_.Squared(shift)));
  }
  /// Half a turn from a shift, Eq. 9 and, between two columns, Eq. 7.
  [[nodiscard]] double OppositeOf(double shift) const {
    const double opposite = shift + 0.5 * columns_;
    const double column = std::floor(opposite);
    const double part = opposite - column;
    const double here = At(static_cast<int>(column));
    return part > 0 ? (1 - part) * here + part * At(static_cast<int>(column) + 1) : here;
  }

 private:
  FieldDistance squared_;
  int columns_;
};

void Labrosse2006Params::Validate() const {
  const FieldCheck require("labrosse2006");
  require(field_of_view_rad > 0 && field_of_view_rad <= kTurn,
          "field_of_view_rad",
          field_of_view_rad,
          "in (0, 2 pi]");
  require(threshold >= 0 && threshold <= 1, "threshold", threshold, "in [0, 1]");
  require(skip.value_or(0) >= 0, "skip", skip.value_or(0), ">= 0");
}

Labrosse2006::Labrosse2006(const Labrosse2006Params& params) : params_(params) {
  params_.Validate();
}

std::optional<compass::HeadingEstimate> Labrosse2006::Next(const compass::PanoramaFrame& frame) {
  check_.Take(frame);
  if ((check_.Frames() - 1) % (params_.skip.value_or(0) + 1) != 0) return std::nullopt;
  travel_.Move(frame.travel);
  weights_ = compass::FieldsOfView::FrontAndBack(travel_.Direction(), params_.field_of_view_rad)
                 .ColumnWeights(frame.panorama.cols);
  frame.panorama.copyTo(current_);
  const bool textured = RowTexture(current_, weights_) >= kMinTexture;
  if (check_.Frames() == 1) last_stamp_s_ = frame.stamp_s;
  if (reference_.panorama.empty()) {
    Begin(frame, textured);
    return estimate_;
  }
  ++frames_since_;
  compared_ = true;
  if (textured) {
    Follow(frame);
  } else {
    Hold(frame.stamp_s);
  }
  return estimate_;
}

/// The first frame with texture becomes the reference.
void Labrosse2006::Begin(const compass::PanoramaFrame& frame, bool textured) {
  Hold(frame.stamp_s);
  if (!textured) return;
  estimate_.confidence = 1;
  last_ = estimate_;
  last_stamp_s_ = frame.stamp_s;
  previous_ = {.panorama = current_.clone(),
               .weights = weights_,
               .frame = check_.Frames() - 1,
               .stamp_s = frame.stamp_s,
               .estimate = estimate_,
               .measured = true};
  PreviousBecomesReference();
}

void Labrosse2006::Follow(const compass::PanoramaFrame& frame) {
  if (params_.skip && previous_.measured) PreviousBecomesReference();
  Measurement measured = Measure();
  if (PreviousIsBetter(measured)) {
    PreviousBecomesReference();
    measured = Measure();
  }
  const bool fits = measured.amplitude > 0 && measured.amplitude >= kMinAmplitude;
  if (fits) {
    Accept(measured, frame.stamp_s);
  } else {
    Hold(frame.stamp_s);
  }
  previous_ = {.panorama = current_.clone(),
               .weights = weights_,
               .frame = check_.Frames() - 1,
               .stamp_s = frame.stamp_s,
               .estimate = estimate_,
               .measured = fits};
}

/// Measures the shift of the reference's content to the current panorama.
Labrosse2006::Measurement Labrosse2006::Measure() const {
  const int columns = current_.cols;
  const Distances distances(reference_.panorama, current_, weights_);
  const double expected_rad = WrapAngle(ExpectedHeading() - reference_.estimate.heading_rad);
  const FoundShift found = FindShift([&](int shift) { return distances.At(shift); },
                                     columns,
                                     static_cast<int>(std::lround(expected_rad / kTurn * columns)));
  Measurement measured = Interpolated(distances, found);
  const double seen = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  const double independent = std::max(seen / columns * kTurn / kIndependentRad, 1.0);
  // Even a very flat minimum lies within the range of the probes.
  const double reach = kProbeSpanRad / kTurn * columns / 2;
  measured.variance_columns2 =
      std::min(ShiftVariance(found.distances, independent), reach * reach) +
      kInterpolationSigmaColumns * kInterpolationSigmaColumns;
  return measured;
}

/// The minimum between the columns, and its normalised amplitude.
Labrosse2006::Measurement Labrosse2006::Interpolated(const Distances& distances,
                                                     const FoundShift& found) const {
  if (params_.variant == Labrosse2006Variant::kProbes) {
    return {.shift_columns = found.columns + BlendedMinimum(found.distances, found.depth).shift,
            .amplitude = found.depth};
  }
  if (!(reference_.own_amplitude > 0 && reference_.own_column_amplitude > 0)) return {};
  const double column_amplitude = distances.OppositeOf(found.columns) - found.distances.least;
  const SubPixelMinimum minimum = BlendedMinimum(
      found.distances, LinearPart(column_amplitude / reference_.own_column_amplitude));
  const double shift = found.columns + minimum.shift;
  const double amplitude = distances.OppositeOf(shift) - minimum.distance;
  return {.shift_columns = shift, .amplitude = amplitude / reference_.own_amplitude};
}

/// The amplitudes of the reference and itself, Eq. 8.
void Labrosse2006::MeasureReference() {
  const Distances distances(reference_.panorama, reference_.panorama, reference_.weights);
  const ShiftNeighbours around{distances.At(-1), distances.At(0), distances.At(1)};
  const SubPixelMinimum minimum = LinearMinimum(around);
  reference_.own_column_amplitude = distances.OppositeOf(0) - around.least;
  reference_.own_amplitude = distances.OppositeOf(minimum.shift) - minimum.distance;
}

double Labrosse2006::ExpectedHeading() const {
  const bool turns_on = params_.variant == Labrosse2006Variant::kProbes;
  return last_.heading_rad + (turns_on ? frames_since_ * turn_per_frame_rad_ : 0);
}

/// A view whose heading was only held would lose the turns of the robot in the meantime. Such a
/// view becomes the reference only where the current reference gives no information at all.
bool Labrosse2006::PreviousIsBetter(const Measurement& measured) const {
  if (previous_.frame == reference_.frame) return false;
  if (measured.amplitude < kMinAmplitude) return true;
  return previous_.measured && measured.amplitude < params_.threshold;
}

void Labrosse2006::PreviousBecomesReference() {
  if (previous_.frame == reference_.frame && references_ > 0) return;
  reference_ = previous_;
  MeasureReference();
  if (!reference_.measured) {
    // The search continues from the reference's heading, regardless of the turns since then.
    last_ = reference_.estimate;
    last_stamp_s_ = reference_.stamp_s;
    frames_since_ = 1;
    turn_per_frame_rad_ = 0;
  }
  ++references_;
}

void Labrosse2006::Accept(const Measurement& measured, double stamp_s) {
  const double column_rad = kTurn / current_.cols;
  estimate_.heading_rad =
      WrapAngle(reference_.estimate.heading_rad + measured.shift_columns * column_rad);
  estimate_.variance_rad2 = compass::ChainedVariance(
      reference_.estimate.variance_rad2, measured.variance_columns2 * column_rad * column_rad);
  estimate_.confidence = std::clamp(measured.amplitude, 0.0, 1.0);
  turn_per_frame_rad_ =
      WrapAngle(estimate_.heading_rad - last_.heading_rad) / std::max(frames_since_, 1);
  last_ = estimate_;
  last_stamp_s_ = stamp_s;
  frames_since_ = 0;
}

void Labrosse2006::Hold(double stamp_s) {
  estimate_ = {.heading_rad = last_.heading_rad,
               .variance_rad2 = compass::HeldVariance(
                   last_.variance_rad2, kUnseenRateRadS, stamp_s - last_stamp_s_),
               .confidence = 0};
}

compass::DistanceProfile Labrosse2006::Profile() const {
  compass::DistanceProfile profile;
  if (!compared_) return profile;
  const int columns = current_.cols;
  const FieldDistance distance(reference_.panorama, current_, weights_);
  for (int shift = 0; shift < columns; ++shift) {
    profile.distance.push_back(std::sqrt(static_cast<double>(distance.Squared(shift))));
  }
  const double turned = estimate_.heading_rad - reference_.estimate.heading_rad;
  profile.shift_columns = std::remainder(turned / kTurn * columns, columns);
  if (2 * profile.shift_columns >= columns) profile.shift_columns -= columns;
  profile.reference_frame = reference_.frame;
  return profile;
}

}  // namespace ceilmap::labrosse
