#include "localization/compass/colour/colour_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

constexpr int kMaxPerSide = 100;  // cells

void Require(bool holds, const std::string& what) {
  if (!holds) throw InputError(what);
}

void CheckBin(const AngleBin& bin, Eigen::Index size, bool with_variance) {
  if (bin.empty()) return;
  Require(bin.transitions.size() == size && bin.transitions.allFinite() &&
              bin.transitions.minCoeff() >= 0 && bin.transitions.maxCoeff() <= 1.001F,
          fmt::format("a bin has transitions that cannot be, must be {} frequencies", size));
  Require(!with_variance || (bin.variance.size() == size && bin.variance.allFinite() &&
                             bin.variance.minCoeff() >= 0),
          "a bin has variances that cannot be");
  Require(bin.certainty > 0 && std::isfinite(bin.certainty) && std::isfinite(bin.stamp_s) &&
              bin.place.allFinite(),
          "a bin has a certainty, stamp or place that cannot be");
}

/// Mean of two bins, weighted by their certainty at the time of the later one; kVictoria2013: that
/// of the greater certainty.
void MergeBin(const AngleBin& other, ModelKind kind, double fading_s, AngleBin& bin) {
  if (other.empty()) return;
  if (bin.empty()) {
    bin = other;
    return;
  }
  const double now_s = std::max(bin.stamp_s, other.stamp_s);
  const double mine = FadedCertainty(bin, now_s, fading_s);
  const double theirs = FadedCertainty(other, now_s, fading_s);
  const auto fraction = static_cast<float>(theirs / (mine + theirs));
  if (kind == ModelKind::kVictoria2013) {  // one observation for each bin
    if (theirs > mine) bin = other;
    return;
  }
  bin.transitions += fraction * (other.transitions - bin.transitions);
  if (bin.variance.size() > 0) bin.variance += fraction * (other.variance - bin.variance);
  bin.place += fraction * (other.place - bin.place);
  bin.certainty = mine + theirs;
  bin.stamp_s = now_s;
}

}  // namespace

void CheckBinCount(int cells, int bins) {
  Require(std::int64_t{cells} * bins <= kMaxBins,
          fmt::format("{} cells of {} angle bins, must be at most {} bins in all; take fewer cells",
                      cells,
                      bins,
                      kMaxBins));
}

const char* ToString(ModelKind kind) {
  switch (kind) {
    case ModelKind::kSturm:
      return "sturm";
    case ModelKind::kVictoria2013:
      return "victoria-2013";
    case ModelKind::kVictoria:
      break;
  }
  return "victoria";
}

void GridGeometry::Validate() const {
  Require(std::isfinite(min_x_m) && std::isfinite(min_y_m) && width_m > 0 && height_m > 0 &&
              std::isfinite(width_m) && std::isfinite(height_m),
          fmt::format("a grid of {} x {} m, must be > 0", width_m, height_m));
  Require(columns >= 1 && rows >= 1 && columns <= kMaxPerSide && rows <= kMaxPerSide,
          fmt::format("a grid of {} x {} cells, must be 1 to {} in each direction",
                      columns,
                      rows,
                      kMaxPerSide));
}

int GridGeometry::CellOf(const Eigen::Vector2d& place) const {
  const auto index = [](double at, double size, int count) {
    return static_cast<int>(std::clamp(std::floor(at / size * count), 0.0, count - 1.0));
  };
  return index(place.y() - min_y_m, height_m, rows) * columns +
         index(place.x() - min_x_m, width_m, columns);
}

bool Cell::empty() const {
  return std::all_of(bins.begin(), bins.end(), [](const AngleBin& bin) { return bin.empty(); });
}

double Cell::Filled() const {
  const auto filled =
      std::count_if(bins.begin(), bins.end(), [](const AngleBin& bin) { return !bin.empty(); });
  return bins.empty() ? 0 : static_cast<double>(filled) / static_cast<double>(bins.size());
}

Eigen::Vector2d Cell::Place() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const AngleBin& bin : bins) {
    if (bin.empty()) continue;
    sum += bin.place;
    ++count;
  }
  return count > 0 ? Eigen::Vector2d(sum / count) : sum;
}

void ColourModel::Validate() const {
  Require(classes.size() >= 2 && classes.size() <= kMaxClasses,
          fmt::format("{} colour classes, must be 2 to {}", classes.size(), kMaxClasses));
  Require(bins >= 36 && bins <= 720, fmt::format("{} angle bins, must be 36 to 720", bins));
  grid.Validate();
  CheckBinCount(static_cast<int>(cells.size()), bins);
  const bool sturm = kind == ModelKind::kSturm;
  const std::size_t expected = sturm ? 1 : static_cast<std::size_t>(grid.Cells());
  Require(cells.size() == expected,
          fmt::format("{} cells, must be {} by the grid", cells.size(), expected));
  Require(depth_m > 0 && std::isfinite(depth_m), fmt::format("depth {} m, must be > 0", depth_m));
  Require(fading_s > 0 && std::isfinite(fading_s),
          fmt::format("fading {} s, must be > 0", fading_s));
  Require(frames >= 0, "the number of frames is negative");
  const auto size = static_cast<Eigen::Index>(classes.size() * classes.size());
  for (const Cell& cell : cells) {
    Require(cell.bins.size() == static_cast<std::size_t>(bins),
            fmt::format("a cell has {} bins, must have {}", cell.bins.size(), bins));
    for (const AngleBin& bin : cell.bins) CheckBin(bin, size, sturm);
  }
}

int BinOf(double angle_rad, int bins) {
  const double turns = angle_rad / (2 * std::numbers::pi);
  return static_cast<int>((turns - std::floor(turns)) * bins) % bins;
}

double FadedCertainty(const AngleBin& bin, double stamp_s, double fading_s) {
  return bin.certainty * std::exp(-std::max(0.0, stamp_s - bin.stamp_s) / fading_s);
}

void Merge(const ColourModel& other, ColourModel& model) {
  const auto same = [](const ColourClass& a, const ColourClass& b) {
    return a.mean == b.mean && a.covariance == b.covariance;
  };
  Require(model.kind == other.kind,
          fmt::format(
              "one is of method {}, the other of {}", ToString(model.kind), ToString(other.kind)));
  Require(model.classes.size() == other.classes.size() &&
              std::equal(model.classes.begin(), model.classes.end(), other.classes.begin(), same),
          "their colour classes differ: only models that began as copies of one can be merged "
          "('compass update' keeps classes)");
  const GridGeometry& a = model.grid;
  const GridGeometry& b = other.grid;
  Require(model.bins == other.bins && a.min_x_m == b.min_x_m && a.min_y_m == b.min_y_m &&
              a.width_m == b.width_m && a.height_m == b.height_m && a.columns == b.columns &&
              a.rows == b.rows,
          "their grids or angle bins differ");
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    for (std::size_t i = 0; i < model.cells[c].bins.size(); ++i) {
      MergeBin(other.cells[c].bins[i], model.kind, model.fading_s, model.cells[c].bins[i]);
    }
  }
  const double frames = static_cast<double>(model.frames + other.frames);
  if (frames > 0) {
    const double fraction = static_cast<double>(other.frames) / frames;
    model.depth_m += fraction * (other.depth_m - model.depth_m);
  }
  model.frames += other.frames;
  model.provenance += other.provenance;
}

}  // namespace ceilmap::colour
