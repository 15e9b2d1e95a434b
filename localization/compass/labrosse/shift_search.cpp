#include "localization/compass/labrosse/shift_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "calib/base/error.hpp"
#include "localization/compass/labrosse/constants.hpp"

namespace ceilmap::labrosse {
namespace {

// Number of shifts tried around a minimum, even, >= 2, half of them to either side.
constexpr int kProbes = 8;

/// Cache of the distances: each is computed once.
class KnownDistances {
 public:
  KnownDistances(const std::function<double(int)>& distance, int columns)
      : distance_(distance), columns_(columns), known_(static_cast<std::size_t>(columns), -1) {}

  double operator()(int shift) {
    const int wrapped = (shift % columns_ + columns_) % columns_;
    double& known = known_[static_cast<std::size_t>(wrapped)];
    if (known < 0) known = distance_(wrapped);
    return known;
  }

 private:
  const std::function<double(int)>& distance_;
  int columns_;
  std::vector<double> known_;  ///< negative: not computed yet
};

int Descend(KnownDistances& distance, int shift) {
  while (true) {
    const double here = distance(shift);
    const double left = distance(shift - 1);
    const double right = distance(shift + 1);
    if (std::min(left, right) >= here) return shift;
    shift += left < right ? -1 : 1;
  }
}

std::vector<int> ProbeOffsets(int columns, double probe_span_rad) {
  const int half = kProbes / 2;
  const double step = probe_span_rad / kTurn * columns / kProbes;
  std::vector<int> offsets;
  for (int i = 1; i <= half; ++i) {
    // Where the columns are coarse, the probes are adjacent columns.
    const int offset = std::max(i, static_cast<int>(std::lround(i * step)));
    offsets.push_back(-offset);
    offsets.push_back(offset);
  }
  return offsets;
}

}  // namespace

FoundShift FindShift(const std::function<double(int)>& distance,
                     int columns,
                     int start,
                     double probe_span_rad) {
  KnownDistances known(distance, columns);
  const std::vector<int> offsets = ProbeOffsets(columns, probe_span_rad);
  int shift = Descend(known, start);
  while (true) {
    const int lowest = *std::min_element(offsets.begin(), offsets.end(), [&](int a, int b) {
      return known(shift + a) < known(shift + b);
    });
    if (known(shift + lowest) >= known(shift)) break;
    shift = Descend(known, shift + lowest);
  }
  FoundShift found{.columns = shift,
                   .distances = {known(shift - 1), known(shift), known(shift + 1)}};
  std::vector<double> around{found.distances.left, found.distances.least, found.distances.right};
  for (const int offset : offsets) around.push_back(known(shift + offset));
  found.depth = RelativeDepth(around);
  return found;
}

}  // namespace ceilmap::labrosse
