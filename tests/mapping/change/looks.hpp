#pragma once

#include <opencv2/core.hpp>

#include "mapping/change/change_evidence.hpp"

/// Comparisons of made images with a map, cell by cell.
namespace ceilmap::change::synthetic {

/// The cells of a map, and its mosaic.
inline const cv::Rect kAll{0, 0, 40, 40};
inline const store::MosaicGrid kGrid{-3.1, 7.4, 0.01, 650, 643};

/// What one cell shows.
inline cv::Mat Patch(std::uint64_t seed, double mean = 120, double contrast = 10) {
  cv::Mat patch(kCellPx, kCellPx, CV_32FC1);
  cv::RNG rng(seed);
  rng.fill(patch, cv::RNG::NORMAL, mean, contrast);
  cv::Mat grey;
  patch.convertTo(grey, CV_8U);
  return grey;
}

/// An image of cells that all look as the map shows them.
inline ViewComparison SameView(const cv::Rect& cells) {
  ViewComparison view;
  view.cells = cells;
  view.states = cv::Mat(cells.size(), CV_8UC1, cv::Scalar(static_cast<double>(CellState::kSame)));
  view.differences = cv::Mat(cells.size(), CV_32FC3, cv::Scalar::all(0));
  view.weights = cv::Mat(cells.size(), CV_32FC1, cv::Scalar(0.5));
  view.levelled = cv::Mat(PixelsOf(cells).size(), CV_8UC1, cv::Scalar(120));
  view.noise = 1;
  return view;
}

/// @param cell  of the map, inside the view.
inline void SetCell(ViewComparison& view,
                    const cv::Point& cell,
                    CellState state,
                    const cv::Mat& patch) {
  const cv::Point at = cell - view.cells.tl();
  view.states.at<unsigned char>(at) = static_cast<unsigned char>(state);
  view.differences.at<cv::Vec3f>(at) = {0.1F, 50, 45};
  patch.copyTo(view.levelled(PixelsOf({at.x, at.y, 1, 1})));
}

/// Evidence of `views` images in which the cells of a rectangle have another look, the same in all.
inline void AddChangedViews(ChangeEvidence& evidence,
                            const cv::Rect& shown,
                            const cv::Rect& changed,
                            CellState state,
                            int views) {
  for (int i = 0; i < views; ++i) {
    ViewComparison view = SameView(shown);
    for (int row = changed.y; row < changed.br().y; ++row) {
      for (int col = changed.x; col < changed.br().x; ++col) {
        const auto seed = static_cast<std::uint64_t>(1000 * row + col + 1);
        SetCell(view, {col, row}, state, Patch(seed));
      }
    }
    evidence.Add(view);
  }
}

}  // namespace ceilmap::change::synthetic
