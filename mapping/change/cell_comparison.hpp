#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::change {

/// What one image tells of a cell of the map.
enum class CellState : unsigned char {
  kUnseen,      ///< the image does not show the whole cell
  kUnclear,     ///< shown, but neither the same nor another for sure
  kSame,        ///< as the map shows it
  kTexture,     ///< another texture
  kBrightness,  ///< no texture in either, another brightness
  kLamp,        ///< a lamp is lit in one of the two only
};
/// Whether the cell looks otherwise than the map shows it.
constexpr bool Differs(CellState state) {
  return state == CellState::kTexture || state == CellState::kBrightness ||
         state == CellState::kLamp;
}

/// Sums over the pixels of a cell, of two images a and b of one brightness.
struct CellSums {
  double pixels = 0;
  double a = 0;
  double b = 0;
  double aa = 0;
  double bb = 0;
  double ab = 0;

  [[nodiscard]] double MeanA() const { return a / pixels; }
  [[nodiscard]] double MeanB() const { return b / pixels; }
};
/// @param a, b  CV_32FC1 of one size.
CellSums SumsOver(const cv::Mat& a, const cv::Mat& b);

/// Two looks at a cell compared.
struct CellDifference {
  /// Of the variance that is no noise, what the two do not have in common: 0 the same, 1 nothing in
  /// common.
  double share = 0;
  bool textured = false;  ///< there is more variance than noise and uneven light explain
  double log_ratio = 0;   ///< log(b / a) of the means
};
/// @param noise  sum of the variances of the noise of both.
CellDifference Compare(const CellSums& sums, double noise);

/// The state of a cell that no lamp lights in the two images.
CellState StateOf(const CellDifference& difference);

}  // namespace ceilmap::change
