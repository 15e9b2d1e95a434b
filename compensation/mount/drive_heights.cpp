#include "compensation/mount/drive_heights.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "mapping/heights/height_field.hpp"

namespace ceilmap::mount {
namespace {

std::vector<heights::HeightCell> CellsOf(const std::vector<calibration::PointHeight>& heights) {
  std::vector<heights::HeightCell> cells;
  cells.reserve(heights.size());
  for (const calibration::PointHeight& point : heights) {
    cells.push_back({static_cast<float>(point.rho), static_cast<float>(point.sigma)});
  }
  return cells;
}

// What is seen beyond a ceiling are wrong matches, which are few compared with the ceiling itself.
bool IsFarthest(double plane, const std::vector<heights::HeightCell>& cells) {
  constexpr double kSurface = 0.03;
  constexpr double kMaxBeyond = 0.5;
  constexpr double kAccurate = 0.02;
  double beyond = 0;
  double surface = 0;
  for (const heights::HeightCell& cell : cells) {
    if (cell.sigma > kAccurate) continue;
    const double off = cell.rho / plane - 1;
    if (off < -kSurface) ++beyond;
    if (std::abs(off) <= kSurface) ++surface;
  }
  return beyond < kMaxBeyond * surface;
}

}  // namespace

std::optional<Measured> ReferencePlane(const std::vector<calibration::PointHeight>& heights,
                                       std::size_t views) {
  constexpr std::size_t kQuarters = 4;
  constexpr double kMinSigma = 0.002;
  const std::vector<heights::HeightCell> cells = CellsOf(heights);
  const std::optional<double> plane = heights::FindReference(cells);
  if (!plane || !IsFarthest(*plane, cells)) return std::nullopt;
  std::array<std::vector<calibration::PointHeight>, kQuarters> quarters;
  for (const calibration::PointHeight& point : heights) {
    quarters[static_cast<std::size_t>(point.view) * kQuarters / views].push_back(point);
  }
  double squares = 0;
  std::size_t count = 0;
  for (const auto& quarter : quarters) {
    const std::optional<double> of_quarter = heights::FindReference(CellsOf(quarter));
    if (!of_quarter) continue;
    squares += (*of_quarter - *plane) * (*of_quarter - *plane);
    ++count;
  }
  if (2 * count <= kQuarters) return std::nullopt;
  // The quarters are independent: the whole is their mean.
  const double spread = std::sqrt(squares / static_cast<double>(count * (count - 1)));
  return Measured{*plane, std::hypot(kMinSigma * *plane, spread)};
}

void TakeAsPlane(double rho, calibration::DriveSolution& solution) {
  for (Pose2& camera : solution.cameras) {
    camera.x *= rho;
    camera.y *= rho;
  }
  for (calibration::PointHeight& point : solution.heights) {
    point.rho /= rho;
    point.sigma /= rho;
  }
}

}  // namespace ceilmap::mount
