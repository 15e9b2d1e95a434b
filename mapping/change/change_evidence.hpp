#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

#include "mapping/change/view_comparison.hpp"

namespace ceilmap::change {

/// One look of a cell, the weighted mean of the images that agree on it.
struct CellLook {
  CellState state = CellState::kUnseen;  ///< most frequent one that differs
  int views = 0;
  double weight = 0;
  cv::Mat sum;  ///< CV_32FC1 of kCellPx x kCellPx, weighted sum; as bright as the map

  [[nodiscard]] cv::Mat Mean() const;  ///< CV_8UC1
};

/// What all images of a recording tell of a cell.
struct CellEvidence {
  int same = 0;     ///< images in which it is as the map shows it
  int differ = 0;   ///< images in which it differs
  int unclear = 0;  ///< images that show it, but do not tell
  /// Sums over the images in which it is no lamp; for weak textures, which single images do not
  /// tell.
  int measured = 0;
  double log_ratio = 0;
  double log_ratio_squares = 0;
  double signal = 0;
  double other = 0;
  double noise = 0;
  std::vector<CellLook> looks;  ///< how it looked where it was not the same, most frequent first

  [[nodiscard]] int Views() const { return same + differ + unclear; }
  /// Whether it looks otherwise than in the map: kTexture, kBrightness or kLamp where most images
  /// differ from the map, or their mean does, and at least two of them, from different places,
  /// agree with each other at the height of the ceiling; else kSame or kUnclear. A person or a mast
  /// below the ceiling lies elsewhere in each image; a moving one too.
  [[nodiscard]] CellState Verdict() const;
  [[nodiscard]] bool IsChanged() const { return Differs(Verdict()); }
  /// Whether it differs a little, which is a change where a neighbour has changed.
  [[nodiscard]] bool MayHaveChanged() const;
  /// Mean of log(image / map), and its spread.
  [[nodiscard]] double MeanLogRatio() const;
  [[nodiscard]] double LogRatioSpread() const;
  /// Mean of CellDifference::Share.
  [[nodiscard]] double MeanShare() const;

 private:
  [[nodiscard]] CellState VerdictByMeans() const;
};

/// Collects the evidence of all images of a recording. Memory grows with the area seen (about 100
/// bytes a cell) and with the area that is not clearly the same (1 to 3 kB a cell).
class ChangeEvidence {
 public:
  /// @param cells  CellsOf the map.
  explicit ChangeEvidence(const cv::Rect& cells) : cells_(cells) {}

  void Add(const ViewComparison& view);

  /// By row * (columns of the map) + column.
  [[nodiscard]] const std::unordered_map<std::int64_t, CellEvidence>& Cells() const {
    return evidence_;
  }
  [[nodiscard]] std::int64_t Key(const cv::Point& cell) const {
    return static_cast<std::int64_t>(cell.y) * cells_.width + cell.x;
  }
  [[nodiscard]] cv::Point CellOf(std::int64_t key) const {
    return {static_cast<int>(key % cells_.width), static_cast<int>(key / cells_.width)};
  }
  /// Null where no image showed it.
  [[nodiscard]] const CellEvidence* At(const cv::Point& cell) const;
  [[nodiscard]] int Views() const { return views_; }
  /// Whether most lamps of the map were off, or most lamps of the recording are off in the map.
  [[nodiscard]] bool OtherLight() const;

 private:
  void AddLook(const ViewComparison& view, const cv::Point& at, CellEvidence& cell) const;

  cv::Rect cells_;
  std::unordered_map<std::int64_t, CellEvidence> evidence_;
  int views_ = 0;
  std::int64_t lamps_alike_ = 0;
  std::int64_t lamps_differ_ = 0;
};

}  // namespace ceilmap::change
