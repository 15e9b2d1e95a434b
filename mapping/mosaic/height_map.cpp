#include "mapping/mosaic/height_map.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "calib/base/parallel.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::mosaic {
namespace {

// Cells of the raster across one step of a height field of blocks; at least so many pixels of an
// image.
constexpr double kCellsPerStep = 4;
constexpr double kMinCellPx = 4;
constexpr int kSquare = 32;  // side of the squares by which votes are stored, cells
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
/// A surface hides a place if its ratio is larger than that of the ray by this part.
constexpr float kNearer = 0.05F;
constexpr int kFillReach = 5;      // widest gap that is filled, cells from its border
constexpr int kRefutedReach = 16;  // the same where a surface was refuted
/// A surface is refuted if fewer of the images of the place confirm it, and there are so many.
constexpr double kFewConfirm = 0.15;
constexpr int kManyImages = 8;
constexpr float kRefutedAround = 0.3F;  // part of the neighbours
constexpr double kAgree = 0.75;         // part of the images that agree on a surface

std::int64_t SquareKey(int x, int y) {
  return std::int64_t{y} * (std::int64_t{1} << 32) + x;
}

cv::Point SquareAt(std::int64_t key) {
  const auto x = static_cast<std::int32_t>(key & 0xffffffff);
  return {x, static_cast<int>((key - x) / (std::int64_t{1} << 32))};
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

/// The height of one cell of a keyframe, in the raster. The centre of the first pixel is (0, 0).
struct Vote {
  float col;
  float row;
  float radius;  // of influence, pixels of the raster
  float rho;
  float weight;
};
using Votes = std::unordered_map<std::int64_t, std::vector<Vote>>;  // by square

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

/// The ratio of a known surface near a cell: of several the farther one, because a gap is what the
/// nearer one hides from most images. 0: there is none.
float FartherNear(const cv::Mat& rho, const cv::Point& cell, int reach, std::vector<float>& known) {
  constexpr double kFarther = 0.2;  // quantile
  known.clear();
  for (int row = cell.y - reach; row <= cell.y + reach; ++row) {
    const auto* values = rho.ptr<float>(row);
    for (int col = cell.x - reach; col <= cell.x + reach; ++col) {
      if (values[col] > 0) known.push_back(values[col]);
    }
  }
  if (known.empty()) return 0;
  const auto farther =
      known.begin() + static_cast<std::ptrdiff_t>(kFarther * static_cast<double>(known.size()));
  std::nth_element(known.begin(), farther, known.end());
  return *farther;
}

/// Fills cells that are not known, and those that were refuted (< 0) in a wider reach: nothing
/// hides what is around them. @param before  with kRefutedReach more cells than the result on each
/// side.
cv::Mat FillGaps(const cv::Mat& before) {
  cv::Mat rho(kSquare, kSquare, CV_32FC1);
  std::vector<float> known;
  for (int row = 0; row < kSquare; ++row) {
    for (int col = 0; col < kSquare; ++col) {
      const cv::Point at(col + kRefutedReach, row + kRefutedReach);
      const float here = before.at<float>(at);
      const float filled =
          here > 0 ? here : FartherNear(before, at, here < 0 ? kRefutedReach : kFillReach, known);
      rho.at<float>(row, col) = filled > 0 ? filled : std::abs(here);
    }
  }
  return rho;
}

/// Calls visit(col, row, weight) for each pixel of the window that a vote reaches.
template <typename Visit>
void ForEachReached(const Vote& vote, const cv::Rect& window, const Visit& visit) {
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

/// Whether a measured cell of a field, or one beside it, has a ratio: a border may lie between
/// them.
bool Confirms(const heights::HeightField& field, std::size_t cell, float rho) {
  const auto width = static_cast<std::size_t>(field.grid.width);
  const std::size_t col = cell % width;
  const std::size_t row = cell / width;
  const std::size_t last_row = std::min<std::size_t>(row + 1, field.grid.height - 1);
  for (std::size_t v = row - (row > 0 ? 1 : 0); v <= last_row; ++v) {
    for (std::size_t u = col - (col > 0 ? 1 : 0); u <= std::min(col + 1, width - 1); ++u) {
      const heights::HeightCell& at = field.cells[v * width + u];
      if (at.sigma < heights::kMeasuredSigma && std::abs(at.rho - rho) < kNearer * rho) return true;
    }
  }
  return false;
}

cv::Mat ElectAll(const Votes& votes, const cv::Rect& window) {
  std::vector<std::vector<Opinion>> opinions(static_cast<std::size_t>(window.area()));
  constexpr int kFar = static_cast<int>(kMaxRadius) + 1;
  for (int y = SquareOf(window.y - kFar); y <= SquareOf(window.br().y - 1 + kFar); ++y) {
    for (int x = SquareOf(window.x - kFar); x <= SquareOf(window.br().x - 1 + kFar); ++x) {
      const auto found = votes.find(SquareKey(x, y));
      if (found == votes.end()) continue;
      for (const Vote& vote : found->second) {
        ForEachReached(vote, window, [&](int col, int row, float weight) {
          const int at = (row - window.y) * window.width + col - window.x;
          opinions[static_cast<std::size_t>(at)].push_back({vote.rho, weight});
        });
      }
    }
  }
  cv::Mat rho(window.size(), CV_32FC1);
  std::transform(opinions.begin(), opinions.end(), rho.begin<float>(), Elect);
  return rho;
}

/// Smallest distance of the cells of the height fields, map units; 0: there are none.
double FinestStep(const std::vector<graph::Keyframe>& keyframes,
                  const store::MapMetadata& metadata) {
  double finest = 0;
  for (const graph::Keyframe& keyframe : keyframes) {
    if (!keyframe.heights) continue;
    const double step = keyframe.heights->step_px.minCoeff() * metadata.view_units_per_px;
    finest = finest == 0 ? step : std::min(finest, step);
  }
  return finest;
}

/// Extent of a raster; without pixels where nothing is known, or the numbers are no usable ones.
store::MosaicGrid GridOf(const std::vector<graph::Keyframe>& keyframes,
                         const store::MapMetadata& metadata) {
  const double finest = FinestStep(keyframes, metadata);
  cv::Point2d low;
  cv::Point2d high;
  bool first = true;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& /*cell*/, double /*step*/) {
                 low = first ? at : cv::Point2d(std::min(low.x, at.x), std::min(low.y, at.y));
                 high = first ? at : cv::Point2d(std::max(high.x, at.x), std::max(high.y, at.y));
                 first = false;
               });
  if (first || !(finest > 0)) return {};
  constexpr double kMargin = kMaxRadius + kFillReach;
  constexpr double kMaxPixels = 1e9;
  store::MosaicGrid grid;
  grid.resolution = std::max(finest / kCellsPerStep, kMinCellPx * metadata.view_units_per_px);
  grid.min_x = (std::floor(low.x / grid.resolution) - kMargin) * grid.resolution;
  grid.max_y = (std::ceil(high.y / grid.resolution) + kMargin) * grid.resolution;
  const auto pixels = [&](double length) {
    return static_cast<int>(std::min(std::ceil(length / grid.resolution) + kMargin, kMaxPixels));
  };
  grid.width_px = pixels(high.x - grid.min_x);
  grid.height_px = pixels(grid.max_y - low.y);
  return store::Problem(grid).empty() ? grid : store::MosaicGrid();
}

}  // namespace

