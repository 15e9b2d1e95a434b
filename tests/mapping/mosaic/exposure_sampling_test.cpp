#include "mapping/mosaic/exposure_sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

/// Images of a uniform plate below a uniform deck.
cv::Mat Uniform(const ViewPlacement& view) {
  cv::Mat image(two_planes::kViewSize, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const bool plate = two_planes::RhoAt(view, cv::Point2d(u, v)) > 1;
      image.at<unsigned char>(v, u) = plate ? 150 : 100;
    }
  }
  return image;
}

/// Ceiling points that are seen at two brightnesses, and points that are seen twice or more.
std::pair<int, int> MixedOf(const two_planes::Drive& drive, const HeightMap& heights) {
  const auto observations = ObserveExposure(
      drive.views, two_planes::kViewSize, two_planes::kUnitsPerPx, heights, {}, [&](std::size_t k) {
        return Uniform(drive.views[k]);
      });
  std::map<int, std::vector<double>> points;
  for (const ExposureObservation& o : observations) points[o.point].push_back(o.log_grey);
  std::pair<int, int> mixed(0, 0);
  for (const auto& [point, greys] : points) {
    if (greys.size() < 2) continue;
    ++mixed.second;
    const auto [least, most] = std::minmax_element(greys.begin(), greys.end());
    if (*most - *least > 0.01) ++mixed.first;
  }
  return mixed;
}

TEST(ExposureSampling, ComparesTheSameSurface) {
  const two_planes::Drive drive = two_planes::Rows();
  const auto [mixed, seen] = MixedOf(drive, HeightMap(drive.keyframes, drive.metadata));
  EXPECT_GT(seen, 100);
  EXPECT_LT(mixed, 0.01 * seen);
  // Without heights the plate is compared with the deck.
  EXPECT_GT(MixedOf(drive, HeightMap()).first, 10);
}

// In dim light the noise of each pixel exceeds the contrast that a flat patch may have.
TEST(ExposureSampling, NoiseIsNoContrast) {
  const two_planes::Drive drive = two_planes::Rows();
  cv::RNG rng(3);
  const auto count = [&](double noise, bool edges) {
    return ObserveExposure(drive.views,
                           two_planes::kViewSize,
                           two_planes::kUnitsPerPx,
                           HeightMap(),
                           {},
                           [&](std::size_t /*k*/) {
                             cv::Mat image(two_planes::kViewSize, CV_16SC1, cv::Scalar(60));
                             for (int u = 0; edges && u < image.cols; u += 10) {
                               image.colRange(u, std::min(u + 5, image.cols)) = 90;
                             }
                             cv::Mat random(image.size(), CV_16SC1);
                             rng.fill(random, cv::RNG::NORMAL, 0, noise);
                             image += random;
                             image.convertTo(image, CV_8U);
                             return image;
                           })
        .size();
  };
  const std::size_t all = count(0, false);
  EXPECT_GT(all, 1000U);
  EXPECT_GT(count(8, false), 0.9 * static_cast<double>(all));
  EXPECT_LT(count(8, true), 0.05 * static_cast<double>(all));
}

}  // namespace
}  // namespace ceilmap::mosaic
