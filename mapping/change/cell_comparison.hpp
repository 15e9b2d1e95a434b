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

/// Two looks at a cell compared. Their brightness and their textures are compared apart: b is first
/// made as bright as a, so that a shadow or a sun patch does not change the texture.
struct CellDifference {
  double log_ratio = 0;  ///< log(b / a) of the means
  double signal = 0;     ///< sum of both variances, without noise; grey levels squared
  double other = 0;      ///< of the signal, what the two do not have in common

  /// other / signal: 0 the same, 1 nothing in common; 0 where there is no signal.
  [[nodiscard]] double Share() const;
};
/// @param noise  sum of the variances of the noise of both.
CellDifference Compare(const CellSums& sums, double noise);

/// Whether a single image tells whether the texture is another.
/// @param mean  grey level. @param noise  as in Compare.
bool IsTextured(const CellDifference& difference, double mean, double noise);

/// The state of a cell that no lamp lights in the two images. Another texture or brightness that is
/// too weak for one image is kUnclear; the mean over many may tell (CellEvidence).
CellState StateOf(const CellDifference& difference, double mean, double noise);

// Texture: below the first share the looks are the same, above the second one others.
inline constexpr double kSameShare = 0.35;
inline constexpr double kOtherShare = 0.6;

}  // namespace ceilmap::change
