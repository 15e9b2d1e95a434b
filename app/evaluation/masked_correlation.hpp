#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::evaluation {

/// A signal on a grid, parts of which are not known.
struct MaskedSignal {
  std::vector<double> values;  ///< 0 where it is not known
  std::vector<double> known;   ///< 1 or 0, as many
};

/// How two signals agree when the second one starts `shift` samples after the first one does.
struct ShiftAgreement {
  std::int64_t shift = 0;
  double overlap = 0;      ///< samples that both know
  double variance = 0;     ///< of the first signal there
  double correlation = 0;  ///< Pearson's, of the two there; 0 where either does not vary
};

/// For all shifts at which the signals touch, rising, by fast Fourier transforms (Padfield 2012,
/// "Masked object registration in the Fourier domain").
/// @param a, b  at least one sample each. Cost: n log n in time and about 200 bytes a sample.
std::vector<ShiftAgreement> CorrelateShifts(const MaskedSignal& a, const MaskedSignal& b);

}  // namespace ceilmap::evaluation
