#include "mapping/mosaic/height_map.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr double kCellsPerStep = 4;  // cells of the raster across one step of a height field
constexpr int kSquare = 32;          // side of the squares by which votes are stored, cells
/// Radius in which a block votes, steps of its field. Blocks overlap by half: its side is two.
constexpr double kReach = 1.0;
constexpr float kMaxRadius = 8;  // cells
/// Votes for one surface differ by no more than this part of rho to each side.
constexpr float kSameSurface = 0.025F;
/// A surface covers a place if it has this part of the votes of the most frequent surface.
constexpr float kCovers = 1.0F / 3;
/// A place is known from this weight on; one accurate block at half of its radius has 0.5.
constexpr float kMinWeight = 0.1F;
constexpr double kAccurate = 0.01;  // standard deviation of a vote of weight 1
constexpr int kFillPasses = 5;      // widest gap that is filled, cells from its border

std::int64_t SquareKey(int x, int y) {
  return std::int64_t{y} * (std::int64_t{1} << 32) + x;
}

int SquareOf(int cell) {
  return cell >= 0 ? cell / kSquare : -((kSquare - 1 - cell) / kSquare);
}

/// Calls visit(x, y, rho, sigma, step) for each measured cell, in map coordinates.
template <typename Visit>
void ForEachPoint(const std::vector<graph::Keyframe>& keyframes,
                  const store::MapMetadata& metadata,
                  const Visit& visit) {
  const std::vector<ViewPlacement> views = PlaceViews(keyframes, metadata);
  const cv::Point2d centre((metadata.view_size.width - 1) / 2.0,
                           (metadata.view_size.height - 1) / 2.0);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (!keyframes[k].heights) continue;
    const heights::HeightField& field = *keyframes[k].heights;
    const double step = field.step_px.minCoeff() * metadata.view_units_per_px;
    for (std::size_t i = 0; i < field.cells.size(); ++i) {
      const heights::HeightCell& cell = field.cells[i];
      if (!(cell.sigma < heights::kMeasuredSigma) || !(cell.rho > 0)) continue;
      const Eigen::Vector2d at = field.Centre(i);
      visit(views[k].ToMap(centre.x + at.x(), centre.y + at.y(), cell.rho), cell, step);
    }
  }
}

/// One surface as seen by one vote at a place.
struct Opinion {
  float rho;
  float weight;
};

/// The ratio of the surface that covers a place; 0: not known. @param opinions  sorted.
float Elect(std::vector<Opinion>& opinions) {
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

/// Cells that are not known get the median of their known neighbours.
void FillBorder(cv::Mat& rho) {
  const cv::Mat before = rho.clone();
  std::vector<float> known;
  for (int row = 0; row < rho.rows; ++row) {
    for (int col = 0; col < rho.cols; ++col) {
      if (before.at<float>(row, col) > 0) continue;
      known.clear();
      for (int r = std::max(0, row - 1); r <= std::min(rho.rows - 1, row + 1); ++r) {
        for (int c = std::max(0, col - 1); c <= std::min(rho.cols - 1, col + 1); ++c) {
          if (before.at<float>(r, c) > 0) known.push_back(before.at<float>(r, c));
        }
      }
      if (known.empty()) continue;
      const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
      std::nth_element(known.begin(), middle, known.end());
      rho.at<float>(row, col) = *middle;
    }
  }
}

}  // namespace

