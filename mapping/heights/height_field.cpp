#include "mapping/heights/height_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ceilmap::heights {
namespace {

// A cell lies off the reference plane when it differs by more than this, and by three standard
// deviations.
constexpr double kOffPlane = 0.02;
// Half width of a surface in rho. A corrugated deck with skylights spans about 0.02.
constexpr double kSurface = 0.025;
// Part of the measured cells that a reference plane has at least.
constexpr double kLargeArea = 0.07;
constexpr double kFar = 0.5;  // range of rho in which the reference plane is searched
constexpr double kNear = 3.0;
constexpr double kBin = 0.005;

double Weight(const HeightCell& cell) {
  return cell.sigma < kMeasuredSigma ? 1.0 : 0.0;
}

/// Weighted mean within the surface around `middle`, iterated.
double MeanNear(const std::vector<HeightCell>& cells, double middle) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0;
    double total = 0;
    for (const HeightCell& cell : cells) {
      if (Weight(cell) == 0 || std::abs(cell.rho - middle) > kSurface * middle) continue;
      const double w = 1 / (1e-4 + static_cast<double>(cell.sigma) * cell.sigma);
      sum += w * cell.rho;
      total += w;
    }
    if (total == 0) break;
    middle = sum / total;
  }
  return middle;
}

}  // namespace

Eigen::Vector2d HeightField::Centre(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(grid.width);
  return first_px + step_px.cwiseProduct(Eigen::Vector2d(static_cast<double>(cell % columns),
                                                         static_cast<double>(cell / columns)));
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
  int off = 0;
  for (const HeightCell& cell : cells) {
    if (Weight(cell) == 0) continue;
    ++measured;
    off += std::abs(cell.rho - 1) > std::max(kOffPlane, 3.0 * cell.sigma) ? 1 : 0;
  }
  return measured > 0 ? static_cast<double>(off) / measured : 0;
}

void HeightField::Scale(double factor) {
  for (HeightCell& cell : cells) {
    if (cell.sigma >= kUnknown.sigma) continue;
    cell.rho = static_cast<float>(factor * cell.rho);
    cell.sigma = static_cast<float>(factor * cell.sigma);
  }
}

std::optional<double> FindReference(const std::vector<HeightCell>& cells) {
  constexpr auto kBins = static_cast<std::size_t>((kNear - kFar) / kBin);
  std::array<double, kBins> mass{};
  double total = 0;
  for (const HeightCell& cell : cells) {
    if (Weight(cell) == 0) continue;
    total += 1;
    const auto bin = static_cast<std::ptrdiff_t>((cell.rho - kFar) / kBin);
    if (bin >= 0 && bin < static_cast<std::ptrdiff_t>(kBins)) {
      mass[static_cast<std::size_t>(bin)] += 1;
    }
  }
  constexpr double kEnough = 20;
  if (total < kEnough) return std::nullopt;
  // The first surface with enough area; its middle is where the window holds most.
  const auto inside = [&](std::size_t bin) {
    const double rho = kFar + kBin * (static_cast<double>(bin) + 0.5);
    const auto half = static_cast<std::size_t>(std::lround(kSurface * rho / kBin));
    double sum = 0;
    for (std::size_t i = bin > half ? bin - half : 0; i <= std::min(kBins - 1, bin + half); ++i) {
      sum += mass[i];
    }
    return sum;
  };
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (inside(bin) < kLargeArea * total) continue;
    std::size_t best = bin;
    const double rho = kFar + kBin * static_cast<double>(bin);
    const auto reach = static_cast<std::size_t>(std::lround(2 * kSurface * rho / kBin));
    for (std::size_t i = bin; i < std::min(kBins, bin + reach); ++i) {
      if (inside(i) > inside(best)) best = i;
    }
    return MeanNear(cells, kFar + kBin * (static_cast<double>(best) + 0.5));
  }
  return std::nullopt;
}

std::optional<double> FindReferenceNear(const std::vector<HeightCell>& cells) {
  int total = 0;
  int near = 0;
  for (const HeightCell& cell : cells) {
    if (Weight(cell) == 0) continue;
    ++total;
    near += std::abs(cell.rho - 1) < kSurface ? 1 : 0;
  }
  constexpr int kEnough = 15;
  if (near < kEnough || near < kLargeArea * total) return std::nullopt;
  return MeanNear(cells, 1);
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