HeightMap::HeightMap(const std::vector<graph::Keyframe>& keyframes,
                     const store::MapMetadata& metadata,
                     int threads)
    : grid_(GridOf(keyframes, metadata)) {
  if (grid_.width_px == 0) return;
  const double finest = FinestStep(keyframes, metadata);
  Votes votes;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& cell, double step) {
                 const double radius = kReach * step / (cell.rho * grid_.resolution);
                 const double part = kAccurate / std::max<double>(cell.sigma, kAccurate);
                 // Where there are finer fields, blocks fill what those leave open.
                 const double share = finest / step;
                 const Vote vote{static_cast<float>((at.x - grid_.min_x) / grid_.resolution - 0.5),
                                 static_cast<float>((grid_.max_y - at.y) / grid_.resolution - 0.5),
                                 std::min(static_cast<float>(radius), kMaxRadius),
                                 cell.rho,
                                 static_cast<float>(share * share * part * part)};
                 const int x = SquareOf(static_cast<int>(vote.col));
                 const int y = SquareOf(static_cast<int>(vote.row));
                 votes[SquareKey(x, y)].push_back(vote);
                 // Votes reach into the squares around their own.
                 for (int v = y - 1; v <= y + 1; ++v) {
                   for (int u = x - 1; u <= x + 1; ++u) squares_[SquareKey(u, v)];
                 }
               });
  ForEachSquare(threads, [&](const cv::Point& first, cv::Mat& square) {
    square = ElectAll(votes, {first.x, first.y, kSquare, kSquare});
  });
  FindRange();
  ForEachCounted(
      keyframes,
      metadata,
      threads,
      [](const cv::Point& /*first*/, cv::Mat& square, const cv::Mat_<cv::Vec3i>& counts) {
        std::transform(
            square.begin<float>(),
            square.end<float>(),
            counts.begin(),
            square.begin<float>(),
            [](float rho, const cv::Vec3i& count) { return count[2] > count[1] ? -rho : rho; });
      });
  FillAll(threads);
  FindRange();
}

