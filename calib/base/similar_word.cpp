#include "calib/base/similar_word.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace ceilmap {

std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row.back();
}

std::string SimilarWord(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t kMaxDistance = 2;
  std::size_t least = std::max(kMaxDistance, word.size() / 3) + 1;
  std::string similar;
  for (const std::string& candidate : known) {
    const std::size_t distance = EditDistance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    similar = candidate;
  }
  return similar;
}

std::string DidYouMean(std::string_view word, const std::vector<std::string>& known) {
  const std::string similar = SimilarWord(word, known);
  return similar.empty() ? ";" : fmt::format("; did you mean '{}'?", similar);
}

}  // namespace ceilmap
