#include "mapping/mosaic/surface_votes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/mosaic/raster_squares.hpp"
#include "mapping/mosaic/ratio_raster.hpp"

namespace ceilmap::mosaic {
namespace {

/// A surface covers a place if it has this part of the votes of the most frequent surface.
constexpr float kCovers = 1.0F / 3;
/// A place is known from this weight on; one accurate block at half of its radius has 0.5.
constexpr float kMinWeight = 0.1F;

/// One surface as seen by one vote at a place.
struct Opinion {
  float rho;
  float weight;
};

/// The ratio of the surface that covers a place; 0: not known. @param opinions  sorted.
float Winner(std::vector<Opinion>& opinions) {
  std::sort(opinions.begin(), opinions.end(), [](const Opinion& a, const Opinion& b) {
    return a.rho > b.rho || (a.rho == b.rho && a.weight > b.weight);
  });
  const std::size_t count = opinions.size();
  // Weight of the votes around each vote.
  const auto around = [&](std::size_t i) {
    const float tolerance = kSameSurface * opinions[i].rho;
    std::size_t first = i;
    while (first > 0 && opinions[first - 1].rho - opinions[i].rho <= tolerance) --first;
    std::size_t end = i + 1;
    while (end < count && opinions[i].rho - opinions[end].rho <= tolerance) ++end;
    return std::pair(first, end);
  };
  const auto weight = [&](std::pair<std::size_t, std::size_t> range) {
    float sum = 0;
    for (std::size_t i = range.first; i < range.second; ++i) sum += opinions[i].weight;
    return sum;
  };
  float most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, weight(around(i)));
  if (most < kMinWeight) return 0;
  // From the nearest on: the first surface with enough votes, at the vote where it has the most.
  std::size_t best = 0;
  float best_weight = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float here = weight(around(i));
    if (best_weight >= kCovers * most &&
        opinions[best].rho - opinions[i].rho > kSameSurface * opinions[best].rho) {
      break;
    }
    if (here >= kCovers * most && here > best_weight) {
      best = i;
      best_weight = here;
    }
  }
  const auto [first, end] = around(best);
  float sum = 0;
  for (std::size_t i = first; i < end; ++i) {
    sum += opinions[i].weight;
    if (2 * sum >= best_weight) return opinions[i].rho;
  }
  return opinions[best].rho;
}

/// Calls visit(col, row, weight) for each pixel of the window that a vote reaches.
template <typename Visit>
void ForEachReached(const SurfaceVotes::Vote& vote, const cv::Rect& window, const Visit& visit) {
  const auto from = [&](float at) { return static_cast<int>(std::ceil(at - vote.radius)); };
  const auto to = [&](float at) { return static_cast<int>(std::floor(at + vote.radius)); };
  const int last_row = std::min(window.br().y - 1, to(vote.row));
  const int last_col = std::min(window.br().x - 1, to(vote.col));
  for (int row = std::max(window.y, from(vote.row)); row <= last_row; ++row) {
    for (int col = std::max(window.x, from(vote.col)); col <= last_col; ++col) {
      const float dx = (static_cast<float>(col) - vote.col) / vote.radius;
      const float dy = (static_cast<float>(row) - vote.row) / vote.radius;
      const float part = 1 - dx * dx - dy * dy;
      if (part > 0) visit(col, row, vote.weight * part * part);
    }
  }
}

}  // namespace

void SurfaceVotes::Add(const Vote& vote) {
  const int x = squares::Of(static_cast<int>(vote.col));
  const int y = squares::Of(static_cast<int>(vote.row));
  votes_[squares::Key(x, y)].push_back(vote);
}

cv::Mat_<float> SurfaceVotes::Elect(const cv::Rect& window) const {
  std::vector<std::vector<Opinion>> opinions(static_cast<std::size_t>(window.area()));
  constexpr int kFar = static_cast<int>(kMaxRadius) + 1;
  for (int y = squares::Of(window.y - kFar); y <= squares::Of(window.br().y - 1 + kFar); ++y) {
    for (int x = squares::Of(window.x - kFar); x <= squares::Of(window.br().x - 1 + kFar); ++x) {
      const auto found = votes_.find(squares::Key(x, y));
      if (found == votes_.end()) continue;
      for (const Vote& vote : found->second) {
        ForEachReached(vote, window, [&](int col, int row, float weight) {
          const int at = (row - window.y) * window.width + col - window.x;
          opinions[static_cast<std::size_t>(at)].push_back({vote.rho, weight});
        });
      }
    }
  }
  cv::Mat_<float> rho(window.size());
  std::transform(opinions.begin(), opinions.end(), rho.begin(), Winner);
  return rho;
}

}  // namespace ceilmap::mosaic
