#include "mapping/heights/height_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/statistics.hpp"

namespace ceilmap::heights {
namespace {

// A cell lies off the reference plane when it differs by more than this, and by three standard
// deviations.
constexpr double kOffPlane = 0.02;
// A corrugated deck with its skylights is a cluster of surfaces; part of rho, to each side. It has
// at least this part of all measured cells.
constexpr double kCluster = 0.025;
constexpr double kLargeArea = 0.07;
// One surface of the cluster; the reference is the farthest whose area is comparable to the
// largest.
constexpr double kSurface = 0.01;
constexpr double kComparable = 0.85;
// The same with very many cells, and how many these are. Their errors let neighbouring surfaces run
// into one another (a deck, the frames of its skylights 1 % nearer): the farthest is found by the
// far flank of all.
constexpr double kFineSurface = 0.004;
constexpr double kFineComparable = 0.75;
constexpr double kManyCells = 5000;
constexpr double kFar = 0.5;  // range of rho in which the reference plane is searched
constexpr double kNear = 3.0;
constexpr double kBin = 0.001;

// Errors of weakly measured cells spread a surface, and its far end would be taken for another one.
constexpr double kAccurate = 0.02;

/// 1 for a cell that is measured accurately, less for others.
double Weight(const HeightCell& cell) {
  if (cell.sigma >= kMeasuredSigma) return 0;
  return std::min(1.0, std::pow(kAccurate / cell.sigma, 2));
}

/// Weights of measured cells in bins of rho.
class Histogram {
 public:
  explicit Histogram(const std::vector<HeightCell>& cells) {
    for (const HeightCell& cell : cells) {
      const double weight = Weight(cell);
      total_ += weight;
      const auto bin = static_cast<std::ptrdiff_t>((cell.rho - kFar) / kBin);
      if (bin >= 0 && bin < kBins) sums_[static_cast<std::size_t>(bin) + 1] += weight;
    }
    for (std::size_t i = 1; i < sums_.size(); ++i) sums_[i] += sums_[i - 1];
  }
  [[nodiscard]] double Total() const { return total_; }
  static double Rho(int bin) { return kFar + kBin * (bin + 0.5); }
  static int Bins() { return kBins; }
  /// A part of rho in bins.
  static int BinsOf(double part, int bin) {
    return static_cast<int>(std::lround(part * Rho(bin) / kBin));
  }
  /// Cells within a part of rho around the middle of a bin.
  [[nodiscard]] double Within(int bin, double part) const {
    const int half = BinsOf(part, bin);
    const int from = std::max(0, bin - half);
    const int to = std::min(kBins, bin + half + 1);
    return sums_[static_cast<std::size_t>(to)] - sums_[static_cast<std::size_t>(from)];
  }

 private:
  static constexpr int kBins = static_cast<int>((kNear - kFar) / kBin);
  std::array<double, kBins + 1> sums_{};
  double total_ = 0;
};

}  // namespace

Eigen::Vector2d HeightField::Centre(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(grid.width);
  const std::size_t column = cell % columns;
  const std::size_t row = cell / columns;
  return first_px + step_px.cwiseProduct(
                        Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row)));
}

std::optional<std::size_t> HeightField::CellAt(const Eigen::Vector2d& x_px) const {
  const Eigen::Vector2d at = (x_px - first_px).cwiseQuotient(step_px);
  const auto column = static_cast<int>(std::lround(at.x()));
  const auto row = static_cast<int>(std::lround(at.y()));
  if (column < 0 || row < 0 || column >= grid.width || row >= grid.height) return std::nullopt;
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) +
         static_cast<std::size_t>(column);
}

HeightCell HeightField::Around(const Eigen::Vector2d& x_px) const {
  const std::optional<std::size_t> middle = CellAt(x_px);
  if (!middle) return kUnknown;
  const int column = static_cast<int>(*middle % static_cast<std::size_t>(grid.width));
  const int row = static_cast<int>(*middle / static_cast<std::size_t>(grid.width));
  HeightCell best = cells[*middle];
  for (int r = std::max(0, row - 1); r <= std::min(grid.height - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(grid.width - 1, column + 1); ++c) {
      const HeightCell& cell =
          cells[static_cast<std::size_t>(r) * static_cast<std::size_t>(grid.width) +
                static_cast<std::size_t>(c)];
      if (cell.sigma < best.sigma) best = cell;
    }
  }
  return best;
}

double HeightField::DepthRatio() const {
  int measured = 0;
  int off = 0;  // nearer ones less farther ones
  for (const HeightCell& cell : cells) {
    if (cell.sigma >= kMeasuredSigma) continue;
    ++measured;
    if (std::abs(cell.rho - 1) > std::max(kOffPlane, 3.0 * cell.sigma))
      off += cell.rho > 1 ? 1 : -1;
  }
  return measured > 0 ? static_cast<double>(std::max(0, off)) / measured : 0;
}