cv::Point2d HeightMap::PlaceOf(int col, int row) const {
  return {grid_.min_x + (col + 0.5) * grid_.resolution,
          grid_.max_y - (row + 0.5) * grid_.resolution};
}

template <typename Work>
void HeightMap::ForEachCounted(const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               int threads,
                               const Work& work) {
  const std::vector<ViewPlacement> views = PlaceViews(keyframes, metadata);
  const cv::Point2d centre((metadata.view_size.width - 1) / 2.0,
                           (metadata.view_size.height - 1) / 2.0);
  std::vector<cv::Rect2d> bounds;
  bounds.reserve(views.size());
  for (const ViewPlacement& view : views) {
    bounds.push_back(view.Bounds(range_[0]) | view.Bounds(range_[1]));
  }
  ForEachSquare(threads, [&](const cv::Point& first, cv::Mat& square) {
    const cv::Rect2d box(grid_.min_x + first.x * grid_.resolution,
                         grid_.max_y - (first.y + kSquare) * grid_.resolution,
                         kSquare * grid_.resolution,
                         kSquare * grid_.resolution);
    cv::Mat_<cv::Vec3i> counts(kSquare, kSquare, cv::Vec3i());
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!keyframes[k].heights || (bounds[k] & box).empty()) continue;
      const heights::HeightField& field = *keyframes[k].heights;
      for (int row = 0; row < kSquare; ++row) {
        for (int col = 0; col < kSquare; ++col) {
          const float rho = square.at<float>(row, col);
          if (rho <= 0) continue;
          const cv::Point2d place = PlaceOf(first.x + col, first.y + row);
          const cv::Point2d at = views[k].ToPixel(place.x, place.y, rho) - centre;
          const auto cell = field.CellAt({at.x, at.y});
          if (!cell) continue;
          cv::Vec3i& count = counts(row, col);
          ++count[0];
          if (Confirms(field, *cell, rho)) {
            ++count[1];
          } else if (field.cells[*cell].sigma < heights::kMeasuredSigma &&
                     field.cells[*cell].rho < rho * (1 - kNearer)) {
            ++count[2];
          }
        }
      }
    }
    work(first, square, counts);
  });
}

/// Fills small gaps in all squares.
void HeightMap::FillAll(int threads) {
  auto filled = squares_;
  constexpr int kWide = kSquare + 2 * kRefutedReach;
  ForEachSquare(threads, [&](const cv::Point& first, cv::Mat& /*square*/) {
    filled.at(SquareKey(SquareOf(first.x), SquareOf(first.y))) =
        FillGaps(Ratios({first.x - kRefutedReach, first.y - kRefutedReach, kWide, kWide}));
  });
  squares_ = std::move(filled);
}

