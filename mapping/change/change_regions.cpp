#include "mapping/change/change_regions.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "mapping/mosaic/outlines.hpp"

namespace ceilmap::change {
namespace {

using Kind = store::Change::Kind;

/// The changed cells of a recording as masks over the box of those cells.
struct Masks {
  cv::Rect box;
  cv::Mat texture;
  cv::Mat brightness;
  cv::Mat lamp;
  cv::Mat weak;  ///< differ a little
};

Masks MasksOf(const ChangeEvidence& evidence) {
  Masks masks;
  for (const auto& [key, cell] : evidence.Cells()) {
    if (cell.IsChanged()) masks.box |= cv::Rect(evidence.CellOf(key), cv::Size(1, 1));
  }
  if (masks.box.empty()) return masks;
  masks.box = cv::Rect(masks.box.tl() - cv::Point(1, 1), masks.box.br() + cv::Point(1, 1));
  for (cv::Mat* mask : {&masks.texture, &masks.brightness, &masks.lamp, &masks.weak}) {
    *mask = cv::Mat::zeros(masks.box.size(), CV_8UC1);
  }
  for (const auto& [key, cell] : evidence.Cells()) {
    const CellState state = cell.Verdict();
    const cv::Point at = evidence.CellOf(key) - masks.box.tl();
    if (!cv::Rect({}, masks.box.size()).contains(at)) continue;
    if (!Differs(state) && !cell.MayHaveChanged()) continue;
    cv::Mat& mask = state == CellState::kTexture      ? masks.texture
                    : state == CellState::kBrightness ? masks.brightness
                    : state == CellState::kLamp       ? masks.lamp
                                                      : masks.weak;
    mask.ptr<unsigned char>(at.y)[at.x] = 255;
  }
  // Cells at the border of a lamp show an edge, or glare, in one of the two looks.
  cv::Mat around;
  cv::dilate(masks.lamp, around, cv::Mat());
  for (int row = 0; row < around.rows; ++row) {
    for (int col = 0; col < around.cols; ++col) {
      if (around.ptr<unsigned char>(row)[col] == 0) continue;
      const CellEvidence* cell = evidence.At(masks.box.tl() + cv::Point(col, row));
      constexpr int kMinViews = 2;
      const bool other = cell != nullptr && !cell->looks.empty() &&
                         cell->looks[0].views >= kMinViews && cell->same <= cell->looks[0].views;
      if (other) masks.lamp.ptr<unsigned char>(row)[col] = 255;
    }
  }
  for (cv::Mat* mask : {&masks.texture, &masks.brightness, &masks.weak}) mask->setTo(0, around);
  return masks;
}

/// Whether a mask contains a square of 2 x 2 cells.
bool IsWide(const cv::Mat& mask) {
  cv::Mat inner;
  cv::erode(mask, inner, cv::Mat::ones(2, 2, CV_8UC1), {0, 0}, 1, cv::BORDER_CONSTANT, 0);
  return cv::countNonZero(inner) > 0;
}

/// A component of changed cells, and what is known of it.
class RegionBuilder {
 public:
  RegionBuilder(const ChangeEvidence& evidence, const cv::Rect& box)
      : evidence_(evidence), box_(box) {}

  [[nodiscard]] ChangedRegion Build(const cv::Mat& component, Kind kind) const {
    ChangedRegion region;
    region.kind = kind;
    double differences = 0;
    int differing = 0;
    ForEach(component, box_.tl(), [&](const cv::Point& cell) {
      region.cells.push_back(cell);
      const CellEvidence* known = evidence_.At(cell);
      if (known == nullptr || !known->IsChanged()) return;
      region.frames = std::max<std::int64_t>(region.frames, known->looks[0].views);
      differences += known->MeanShare();
      ++differing;
    });
    region.difference = differing > 0 ? differences / differing : 0;
    return region;
  }

 private:
  template <typename Visit>
  static void ForEach(const cv::Mat& mask, const cv::Point& first, const Visit& visit) {
    for (int row = 0; row < mask.rows; ++row) {
      for (int col = 0; col < mask.cols; ++col) {
        if (mask.ptr<unsigned char>(row)[col] != 0) visit(first + cv::Point(col, row));
      }
    }
  }

