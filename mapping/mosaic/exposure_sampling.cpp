#include "mapping/mosaic/exposure_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "mapping/registration/noise.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr int kLatticeAcross = 10;  // points over the shorter side of an image
constexpr int kPatchRadius = 4;     // pixels
constexpr int kDark = 3;
constexpr int kSaturated = 250;
constexpr double kMaxContrast = 0.06;  // standard deviation over mean, besides the noise

/// Mean grey around (u, v), or nothing where the patch leaves the image, is not flat, dark or
/// saturated.
std::optional<double> FlatPatchMean(const cv::Mat& image,
                                    double noise_power,
                                    const cv::Point2d& pixel) {
  const int u = cvRound(pixel.x);
  const int v = cvRound(pixel.y);
  if (u < kPatchRadius || v < kPatchRadius || u >= image.cols - kPatchRadius ||
      v >= image.rows - kPatchRadius) {
    return std::nullopt;
  }
  double sum = 0;
  double squares = 0;
  for (int row = v - kPatchRadius; row <= v + kPatchRadius; ++row) {
    const auto* pixels = image.ptr<unsigned char>(row);
    for (int col = u - kPatchRadius; col <= u + kPatchRadius; ++col) {
      const int grey = pixels[col];
      if (grey <= kDark || grey >= kSaturated) return std::nullopt;
      sum += grey;
      squares += grey * grey;
    }
  }
  constexpr double kCount = (2 * kPatchRadius + 1) * (2 * kPatchRadius + 1);
  const double mean = sum / kCount;
  const double variance = squares / kCount - mean * mean - noise_power;
  if (variance > kMaxContrast * kMaxContrast * mean * mean) return std::nullopt;
  return mean;
}

}  // namespace

std::vector<ExposureObservation> ObserveExposure(const std::vector<ViewPlacement>& views,
                                                 cv::Size size,
                                                 double units_per_px,
                                                 const HeightMap& heights,
                                                 const cv::Mat& row_times,
                                                 const std::function<cv::Mat(std::size_t)>& load) {
  const double spacing = std::min(size.width, size.height) * units_per_px / kLatticeAcross;
  const cv::Point2d centre((size.width - 1) / 2.0, (size.height - 1) / 2.0);
  std::map<std::pair<std::int64_t, std::int64_t>, int> point_ids;
  std::vector<ExposureObservation> observations;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const cv::Mat image = load(k);
    const double noise_power = std::pow(registration::EstimateNoise(image), 2);
    const cv::Rect2d box = views[k].Bounds();
    const auto last_x = static_cast<std::int64_t>(std::floor(box.br().x / spacing));
    const auto last_y = static_cast<std::int64_t>(std::floor(box.br().y / spacing));
    for (auto y = static_cast<std::int64_t>(std::ceil(box.y / spacing)); y <= last_y; ++y) {
      for (auto x = static_cast<std::int64_t>(std::ceil(box.x / spacing)); x <= last_x; ++x) {
        const cv::Point2d at(static_cast<double>(x) * spacing, static_cast<double>(y) * spacing);
        const float rho = heights.RatioAt(at.x, at.y);
        const cv::Point2d pixel =
            rho > 0 ? views[k].ToPixel(at.x, at.y, rho) : views[k].ToPixel(at.x, at.y);
        if (rho > 0 && !heights.Sees(views[k], at, rho)) continue;
        const std::optional<double> grey = FlatPatchMean(image, noise_power, pixel);
        if (!grey) continue;
        const int point = point_ids.try_emplace({x, y}, point_ids.size()).first->second;
        const cv::Point2d offset = pixel - centre;
        const double row_s =
            row_times.empty() ? 0 : row_times.at<float>(cvRound(pixel.y), cvRound(pixel.x));
        observations.push_back({point,
                                static_cast<int>(k),
                                offset.dot(offset) / centre.dot(centre),
                                std::log(*grey),
                                row_s});
      }
    }
  }
  return observations;
}

}  // namespace ceilmap::mosaic
