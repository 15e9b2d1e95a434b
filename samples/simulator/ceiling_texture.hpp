#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <list>
#include <mutex>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

#include "samples/simulator/ceiling_pattern.hpp"

namespace ceilmap::simulator {

/// A rectangle of the ceiling's samples for interpolation: texel (row, column) of `light` lies at x
/// = (column0 + column + 0.5) * pitch_x_m. Light in 16 bits, 8192 = 1.
struct CeilingWindow {
  static constexpr float kOne = 8192;
  cv::Mat light;  ///< CV_16UC1
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;
  double pitch_x_m = 1;
  double pitch_y_m = 1;

  /// Interpolates texels bilinearly, `count` at most kMaxSamples: sampled[i] at (column[i],
  /// row[i]), relative to the window's first texel; both >= 0 and with a texel to the right and
  /// below.
  static constexpr int kMaxSamples = 64;
  void Sample(const float* column, const float* row, int count, float* sampled) const;
};

/// The ceiling's image, computed on demand in tiles, with a cache of the most recently used ones.
/// Level n has texels of 2^n x 2^n samples, for views too wide for single samples. Thread-safe.
class CeilingTexture {
 public:
  static constexpr int kTileSize = 256;  // texels

  CeilingTexture(const Scene& scene, double pitch_m) : pattern_(scene, pitch_m) {}

  /// The window that contains an area (metres) and a margin of two texels, at the finest level at
  /// which it is below 4096 x 4096 texels.
  [[nodiscard]] CeilingWindow Window(const Eigen::AlignedBox2d& area) const;
  /// The same window, with the light of some parts of it and their margins only.
  [[nodiscard]] CeilingWindow Window(const Eigen::AlignedBox2d& area,
                                     const std::vector<Eigen::AlignedBox2d>& parts) const;

 private:
  static constexpr std::size_t kMaxTiles = 700;  // of 128 kB each

  struct Key {
    int level;
    std::int64_t column;
    std::int64_t row;
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const;
  };
  struct Entry {
    Key key;
    cv::Mat tile;
  };

  [[nodiscard]] cv::Mat Tile(const Key& key) const;
  [[nodiscard]] cv::Mat Draw(const Key& key) const;
  [[nodiscard]] cv::Mat Find(const Key& key) const;
  void Keep(const Key& key, const cv::Mat& tile) const;

  CeilingPattern pattern_;
  mutable std::mutex mutex_;        // guards the following members
  mutable std::list<Entry> tiles_;  // most recently used first
  mutable std::unordered_map<Key, std::list<Entry>::iterator, KeyHash> places_;
};

}  // namespace ceilmap::simulator
