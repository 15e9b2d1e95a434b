#include "mapping/mosaic/outlines.hpp"

#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace ceilmap::mosaic {

store::Polygons OutlinesOf(const cv::Mat& mask, const store::MosaicGrid& grid) {
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> hierarchy;  // of each: next, previous, first hole, parent
  cv::findContours(mask, contours, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  const auto ring = [&](int i) {
    std::vector<cv::Point2d> points;
    for (const cv::Point& at : contours[static_cast<std::size_t>(i)]) {
      points.emplace_back(grid.min_x + (at.x + 0.5) * grid.resolution,
                          grid.max_y - (at.y + 0.5) * grid.resolution);
    }
    return points;
  };
  store::Polygons polygons;
  for (int i = 0; i < static_cast<int>(contours.size()); ++i) {
    const cv::Vec4i& links = hierarchy[static_cast<std::size_t>(i)];
    if (links[3] >= 0 || contours[static_cast<std::size_t>(i)].size() < 3) continue;
    std::vector<std::vector<cv::Point2d>> polygon{ring(i)};
    for (int hole = links[2]; hole >= 0; hole = hierarchy[static_cast<std::size_t>(hole)][0]) {
      polygon.push_back(ring(hole));
    }
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

}  // namespace ceilmap::mosaic