template <typename Work>
void HeightMap::ForEachSquare(int threads, const Work& work) {
  std::vector<std::pair<std::int64_t, cv::Mat*>> squares;
  for (auto& [key, square] : squares_) squares.emplace_back(key, &square);
  std::sort(squares.begin(), squares.end());  // neighbours use the same images
  if (threads == 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  ParallelFor(static_cast<int>(squares.size()), std::max(threads, 1), [&](int i) {
    const auto& [key, square] = squares[static_cast<std::size_t>(i)];
    work(kSquare * SquareAt(key), *square);
  });
}

void HeightMap::FindRange() {
  bool first = true;
  for (const auto& [key, square] : squares_) {
    for (const float rho : cv::Mat_<float>(square)) {
      if (rho <= 0) continue;
      range_[0] = first ? rho : std::min(range_[0], rho);
      range_[1] = first ? rho : std::max(range_[1], rho);
      first = false;
    }
  }
}

std::vector<cv::Point2d> HeightMap::Settle(const std::vector<graph::Keyframe>& keyframes,
                                           const store::MapMetadata& metadata,
                                           const AgreementAt& agreement,
                                           int threads) {
  const Squares before = squares_;
  ForEachCounted(keyframes,
                 metadata,
                 threads,
                 [&](const cv::Point& first, cv::Mat& square, const cv::Mat_<cv::Vec3i>& counts) {
                   square = square.clone();  // `before` shares the old one
                   for (int row = 0; row < kSquare; ++row) {
                     for (int col = 0; col < kSquare; ++col) {
                       const cv::Vec3i& count = counts(row, col);
                       if (count[0] < kManyImages || count[1] >= kFewConfirm * count[0]) continue;
                       float& rho = square.at<float>(row, col);
                       if (agreement(PlaceOf(first.x + col, first.y + row), rho) < kAgree)
                         rho = -rho;
                     }
                   }
                 });
  RefuteAround(agreement, threads);
  return ReplaceRefuted(before, agreement, threads);
}

/// Refutes the surfaces among refuted ones on which the images do not agree: parts of the same
/// moving thing that several keyframes happened to measure.
void HeightMap::RefuteAround(const AgreementAt& agreement, int threads) {
  const Squares first_pass = squares_;
  constexpr int kReach = kFillReach;
  constexpr int kWide = kSquare + 2 * kReach;
  ForEachSquare(threads, [&](const cv::Point& first, cv::Mat& square) {
    cv::Mat wide(kWide, kWide, CV_32FC1, cv::Scalar(0));
    for (int row = 0; row < kWide; ++row) {
      for (int col = 0; col < kWide; ++col) {
        const cv::Point at(first.x + col - kReach, first.y + row - kReach);
        const auto found = first_pass.find(SquareKey(SquareOf(at.x), SquareOf(at.y)));
        if (found == first_pass.end()) continue;
        const cv::Point inner = at - kSquare * cv::Point(SquareOf(at.x), SquareOf(at.y));
        wide.at<float>(row, col) = found->second.at<float>(inner) < 0 ? 1.0F : 0.0F;
      }
    }
    cv::Mat parts;
    cv::boxFilter(wide, parts, -1, {2 * kReach + 1, 2 * kReach + 1});
    square = square.clone();
    for (int row = 0; row < kSquare; ++row) {
      for (int col = 0; col < kSquare; ++col) {
        float& rho = square.at<float>(row, col);
        if (rho <= 0 || parts.at<float>(row + kReach, col + kReach) < kRefutedAround) continue;
        if (agreement(PlaceOf(first.x + col, first.y + row), rho) < kAgree) rho = -rho;
      }
    }
  });
}

/// Fills what is refuted: where no surface explains the images, or the images agree at least as
/// well on the result.
/// @return the places that no surface explains.
std::vector<cv::Point2d> HeightMap::ReplaceRefuted(const Squares& before,
                                                   const AgreementAt& agreement,
                                                   int threads) {
  const Squares refuted = squares_;
  FillAll(threads);
  std::vector<cv::Point2d> moving;
  std::mutex mutex;
  ForEachSquare(threads, [&](const cv::Point& first, cv::Mat& square) {
    const std::int64_t key = SquareKey(SquareOf(first.x), SquareOf(first.y));
    const cv::Mat& old = before.at(key);
    const cv::Mat& flags = refuted.at(key);
    for (int row = 0; row < kSquare; ++row) {
      for (int col = 0; col < kSquare; ++col) {
        const cv::Point2d place = PlaceOf(first.x + col, first.y + row);
        float& rho = square.at<float>(row, col);
        const float old_rho = old.at<float>(row, col);
        if (flags.at<float>(row, col) >= 0) {
          rho = old_rho;
          continue;
        }
        bool explained = false;
        for (float r = range_[0]; r <= range_[1] && !explained; r *= 1 + kSameSurface) {
          explained = agreement(place, r) >= kAgree;
        }
        if (explained) {
          if (agreement(place, rho) < agreement(place, old_rho)) rho = old_rho;
          continue;
        }
        const std::lock_guard lock(mutex);
        moving.push_back(place);
      }
    }
  });
  FindRange();
  return moving;
}

float HeightMap::At(int col, int row) const {
  const cv::Point square(SquareOf(col), SquareOf(row));
  const auto found = squares_.find(SquareKey(square.x, square.y));
  if (found == squares_.end()) return 0;
  return found->second.ptr<float>(row - kSquare * square.y)[col - kSquare * square.x];
}

cv::Mat HeightMap::Ratios(const cv::Rect& window) const {
  cv::Mat ratios(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    auto* values = ratios.ptr<float>(row);
    for (int col = 0; col < window.width; ++col) {
      values[col] = At(window.x + col, window.y + row);
    }
  }
  return ratios;
}

namespace {

/// The ratio at a position of the raster, 0: not known. @param value  (col, row) of the raster.
template <typename Value>
float Interpolate(float x, float y, const Value& value) {
  const float nearest = value(cvRound(x), cvRound(y));
  if (nearest <= 0) return 0;
  const int col = cvFloor(x);
  const int row = cvFloor(y);
  const float fx = x - static_cast<float>(col);
  const float fy = y - static_cast<float>(row);
  const auto surface = [&](int u, int v) {
    const float rho = value(u, v);
    return std::abs(rho - nearest) <= 2 * kSameSurface * nearest ? rho : nearest;
  };
  return (1 - fy) * ((1 - fx) * surface(col, row) + fx * surface(col + 1, row)) +
         fy * ((1 - fx) * surface(col, row + 1) + fx * surface(col + 1, row + 1));
}

}  // namespace

float HeightMap::RatioAt(double x_map, double y_map) const {
  return Interpolate(static_cast<float>((x_map - grid_.min_x) / grid_.resolution - 0.5),
                     static_cast<float>((grid_.max_y - y_map) / grid_.resolution - 0.5),
                     [this](int col, int row) { return At(col, row); });
}

cv::Mat HeightMap::RatiosOver(const cv::Rect& window, const store::MosaicGrid& mosaic) const {
  if (empty()) return {};
  const double scale = mosaic.resolution / grid_.resolution;
  const double x = (mosaic.min_x - grid_.min_x) / grid_.resolution + 0.5 * scale - 0.5;
  const double y = (grid_.max_y - mosaic.max_y) / grid_.resolution + 0.5 * scale - 0.5;
  const cv::Point first(cvFloor(x + window.x * scale) - 1, cvFloor(y + window.y * scale) - 1);
  const cv::Point last(cvCeil(x + window.br().x * scale) + 1,
                       cvCeil(y + window.br().y * scale) + 1);
  const cv::Mat raster = Ratios({first, last + cv::Point(1, 1)});
  if (cv::countNonZero(raster) == 0) return {};
  const auto value = [&](int col, int row) {
    return raster.ptr<float>(row - first.y)[col - first.x];
  };
  cv::Mat ratios(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    const auto v = static_cast<float>(y + (window.y + row) * scale);
    auto* values = ratios.ptr<float>(row);
    for (int col = 0; col < window.width; ++col) {
      const float rho = Interpolate(static_cast<float>(x + (window.x + col) * scale), v, value);
      values[col] = rho > 0 ? rho : 1;
    }
  }
  return ratios;
}

bool HeightMap::Sees(const ViewPlacement& view, const cv::Point2d& p_map, float rho) const {
  // At the ratio r the ray is above `foot` + rho / r * (p_map - foot), foot: below the camera.
  const float nearest = range_[1];
  if (empty() || rho * (1 + kNearer) >= nearest) return true;
  const cv::Point2d foot = view.Foot();
  const cv::Point2d way = p_map - foot;
  const double last = rho / nearest;  // part of the way
  const double cells = cv::norm(way) * (1 - last) / grid_.resolution;
  const int steps = cvCeil(cells);
  for (int i = 1; i <= steps; ++i) {
    const double part = 1 - (1 - last) * i / steps;
    const cv::Point2d at = foot + part * way;
    const float surface = At(cvFloor((at.x - grid_.min_x) / grid_.resolution),
                             cvFloor((grid_.max_y - at.y) / grid_.resolution));
    if (surface * part > rho * (1 + kNearer)) return false;
  }
  return true;
}

}  // namespace ceilmap::mosaic
