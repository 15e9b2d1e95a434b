#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

namespace ceilmap::compass {

inline cv::Mat RandomPanorama(int rows, int cols, int type, unsigned seed) {
  cv::Mat panorama(rows, cols, type);
  std::mt19937 random(seed);
  const int row_bytes = cols * panorama.channels();
  for (int v = 0; v < rows; ++v) {
    for (int i = 0; i < row_bytes; ++i) {
      panorama.ptr(v)[i] = static_cast<std::uint8_t>(random() & 255U);
    }
  }
  return panorama;
}

/// The content moved to the right by `columns`, around the circle.
inline cv::Mat Rolled(const cv::Mat& panorama, int columns) {
  const int width = panorama.cols;
  cv::Mat rolled(panorama.size(), panorama.type());
  for (int u = 0; u < width; ++u) {
    panorama.col(u).copyTo(rolled.col(((u + columns) % width + width) % width));
  }
  return rolled;
}

/// A far away world without edges: waves of random phase around the horizon, which can be seen at
/// any heading, between the columns too.
class Waves {
 public:
  Waves(int rows, int cols, int type, unsigned seed)
      : empty_(rows, cols, type), phases_(std::vector<int>{rows, 3, kWaves}, CV_64F) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
    std::generate(phases_.begin<double>(), phases_.end<double>(), [&] { return phase(random); });
  }

  [[nodiscard]] cv::Mat At(double heading_rad) const {
    cv::Mat panorama = empty_.clone();
    const int channels = panorama.channels();
    for (int v = 0; v < panorama.rows; ++v) {
      for (int u = 0; u < panorama.cols; ++u) {
        const double azimuth =
            2 * std::numbers::pi * (0.5 - static_cast<double>(u) / panorama.cols);
        for (int c = 0; c < channels; ++c) {
          const double* phases = phases_.ptr<double>(v, c);
          double value = 128;
          for (int k = 1; k <= kWaves; ++k) {
            value += 20 * std::cos(k * (azimuth + heading_rad) + phases[k - 1]);
          }
          panorama.ptr(v)[u * channels + c] =
              static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
        }
      }
    }
    return panorama;
  }

 private:
  static constexpr int kWaves = 20;
  cv::Mat empty_;
  cv::Mat phases_;  ///< row, channel, wave
};

}  // namespace ceilmap::compass
