#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ceilmap::calib {

/// Displacements of the sources of a RemapTable, in pixels of the raw image: at the nodes of a
/// grid, bilinear between them.
struct SourceShift {
  static constexpr int kSpacingPx = 16;  ///< node (i, j) is pixel (16 j, 16 i) of the result
  cv::Mat2f nodes;                       ///< of NodesFor rows and columns
  static cv::Size NodesFor(cv::Size result) {
    return {(result.width - 1) / kSpacingPx + 2, (result.height - 1) / kSpacingPx + 2};
  }
};

/// A precomputed warp of 8-bit images of one size, grey or colour, bilinear with fractions of
/// 1/2048 px. Sources at whole pixels are copied.
///
/// cv::remap rounds every map, float ones too, to 1/32 px: this causes a shift of up to 0.016 px in
/// a pattern fixed in the image, which acts as a bias of the measured motion. This table takes
/// about twice the time (calib/README.md) and has no such pattern.
class RemapTable {
 public:
  /// Position in the raw image of a pixel of the result, in pixels; nothing: the pixel has no
  /// source.
  using Source = std::function<std::optional<cv::Point2d>(int u, int v)>;

  RemapTable() = default;
  /// @param raw size of raw images, at least 2 x 2 and less than 32768. @param result size of
  ///   results. Sources outside the raw image count as no source.
  RemapTable(cv::Size raw, cv::Size result, const Source& source);
  /// The same for raw images and results of one size.
  RemapTable(cv::Size size, const Source& source) : RemapTable(size, size, source) {}

  [[nodiscard]] bool empty() const { return x_.empty(); }
  /// CV_8UC1, 255 where the result has content, 0 where it has no source.
  [[nodiscard]] cv::Mat Mask() const;
  /// @param raw  CV_8UC1 or CV_8UC3 of the table's size. @param result  of the same type, allocated
  ///   unless it fits; must not share memory with `raw`; 0 where there is no content. Thread-safe.
  void Apply(const cv::Mat& raw, cv::Mat& result) const;
  /// The same with displaced sources. Displaced sources outside the raw image are moved to its
  /// border: content stays where Mask() says. @param raw  CV_8UC1. Takes 2.5 times as long as
  /// without.
  void Apply(const cv::Mat& raw, const SourceShift& shift, cv::Mat& result) const;

 private:
  void FillGrey(const cv::Mat& raw, const SourceShift* shift, cv::Mat& result) const;
  void FillColour(const cv::Mat& raw, cv::Mat& result) const;

  cv::Size raw_size_;
  cv::Size size_;  // of results
  // Sources row by row, in 1/2048 px; x is -1 where there is none. Two arrays, so that loops over
  // them are vectorized.
  std::vector<std::int32_t> x_;
  std::vector<std::int32_t> y_;
};

}  // namespace ceilmap::calib
