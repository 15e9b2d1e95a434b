#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::evaluation {

/// A signal on a grid, parts of which are unknown.
struct MaskedSignal {
  std::vector<double> values;  ///< 0 where it is unknown
  std::vector<double> known;   ///< 1 or 0 per value
};

/// Agreement of two signals when the second one starts `shift` samples after the first one.
struct ShiftAgreement {
  std::int64_t shift = 0;
  double overlap = 0;      ///< number of samples known in both
  double variance = 0;     ///< of the first signal in the overlap
  double correlation = 0;  ///< Pearson's, over the overlap; 0 where either is constant
};

/// Agreement at all shifts at which the signals overlap, rising, by fast Fourier transforms
/// (Padfield 2012, "Masked object registration in the Fourier domain").
/// @param a, b  At least one sample each. Cost: n log n in time and about 200 bytes per sample.
std::vector<ShiftAgreement> CorrelateShifts(const MaskedSignal& a, const MaskedSignal& b);

}  // namespace ceilmap::evaluation