HeightMap::HeightMap(const std::vector<graph::Keyframe>& keyframes,
                     const store::MapMetadata& metadata) {
  double finest = 0;
  cv::Point2d low;
  cv::Point2d high;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& /*cell*/, double step) {
                 const bool first = finest == 0;
                 finest = first ? step : std::min(finest, step);
                 low = first ? at : cv::Point2d(std::min(low.x, at.x), std::min(low.y, at.y));
                 high = first ? at : cv::Point2d(std::max(high.x, at.x), std::max(high.y, at.y));
               });
  if (!(finest > 0)) return;
  // Without pixels where the numbers are not those of a building.
  store::MosaicGrid grid;
  grid.resolution = finest / kCellsPerStep;
  const double margin = kMaxRadius + kFillPasses;
  grid.min_x = (std::floor(low.x / grid.resolution) - margin) * grid.resolution;
  grid.max_y = (std::ceil(high.y / grid.resolution) + margin) * grid.resolution;
  constexpr double kMaxPixels = 1e9;
  grid.width_px = static_cast<int>(
      std::min(std::ceil((high.x - grid.min_x) / grid.resolution) + margin, kMaxPixels));
  grid.height_px = static_cast<int>(
      std::min(std::ceil((grid.max_y - low.y) / grid.resolution) + margin, kMaxPixels));
  if (!store::Problem(grid).empty()) return;
  grid_ = grid;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& cell, double step) {
                 const double radius = kReach * step / (cell.rho * grid_.resolution);
                 const double part = kAccurate / std::max<double>(cell.sigma, kAccurate);
                 Add({static_cast<float>((at.x - grid_.min_x) / grid_.resolution - 0.5),
                      static_cast<float>((grid_.max_y - at.y) / grid_.resolution - 0.5),
                      std::min(static_cast<float>(radius), kMaxRadius),
                      cell.rho,
                      static_cast<float>(part * part)});
               });
}

void HeightMap::Add(const Vote& vote) {
  votes_[SquareKey(SquareOf(static_cast<int>(vote.col)), SquareOf(static_cast<int>(vote.row)))]
      .push_back(vote);
}

cv::Mat HeightMap::Elected(const cv::Rect& window) const {
  std::vector<std::vector<Opinion>> opinions(static_cast<std::size_t>(window.area()));
  const auto reach = static_cast<int>(kMaxRadius) + 1;
  for (int y = SquareOf(window.y - reach); y <= SquareOf(window.br().y - 1 + reach); ++y) {
    for (int x = SquareOf(window.x - reach); x <= SquareOf(window.br().x - 1 + reach); ++x) {
      const auto found = votes_.find(SquareKey(x, y));
      if (found == votes_.end()) continue;
      for (const Vote& vote : found->second) {
        const int first_col =
            std::max(window.x, static_cast<int>(std::ceil(vote.col - vote.radius)));
        const int last_col =
            std::min(window.br().x - 1, static_cast<int>(std::floor(vote.col + vote.radius)));
        const int first_row =
            std::max(window.y, static_cast<int>(std::ceil(vote.row - vote.radius)));
        const int last_row =
            std::min(window.br().y - 1, static_cast<int>(std::floor(vote.row + vote.radius)));
        for (int row = first_row; row <= last_row; ++row) {
          for (int col = first_col; col <= last_col; ++col) {
            const float dx = (static_cast<float>(col) - vote.col) / vote.radius;
            const float dy = (static_cast<float>(row) - vote.row) / vote.radius;
            const float fall = 1 - dx * dx - dy * dy;
            if (fall <= 0) continue;
            const auto at =
                static_cast<std::size_t>(row - window.y) * static_cast<std::size_t>(window.width) +
                static_cast<std::size_t>(col - window.x);
            opinions[at].push_back({vote.rho, vote.weight * fall * fall});
          }
        }
      }
    }
  }
  cv::Mat rho(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    for (int col = 0; col < window.width; ++col) {
      rho.at<float>(row, col) =
          Elect(opinions[static_cast<std::size_t>(row) * static_cast<std::size_t>(window.width) +
                         static_cast<std::size_t>(col)]);
    }
  }
  return rho;
}

cv::Mat HeightMap::Ratios(const cv::Rect& window) const {
  if (empty() || window.empty()) return cv::Mat(window.size(), CV_32FC1, cv::Scalar(0));
  const cv::Rect wide(window.x - kFillPasses,
                      window.y - kFillPasses,
                      window.width + 2 * kFillPasses,
                      window.height + 2 * kFillPasses);
  cv::Mat rho = Elected(wide);
  for (int pass = 0; pass < kFillPasses; ++pass) FillBorder(rho);
  return rho(cv::Rect(kFillPasses, kFillPasses, window.width, window.height)).clone();
}

}  // namespace ceilmap::mosaic
