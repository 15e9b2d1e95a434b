#include "mapping/change/keyframe_cover.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/base/field_check.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::change {
namespace {

constexpr int kCellsAcross = 24;

std::int64_t CoverCell(std::int64_t col, std::int64_t row) {
  constexpr std::int64_t kRow = std::int64_t{1} << 32;
  return row * kRow + col;
}

/// The cells whose centres an image shows. @param content  CV_8UC1, 0 where it has none; may be
/// empty.
std::vector<std::int64_t> CellsShown(const mosaic::ViewPlacement& view,
                                     cv::Size size,
                                     const cv::Mat& content,
                                     double cell) {
  const cv::Rect2d box = view.Bounds();
  std::vector<std::int64_t> cells;
  const auto last_row = static_cast<std::int64_t>(std::floor(box.br().y / cell));
  const auto last_col = static_cast<std::int64_t>(std::floor(box.br().x / cell));
  for (auto row = static_cast<std::int64_t>(std::floor(box.y / cell)); row <= last_row; ++row) {
    for (auto col = static_cast<std::int64_t>(std::floor(box.x / cell)); col <= last_col; ++col) {
      const cv::Point2d at = view.ToPixel((static_cast<double>(col) + 0.5) * cell,
                                          (static_cast<double>(row) + 0.5) * cell);
      const cv::Point pixel(cvRound(at.x), cvRound(at.y));
      if (!cv::Rect({}, size).contains(pixel)) continue;
      if (!content.empty() && content.ptr<unsigned char>(pixel.y)[pixel.x] == 0) continue;
      cells.push_back(CoverCell(col, row));
    }
  }
  return cells;
}

}  // namespace

void KeyframeCoverOptions::Validate() const {
  const FieldCheck require("keyframe cover");
  require(min_cover >= 1, "min_cover", min_cover, ">= 1");
  require(min_overlap >= 0 && min_overlap <= 1, "min_overlap", min_overlap, "in [0, 1]");
}

KeyframeCover::KeyframeCover(const std::vector<graph::Keyframe>& keyframes,
                             const store::MapMetadata& metadata,
                             const graph::ImageLoader& load,
                             const KeyframeCoverOptions& options)
    : options_(options), retired_(keyframes.size(), false) {
  options.Validate();
  const cv::Size size = metadata.view_size;
  const double cell = std::min(size.width, size.height) * metadata.view_units_per_px / kCellsAcross;
  const std::vector<mosaic::ViewPlacement> views = mosaic::PlaceViews(keyframes, metadata);
  cells_.reserve(keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const bool level = keyframes[i].pose.tilt.IsLevel();
    cells_.push_back(
        CellsShown(views[i], size, level ? metadata.view_mask : load(keyframes[i].id), cell));
    for (const std::int64_t at : cells_.back()) shown_by_[at].push_back(i);
  }
  FindOverlaps();
}

void KeyframeCover::FindOverlaps() {
  kept_witnesses_.resize(cells_.size(), 0);
  witness_of_.resize(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    std::map<std::size_t, std::size_t> shared;
    for (const std::int64_t cell : cells_[i]) {
      for (const std::size_t other : shown_by_.at(cell)) ++shared[other];
    }
    const double needed = options_.min_overlap * static_cast<double>(cells_[i].size());
    for (const auto& [other, cells] : shared) {
      if (other == i || static_cast<double>(cells) < needed) continue;
      ++kept_witnesses_[i];
      witness_of_[other].push_back(i);
    }
  }
}

bool KeyframeCover::IsRedundant(std::size_t keyframe) const {
  if (retired_[keyframe] || kept_witnesses_[keyframe] == 0) return false;
  const bool covered =
      std::all_of(cells_[keyframe].begin(), cells_[keyframe].end(), [this](std::int64_t cell) {
        return static_cast<int>(shown_by_.at(cell).size()) > options_.min_cover;
      });
  return covered &&
         std::none_of(
             witness_of_[keyframe].begin(), witness_of_[keyframe].end(), [this](std::size_t other) {
               return retired_[other] && kept_witnesses_[other] == 1;
             });
}

void KeyframeCover::Retire(std::size_t keyframe) {
  retired_[keyframe] = true;
  for (const std::int64_t cell : cells_[keyframe]) std::erase(shown_by_.at(cell), keyframe);
  for (const std::size_t other : witness_of_[keyframe]) --kept_witnesses_[other];
}

}  // namespace ceilmap::change
