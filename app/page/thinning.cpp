#include "app/page/thinning.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ceilmap::page {
namespace {

std::vector<std::size_t> AllIndices(std::size_t count) {
  std::vector<std::size_t> indices(count);
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return indices;
}

// The points of y[begin, end) that stand for it, in order.
std::vector<std::size_t> Stretch(const std::vector<double>& y, std::size_t begin, std::size_t end) {
  std::size_t least = end;
  std::size_t greatest = end;
  std::size_t gap = end;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(y[i])) {
      gap = i;
    } else {
      if (least == end || y[i] < y[least]) least = i;
      if (greatest == end || y[i] > y[greatest]) greatest = i;
    }
  }
  std::vector<std::size_t> chosen = {begin, least, greatest, gap};
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  if (chosen.back() == end) chosen.pop_back();
  return chosen;
}

}  // namespace

std::vector<std::size_t> EvenIndices(std::size_t count, std::size_t keep) {
  if (keep >= count) return AllIndices(count);
  if (keep < 2) return {0};
  std::vector<std::size_t> indices;
  indices.reserve(keep);
  for (std::size_t i = 0; i < keep; ++i) indices.push_back(i * (count - 1) / (keep - 1));
  return indices;
}

std::vector<std::size_t> CurveIndices(const std::vector<double>& y, std::size_t keep) {
  if (keep >= y.size()) return AllIndices(y.size());
  const std::size_t stretches = keep / 4;
  std::vector<std::size_t> indices;
  indices.reserve(keep + 1);
  for (std::size_t i = 0; i < stretches; ++i) {
    const std::vector<std::size_t> chosen =
        Stretch(y, i * y.size() / stretches, (i + 1) * y.size() / stretches);
    indices.insert(indices.end(), chosen.begin(), chosen.end());
  }
  if (indices.back() != y.size() - 1) indices.push_back(y.size() - 1);
  return indices;
}

}  // namespace ceilmap::page
