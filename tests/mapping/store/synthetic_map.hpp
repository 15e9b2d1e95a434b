#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

/// A ceiling of known texture, images of it from known poses, and map files made of them.
namespace ceilmap::store::synthetic {

inline MapMetadata Metadata(cv::Size view_size, double units_per_px) {
  MapMetadata metadata;
  metadata.resolution = units_per_px;
  metadata.ceiling_height_m = 2.6;
  metadata.rig_yaml = "robot: \"robot 1\"\n# \xc2\xb5, quotes ' and a tab\t\n";
  metadata.robot = "robot 1";
  metadata.view_size = view_size;
  metadata.view_units_per_px = units_per_px;
  metadata.view_focal_px = 440;
  metadata.view_principal_px = {1.0 / 3, -2};
  metadata.T_base_view = {0.01, -0.02, 1.5707963267948966};
  metadata.program_version = "0.1.0";
  metadata.provenance = "ceilmap map --up video.mp4";
  return metadata;
}

/// Smooth ceiling brightness in [60, 200]; its shortest wave is about 12 pixels of 5 mm, so that
/// interpolation loses little.
inline double Brightness(double x, double y) {
  return 130 + 25 * std::sin(17.0 * x + 3.0 * std::sin(5 * y)) + 25 * std::sin(21.0 * y - 4.0 * x) +
         20 * std::sin(90.0 * x + 40.0 * y) * std::sin(80.0 * y - 30.0 * x);
}

/// Brightness of a plain ceiling with some slow change, for exposure: no edges.
inline double SlowBrightness(double x, double y) {
  return 120 + 20 * std::sin(2.1 * x + 0.3) * std::cos(1.7 * y);
}

/// Image of a ceiling from a pose.
/// @param gain(q)  factor on the brightness at squared radius q (1 in the corner).
template <typename Texture, typename Gain>
cv::Mat Photograph(const mosaic::ViewPlacement& view, cv::Size size, Texture texture, Gain gain) {
  cv::Mat image(size, CV_8UC1);
  const double cu = (size.width - 1) / 2.0;
  const double cv = (size.height - 1) / 2.0;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const cv::Point2d p_map = view.ToMap(u, v);
      const double q = ((u - cu) * (u - cu) + (v - cv) * (v - cv)) / (cu * cu + cv * cv);
      image.at<unsigned char>(v, u) =
          cv::saturate_cast<unsigned char>(texture(p_map.x, p_map.y) * gain(q));
    }
  }
  return image;
}

/// Keyframes on a lawnmower path with turns, about 60 % overlap.
inline std::vector<graph::Keyframe> Lawnmower(int columns, int rows, double step) {
  std::vector<graph::Keyframe> keyframes;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < columns; ++col) {
      graph::Keyframe keyframe;
      keyframe.id = static_cast<std::int64_t>(keyframes.size());
      keyframe.pose.frame_index = keyframe.id * 6;
      keyframe.pose.stamp_s = 100 + 0.6 * static_cast<double>(keyframe.id);
      const double along = (row % 2 == 0 ? col : columns - 1 - col) * step;
      keyframe.pose.T_map_base = {
          along + 0.0137, row * step * 0.9 - 0.0071, 0.37 * row + 0.21 * col};
      keyframe.pose.keyframe_id = keyframe.id;
      keyframe.ambiguous = keyframe.id == 3;
      keyframes.push_back(keyframe);
    }
  }
  return keyframes;
}

/// A small complete map: keyframes with images, trajectory, edges and a mosaic whose pixel (col,
/// row) is Grey(col, row), never seen in the upper left corner of 20 x 10.
inline unsigned char Grey(int col, int row) {
  return static_cast<unsigned char>((col * 7 + row * 13) % 251);
}
inline const MosaicGrid kGrid{-1.25, 3.5, 0.005, 700, 300};

inline void FillMosaic(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
  grey.create(window.size(), CV_8UC1);
  alpha.create(window.size(), CV_8UC1);
  for (int row = 0; row < window.height; ++row) {
    for (int col = 0; col < window.width; ++col) {
      const bool seen = col + window.x >= 20 || row + window.y >= 10;
      alpha.at<unsigned char>(row, col) = seen ? 255 : 0;
      grey.at<unsigned char>(row, col) = seen ? Grey(col + window.x, row + window.y) : 0;
    }
  }
}

