#pragma once

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

/// A plate below a deck, both with texture, and keyframes of them whose images and heights are
/// exact.
namespace ceilmap::mosaic::two_planes {

inline constexpr double kUnitsPerPx = 0.01;
inline constexpr double kPlateRho = 1.25;
inline const cv::Rect2d kPlate(0.2, -0.4, 0.7, 0.8);  // in the map
inline const cv::Size kViewSize(160, 120);
inline constexpr int kCellPx = 8;  // of the height fields

inline bool OnPlate(const cv::Point2d& p_map) {
  return kPlate.contains(p_map);
}

inline double PlateBrightness(double x, double y) {
  return 90 + 40 * std::sin(31 * x + 11 * y) * std::sin(27 * y - 9 * x);
}

/// Brightness of the nearest surface at a place, seen from straight below.
inline double Truth(double x, double y) {
  return OnPlate({x, y}) ? PlateBrightness(x, y) : store::synthetic::Brightness(x / 3, y / 3);
}

/// The surface that a pixel shows.
inline double RhoAt(const ViewPlacement& view, const cv::Point2d& pixel) {
  return OnPlate(view.ToMap(pixel.x, pixel.y, kPlateRho)) ? kPlateRho : 1;
}

inline store::MapMetadata Metadata() {
  store::MapMetadata metadata = store::synthetic::Metadata(kViewSize, kUnitsPerPx);
  metadata.view_principal_px = {6, -4};
  return metadata;
}

inline cv::Mat Photograph(const ViewPlacement& view) {
  cv::Mat image(kViewSize, CV_8UC1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double rho = RhoAt(view, cv::Point2d(u, v));
      const cv::Point2d p_map = view.ToMap(u, v, rho);
      const double grey = rho > 1 ? PlateBrightness(p_map.x, p_map.y)
                                  : store::synthetic::Brightness(p_map.x / 3, p_map.y / 3);
      image.at<unsigned char>(v, u) = cv::saturate_cast<unsigned char>(grey);
    }
  }
  return image;
}

inline heights::HeightField Field(const ViewPlacement& view) {
  heights::HeightField field;
  field.grid = {kViewSize.width / kCellPx, kViewSize.height / kCellPx};
  field.step_px = {kCellPx, kCellPx};
  field.first_px = -0.5 * field.step_px.cwiseProduct(
                              Eigen::Vector2d(field.grid.width - 1, field.grid.height - 1));
  const cv::Point2d centre((kViewSize.width - 1) / 2.0, (kViewSize.height - 1) / 2.0);
  for (int i = 0; i < field.grid.area(); ++i) {
    const Eigen::Vector2d at = field.Centre(static_cast<std::size_t>(i));
    const double rho = RhoAt(view, centre + cv::Point2d(at.x(), at.y()));
    field.cells.push_back({static_cast<float>(rho), 0.01F});
  }
  return field;
}

/// Keyframes that look straight up at the given places.
struct Drive {
  store::MapMetadata metadata = Metadata();
  std::vector<graph::Keyframe> keyframes;
  std::vector<ViewPlacement> views;
  std::vector<cv::Mat> images;

  explicit Drive(const std::vector<Pose2>& poses) {
    for (const Pose2& pose : poses) {
      graph::Keyframe keyframe;
      keyframe.id = static_cast<std::int64_t>(keyframes.size());
      keyframe.pose.T_map_base = pose;
      keyframes.push_back(keyframe);
    }
    views = PlaceViews(keyframes, metadata);
    for (std::size_t k = 0; k < views.size(); ++k) {
      images.push_back(Photograph(views[k]));
      keyframes[k].heights = std::make_shared<const heights::HeightField>(Field(views[k]));
    }
  }
  [[nodiscard]] graph::ImageLoader Loader() const {
    return [this](std::int64_t id) { return images.at(static_cast<std::size_t>(id)); };
  }
};

/// Three rows of views, each half a view from the next.
inline Drive Rows() {
  std::vector<Pose2> poses;
  for (int row = -1; row <= 1; ++row) {
    for (int col = -1; col <= 2; ++col) poses.push_back({0.4 * col, 0.35 * row, 0.3 * col});
  }
  return Drive(poses);
}

}  // namespace ceilmap::mosaic::two_planes
