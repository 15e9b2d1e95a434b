#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::colour {

/// Method by which colours are clustered into classes.
enum class Clustering {
  kOfMethod,  ///< that of the model's paper: kMixture for ModelKind::kSturm, otherwise kMeans
  kMeans,     ///< k-means in YUV (ViCTORiA)
  kMixture,   ///< EM on a mixture of Gaussians in YUV (Sturm & Visser)
};

struct ColourClassParams {
  Clustering clustering = Clustering::kOfMethod;  ///< Learn: k-means, it knows no model
  int classes = 8;                                ///< 2 .. kMaxClasses
  std::uint64_t seed = 1;                         ///< equal samples and seeds give equal classes

  void Validate() const;  ///< throws InputError naming field, value and range
};

inline constexpr int kMaxClasses = 32;
/// Label of a colour that is not similar to any class: no such colour was learned.
inline constexpr std::uint8_t kNoClass = 255;

/// One colour class.
struct ColourClass {
  std::array<float, 3> mean{};  ///< Y, U, V of cv::COLOR_BGR2YUV, [0, 255]
  /// k-means: the identity matrix. Mixture: covariance, row by row.
  std::array<float, 9> covariance{1, 0, 0, 0, 1, 0, 0, 0, 1};
  float weight = 1;  ///< fraction of the samples, (0, 1]
};

/// Determines the class of a colour from a table over the colours in steps of 4 grey levels, so
/// that a pixel costs one table look-up.
class ColourClasses {
 public:
  /// @param classes  2 .. kMaxClasses; in order of rising brightness when made by Learn, in any
  ///   order otherwise.
  /// @throws InputError when there are too few or too many, or on invalid numbers.
  explicit ColourClasses(std::vector<ColourClass> classes);

  /// @param bgr  CV_8UC3, samples in any shape.
  /// @throws InputError when they contain fewer different colours than the requested number of
  ///   classes (a grey or dark video).
  static ColourClasses Learn(const cv::Mat& bgr, const ColourClassParams& params = {});

  [[nodiscard]] int Count() const { return static_cast<int>(classes_.size()); }
  [[nodiscard]] const std::vector<ColourClass>& Classes() const { return classes_; }
  /// @param bgr  Three bytes.
  /// @return a class below Count(), or kNoClass for a colour that is further than 40 levels of YUV
  ///   (mixture: 5 sigma) from its nearest class. A class that is far from the others extends up to
  ///   half the distance to the next one.
  [[nodiscard]] std::uint8_t Of(const std::uint8_t* bgr) const {
    return table_[static_cast<std::size_t>((bgr[0] >> 2) << 12 | (bgr[1] >> 2) << 6 |
                                           (bgr[2] >> 2))];
  }

 private:
  std::vector<ColourClass> classes_;
  std::vector<std::uint8_t> table_;  // 64 x 64 x 64, indexed by B, G, R
};

}  // namespace ceilmap::colour