  const ChangeEvidence& evidence_;
  cv::Rect box_;
};

template <typename Visit>
void ForEachComponent(const cv::Mat& mask, const Visit& visit) {
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centroids);
  for (int i = 1; i < count; ++i) visit(cv::Mat(labels == i));
}

/// Changed cells with the weak ones that are connected with them, without gaps of one cell.
cv::Mat Grown(const cv::Mat& changed, const cv::Mat& weak) {
  cv::Mat grown = cv::Mat::zeros(changed.size(), CV_8UC1);
  ForEachComponent(changed | weak, [&](const cv::Mat& component) {
    constexpr int kMinChanged = 2;
    if (cv::countNonZero(component & changed) >= kMinChanged) grown |= component;
  });
  cv::Mat padded;
  cv::copyMakeBorder(grown, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::morphologyEx(padded, padded, cv::MORPH_CLOSE, cv::Mat());
  return padded(cv::Rect({1, 1}, changed.size())).clone();
}

}  // namespace

std::vector<ChangedRegion> FindChanges(const ChangeEvidence& evidence) {
  std::vector<ChangedRegion> regions;
  const Masks masks = MasksOf(evidence);
  if (masks.box.empty()) return regions;
  const RegionBuilder builder(evidence, masks.box);
  const bool other_light = evidence.OtherLight();
  ForEachComponent(masks.lamp, [&](const cv::Mat& component) {
    if (!IsWide(component)) return;
    regions.push_back(builder.Build(component, other_light ? Kind::kLight : Kind::kLamp));
  });
  const cv::Mat changed = masks.texture | masks.brightness;
  const cv::Mat joined = Grown(changed, masks.weak) & ~masks.lamp;
  ForEachComponent(joined, [&](const cv::Mat& component) {
    const cv::Mat seen = component & changed;
    if (!IsWide(component)) return;
    const int cells = cv::countNonZero(seen);
    const int textured = cv::countNonZero(seen & masks.texture);
    constexpr double kMinTextured = 0.25;
    const bool surface = textured >= kMinTextured * cells;
    if (!surface && other_light) return;
    regions.push_back(builder.Build(component, surface ? Kind::kSurface : Kind::kBrightness));
  });
  return regions;
}

std::vector<cv::Point> FreshCells(const ChangeEvidence& evidence,
                                  const std::vector<cv::Point>& cells) {
  std::set<std::pair<int, int>> fresh;  // row, column
  for (const cv::Point& cell : cells) {
    for (int row = cell.y - 1; row <= cell.y + 1; ++row) {
      for (int col = cell.x - 1; col <= cell.x + 1; ++col) {
        const CellEvidence* known = evidence.At({col, row});
        if (known == nullptr || known->looks.empty()) continue;
        constexpr int kMinViews = 2;
        const CellLook& look = known->looks[0];
        if (look.views >= kMinViews && look.views >= known->same) fresh.emplace(row, col);
      }
    }
  }
  std::vector<cv::Point> list;
  list.reserve(fresh.size());
  for (const auto& [row, col] : fresh) list.emplace_back(col, row);
  return list;
}

store::Polygons OutlineOf(const std::vector<cv::Point>& cells, const store::MosaicGrid& grid) {
  if (cells.empty()) return {};
  const cv::Rect box = cv::boundingRect(cells);
  constexpr int kScale = 4;  // pixels a cell: outlines pass an eighth of a cell inside its border
  cv::Mat mask = cv::Mat::zeros(kScale * box.height, kScale * box.width, CV_8UC1);
  for (const cv::Point& cell : cells) {
    mask(cv::Rect(kScale * (cell - box.tl()), cv::Size(kScale, kScale))).setTo(255);
  }
  store::MosaicGrid fine = grid;
  fine.min_x += box.x * kCellPx * grid.resolution;
  fine.max_y -= box.y * kCellPx * grid.resolution;
  fine.resolution = grid.resolution * kCellPx / kScale;
  return mosaic::OutlinesOf(mask, fine);
}

std::vector<cv::Point> CellsIn(const store::Polygons& polygons, const store::MosaicGrid& grid) {
  const double side = kCellPx * grid.resolution;
  const auto to_cell = [&](const cv::Point2d& p) {
    return cv::Point2d((p.x - grid.min_x) / side, (grid.max_y - p.y) / side);
  };
  cv::Rect2d bounds;
  for (const auto& rings : polygons) {
    for (const cv::Point2d& p : rings.front()) {
      const cv::Rect2d at(to_cell(p), cv::Size2d(1e-9, 1e-9));
      bounds = bounds.empty() ? at : bounds | at;
    }
  }
  const cv::Rect2d all(CellsOf(grid));
  bounds &= all;
  if (bounds.empty()) return {};
  const cv::Rect box(cv::Point(cvFloor(bounds.x), cvFloor(bounds.y)),
                     cv::Point(cvCeil(bounds.br().x), cvCeil(bounds.br().y)));
  constexpr int kShift = 8;  // of fixed-point coordinates
  cv::Mat mask = cv::Mat::zeros(box.size(), CV_8UC1);
  for (const auto& rings : polygons) {
    std::vector<std::vector<cv::Point>> points;
    for (const auto& ring : rings) {
      points.emplace_back();
      for (const cv::Point2d& p : ring) {
        const cv::Point2d at = to_cell(p) - cv::Point2d(box.tl()) - cv::Point2d(0.5, 0.5);
        const auto fixed = [](double cells) {
          constexpr double kFarthest = 1e6;
          return cvRound(std::clamp(cells, -kFarthest, kFarthest) * (1 << kShift));
        };
        points.back().emplace_back(fixed(at.x), fixed(at.y));
      }
    }
    cv::fillPoly(mask, points, cv::Scalar(255), cv::LINE_8, kShift);
  }
  std::vector<cv::Point> cells;
  cv::findNonZero(mask, cells);
  for (cv::Point& cell : cells) cell += box.tl();
  return cells;
}

}  // namespace ceilmap::change