double HeightField::UnevenRatio() const {
  std::vector<double> measured;
  for (const HeightCell& cell : cells) {
    if (cell.sigma < kMeasuredSigma) measured.push_back(cell.rho);
  }
  if (measured.empty()) return 0;
  const double total = static_cast<double>(measured.size());
  const double middle = Median(measured);
  const auto off = std::count_if(cells.begin(), cells.end(), [middle](const HeightCell& cell) {
    return cell.sigma < kMeasuredSigma &&
           std::abs(cell.rho - middle) > std::max(kOffPlane * middle, 3.0 * cell.sigma);
  });
  return static_cast<double>(off) / total;
}

void HeightField::Scale(double factor) {
  for (HeightCell& cell : cells) {
    if (cell.sigma >= kUnknown.sigma) continue;
    cell.rho = static_cast<float>(factor * cell.rho);
    cell.sigma = static_cast<float>(factor * cell.sigma);
  }
}

std::optional<double> FindReference(const std::vector<HeightCell>& cells) {
  const Histogram histogram(cells);
  constexpr double kEnough = 20;
  if (histogram.Total() < kEnough) return std::nullopt;
  int first = 0;
  while (first < Histogram::Bins() &&
         histogram.Within(first, kCluster) < kLargeArea * histogram.Total()) {
    ++first;
  }
  if (first == Histogram::Bins()) return std::nullopt;
  const int end = std::min(Histogram::Bins(), first + Histogram::BinsOf(3 * kCluster, first));
  double most = 0;
  for (int bin = first; bin < end; ++bin) most = std::max(most, histogram.Within(bin, kSurface));
  int surface = first;
  while (histogram.Within(surface, kSurface) < kComparable * most) ++surface;
  double half = kSurface;
  if (histogram.Total() > kManyCells) {
    // Many cells resolve what lies within one surface: the crests of a corrugated deck.
    half = kFineSurface;
    const int from = std::max(0, surface - Histogram::BinsOf(kSurface, surface));
    const int to = std::min(Histogram::Bins(), surface + 2 * Histogram::BinsOf(kSurface, surface));
    most = 0;
    for (int bin = from; bin < to; ++bin) most = std::max(most, histogram.Within(bin, half));
    surface = from;
    while (histogram.Within(surface, half) < kFineComparable * most) ++surface;
    const int last = std::min(Histogram::Bins() - 1, surface + Histogram::BinsOf(half, surface));
    while (surface < last &&
           histogram.Within(surface + 1, half) > histogram.Within(surface, half)) {
      ++surface;
    }
  }
  const double middle = Histogram::Rho(surface);
  double sum = 0;
  double count = 0;
  for (const HeightCell& cell : cells) {
    if (std::abs(cell.rho - middle) > half * middle) continue;
    sum += Weight(cell) * cell.rho;
    count += Weight(cell);
  }
  return count > 0 ? sum / count : middle;
}

void PullToReference(HeightField& field) {
  // Standard deviations: of the scale from one keyframe to the next, and of the plane's ratio as
  // one image shows it.
  constexpr double kDrift = 0.003;
  constexpr double kSeen = 0.015;
  constexpr double kSigmas = 4;
  const double before = std::hypot(field.scale_sigma, kDrift);
  field.scale_sigma = before;
  const std::optional<double> plane = FindReference(field.cells);
  if (!plane || std::abs(*plane - 1) > kSigmas * std::hypot(before, kSeen)) return;
  const double gain = before * before / (before * before + kSeen * kSeen);
  field.Scale(1 / (1 + gain * (*plane - 1)));
  field.scale_sigma = std::sqrt(1 - gain) * before;
}

HeightField Predict(const HeightField& from,
                    const HeightField& blank,
                    const std::function<Eigen::Vector2d(const Eigen::Vector2d&, double)>& moved) {
  HeightField to = blank;
  to.scale_sigma = from.scale_sigma;
  to.cells.assign(static_cast<std::size_t>(to.grid.area()), kUnknown);
  // A point seldom falls on the centre of a cell, whose block then shows other things too.
  constexpr float kOffCentre = 0.02F;
  for (std::size_t i = 0; i < from.cells.size(); ++i) {
    const HeightCell& cell = from.cells[i];
    if (cell.sigma >= kMeasuredSigma) continue;
    const Eigen::Vector2d x = moved(from.Centre(i), cell.rho);
    const std::optional<std::size_t> hit = to.CellAt(x);
    if (!hit) continue;
    const double off = (x - to.Centre(*hit)).cwiseQuotient(to.step_px).norm();
    const HeightCell seen{cell.rho,
                          std::hypot(cell.sigma, kOffCentre * static_cast<float>(0.5 + off))};
    if (seen.sigma < to.cells[*hit].sigma) to.cells[*hit] = seen;
  }
  return to;
}

}  // namespace ceilmap::heights
