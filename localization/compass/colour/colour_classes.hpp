#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::colour {

/// How colours are put together in classes.
enum class Clustering {
  kMeans,    ///< k-means in YUV (ViCTORiA)
  kMixture,  ///< EM on a mixture of Gaussians in YUV (Sturm & Visser)
};

struct ColourClassParams {
  Clustering clustering = Clustering::kMeans;
  int classes = 8;          ///< 2 .. kMaxClasses
  std::uint64_t seed = 1;   ///< the same samples give the same classes
  int max_samples = 40000;  ///< that are clustered, evenly chosen from those given, > 0

  void Validate() const;  ///< throws InputError naming field, value and range
};

inline constexpr int kMaxClasses = 32;
/// Of a colour that no class is like: nothing of that kind was learned.
inline constexpr std::uint8_t kNoClass = 255;

/// One class of colours.
struct ColourClass {
  std::array<float, 3> mean{};  ///< Y, U, V of cv::COLOR_BGR2YUV, [0, 255]
  /// k-means: ones and zeros. Mixture: covariance, row by row.
  std::array<float, 9> covariance{1, 0, 0, 0, 1, 0, 0, 0, 1};
  float weight = 1;  ///< part of the samples, (0, 1]
};

/// Tells which class a colour belongs to: by a table over the colours in steps of 4 grey levels, so
/// that a pixel costs one look-up.
class ColourClasses {
 public:
  /// @param classes  2 .. kMaxClasses; by rising brightness as Learn makes them, in any order
  /// otherwise. @throws InputError when they are too few or many, or numbers that cannot be.
  explicit ColourClasses(std::vector<ColourClass> classes);

  /// @param bgr  CV_8UC3, samples in any shape. @throws InputError when they show fewer
  ///   different colours than classes were asked for (a grey or dark video).
  static ColourClasses Learn(const cv::Mat& bgr, const ColourClassParams& params = {});

  [[nodiscard]] int Count() const { return static_cast<int>(classes_.size()); }
  [[nodiscard]] const std::vector<ColourClass>& Classes() const { return classes_; }
  /// @param bgr  three bytes. @return below Count(), or kNoClass for a colour further than 40
  ///   levels of YUV (mixture: 5 sigma) from the class that it is nearest to; classes that lie
  ///   apart reach as far as half the way to the next.
  [[nodiscard]] std::uint8_t Of(const std::uint8_t* bgr) const {
    return table_[static_cast<std::size_t>((bgr[0] >> 2) << 12 | (bgr[1] >> 2) << 6 |
                                           (bgr[2] >> 2))];
  }

 private:
  std::vector<ColourClass> classes_;
  std::vector<std::uint8_t> table_;  // 64 x 64 x 64, by B, G, R
};

}  // namespace ceilmap::colour
