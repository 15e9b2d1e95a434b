#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

namespace ceilmap::mosaic {

/// Election of the surface that covers each place of a raster, from votes of measured cells. The
/// result of a pixel is the median of the votes for one surface: the nearest (largest rho) among
/// those with at least a third of the votes of the most frequent one. Internal.
class SurfaceVotes {
 public:
  /// Largest radius of a vote, pixels.
  static constexpr float kMaxRadius = 8;

  /// The height of one measured cell. The centre of the raster's first pixel is (0, 0).
  struct Vote {
    float col;
    float row;
    float radius;  ///< of influence, pixels; at most kMaxRadius
    float rho;     ///< > 0
    float weight;  ///< at `col`, `row`; 1: an accurate cell. It falls to 0 at the radius.
  };

  void Add(const Vote& vote);
  /// The ratios of a window, CV_32FC1; 0 where no surface has a weight of 0.1, that of one accurate
  /// cell at 0.83 of its radius. Thread-safe.
  [[nodiscard]] cv::Mat_<float> Elect(const cv::Rect& window) const;

 private:
  std::unordered_map<std::int64_t, std::vector<Vote>> votes_;  // by square
};

}  // namespace ceilmap::mosaic