/// Whether two images have the same size, type and pixels.
inline bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

inline cv::Mat Image(std::int64_t id, cv::Size size) {
  cv::Mat image(size, CV_8UC1);
  cv::RNG rng(static_cast<std::uint64_t>(id) + 1);
  rng.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

/// Heights of a ceiling with depth on a grid of 4 x 3 cells.
inline std::shared_ptr<const heights::HeightField> Heights(std::int64_t id) {
  auto field = std::make_shared<heights::HeightField>();
  field->grid = {4, 3};
  field->first_px = {-24.5, -16 + 0.1 * static_cast<double>(id)};
  field->step_px = {16, 1.0 / 3};
  field->scale_sigma = 0.01 / 3;
  for (int i = 0; i < field->grid.area(); ++i) {
    const float rho = 1 + 0.1F * static_cast<float>(i) / 3;
    field->cells.push_back(i % 5 == 4 ? heights::kUnknown : heights::HeightCell{rho, 0.003F * rho});
  }
  return field;
}

struct SmallMap {
  MapMetadata metadata = Metadata({64, 48}, 0.005);
  std::vector<graph::Keyframe> keyframes = Lawnmower(3, 2, 0.1);
  std::vector<graph::FramePose> trajectory;
  std::vector<graph::Edge> edges;

  SmallMap() {
    for (const std::size_t i : {1, 4}) keyframes[i].heights = Heights(keyframes[i].id);
    for (int i = 0; i < 40; ++i) {
      graph::FramePose frame;
      frame.frame_index = i;
      frame.stamp_s = 100 + i / 30.0;
      frame.keyframe_id = i % 6;
      frame.status =
          i % 7 == 0 ? graph::TrackingStatus::kRelocalized : graph::TrackingStatus::kTracking;
      frame.T_map_base = {0.1 * i + 1.0 / 3, -0.2 * i, 0.1 * i - 2};
      frame.covariance << 1.0 / 3, 0.1, 0.2, 0.1, 1.0 / 7, 0.3, 0.2, 0.3, 1e-17;
      trajectory.push_back(frame);
    }
    for (std::size_t i = 1; i < keyframes.size(); ++i) {
      graph::Edge edge;
      edge.from = keyframes[i - 1].id;
      edge.to = keyframes[i].id;
      constexpr std::array kKinds = {graph::Edge::Kind::kOdometry,
                                     graph::Edge::Kind::kLoopClosure,
                                     graph::Edge::Kind::kWheels};
      edge.kind = kKinds.at(i % 3);
      edge.T_from_to = {1.0 / 3, -0.1 * static_cast<double>(i), 0.7};
      edge.information << 1e6 / 3, 5, 6, 5, 2e6 / 7, 7, 6, 7, 1e8;
      edges.push_back(edge);
    }
  }

  [[nodiscard]] graph::MapGraph Graph() const {
    graph::MapGraph graph{keyframes, edges, trajectory, {}, {}};
    graph.weak_spots = {{graph::WeakSpot::Kind::kLost, 1, 1.0 / 3, -2, 17},
                        {graph::WeakSpot::Kind::kAmbiguous, 2, 4, 5, 0},
                        {graph::WeakSpot::Kind::kUnclosed, 0, 6, 7, 12.5}};
    graph.quality.loops = {100, 50, 20, 10, 5, 3, 2};
    graph.quality.chi2_per_dof = 1.0 / 3;
    graph.quality.max_edge_sigmas = 4.5;
    graph.quality.odometry_rms = 1e-4;
    graph.quality.loop_rms = 2e-4;
    return graph;
  }

  void WriteTo(MapWriter& writer) const {
    for (const graph::Keyframe& keyframe : keyframes) {
      writer.AddImage(keyframe.id, Image(keyframe.id, metadata.view_size));
    }
    writer.WriteGraph(Graph());
    writer.WriteMosaic(kGrid, FillMosaic);
  }
  void Write(const std::filesystem::path& file) const {
    MapWriter writer(file, metadata);
    WriteTo(writer);
    writer.Commit();
  }
};

}  // namespace ceilmap::store::synthetic
