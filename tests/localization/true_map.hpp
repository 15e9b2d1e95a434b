#pragma once

#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/planar_motion.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"
#include "tests/support/temp_folder.hpp"

/// Maps of synthetic ceilings whose keyframes lie where they truly are, and visitors' images.
namespace ceilmap::localization::synthetic {

using registration::synthetic::CeilingParams;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;

constexpr double kCeiling_m = 2.6;
/// One pixel of the synthetic ceiling, and of the mapping camera.
constexpr double kUnit_m = 0.01;

/// An upward camera of 320 x 240 px. 220 px and 0.4 m: 10 mm per pixel, 3.2 m x 2.4 m in view.
inline calib::MountedCamera UpCamera(double focal_px = 220, double height_m = 0.4) {
  calib::MountedCamera up;
  up.camera = {320, 240, focal_px, focal_px, 159.5, 119.5, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.05, 0, height_m);
  return up;
}

/// Image of a robot.
inline cv::Mat Seen(const SyntheticCeiling& ceiling,
                    const calib::CeilingView& view,
                    const Pose2& T_map_base,
                    std::uint32_t noise_seed = 1) {
  // A ceiling pixel is kUnit_m wide whatever the camera: MotionAt is in the view's own pixels.
  registration::ImageMotion motion = MotionAt(view, T_map_base);
  motion.scale = kUnit_m / view.MetresPerPixel();
  return ceiling.Render(view.Size(), motion, 1.5, noise_seed);
}

/// A keyframe at its true pose.
struct TrueKeyframe {
  std::int64_t id = 0;
  Pose2 T_map_base;
  cv::Mat image;
  Eigen::Vector3d information =
      Eigen::Vector3d::Zero();  ///< diagonal, of the edge to the one before
  std::shared_ptr<const heights::HeightField> heights;
};

inline void AddKeyframe(const TrueKeyframe& added,
                        places::PlaceDescriber& describer,
                        store::MapWriter& writer,
                        graph::MapGraph& graph) {
  graph::Keyframe keyframe;
  keyframe.id = added.id;
  keyframe.pose.keyframe_id = added.id;
  keyframe.pose.frame_index = added.id;
  keyframe.pose.T_map_base = added.T_map_base;
  keyframe.heights = added.heights;
  writer.AddImage(added.id, added.image);
  writer.AddDescriptors(added.id, describer.Describe(added.image));
  if (!graph.keyframes.empty()) {
    const Pose2& before = graph.keyframes.back().pose.T_map_base;
    graph::Edge tie{added.id - 1,
                    added.id,
                    graph::Edge::Kind::kOdometry,
                    before.Inverse() * added.T_map_base,
                    {}};
    tie.information = added.information.asDiagonal();
    graph.edges.push_back(tie);
  }
  graph.keyframes.push_back(keyframe);
  graph.trajectory.push_back(keyframe.pose);
}

/// A map of about `columns` x `rows` keyframes, 0.8 m apart, from the origin to the right and up;
/// even rows face along x, odd ones back.
class TrueMap {
 public:
  explicit TrueMap(const CeilingParams& params = {}, int columns = 7, int rows = 6)
      : ceiling(params) {
    const calib::CeilingView view(UpCamera(), kCeiling_m);
    store::MapMetadata metadata;
    metadata.resolution = view.MetresPerPixel();
    metadata.ceiling_height_m = kCeiling_m;
    metadata.view_size = view.Size();
    metadata.view_units_per_px = view.MetresPerPixel();
    metadata.T_base_view = view.T_base_view();
    const std::filesystem::path file = folder / "true.gpkg";
    store::MapWriter writer(file, metadata);
    places::PlaceDescriber describer(
        view.Size(),
        view.MetresPerPixel(),
        places::PlaceDescriptorParams::ForCamera(view.Size(), view.MetresPerPixel()));
    graph::MapGraph graph;
    constexpr double kStep = 0.8;
    for (int i = 0; i < columns * rows; ++i) {
      const int row = i / columns;
      const bool back = row % 2 == 1;
      const int column = back ? columns - 1 - i % columns : i % columns;
      const Pose2 T_map_base{column * kStep, row * kStep, back ? std::numbers::pi : 0};
      AddKeyframe({i,
                   T_map_base,
                   Seen(ceiling, view, T_map_base, static_cast<std::uint32_t>(i) + 100),
                   Eigen::Vector3d(1e8, 1e8, 1e9),
                   nullptr},
                  describer,
                  writer,
                  graph);
    }
    mosaic::MosaicParams mosaic;
    mosaic.resolution = metadata.resolution;
    mosaic.threads = 1;
    mosaic::WriteMap(graph, metadata, mosaic, writer);
    writer.Commit();
    map = std::make_unique<store::MapReader>(file);
  }

  support::TempFolder folder;
  SyntheticCeiling ceiling;
  std::unique_ptr<store::MapReader> map;
};

/// Identical tiles.
inline CeilingParams Periodic() {
  CeilingParams params;
  params.tile_px = 60;
  params.tile_grey = 0;
  params.speckle_grey = 0;
  params.lamps = false;
  params.marks = false;
  return params;
}

inline double DistanceOf(const Pose2& a, const Pose2& b) {
  return (a.Translation() - b.Translation()).norm();
}
inline double AngleBetween(const Pose2& a, const Pose2& b) {
  return std::abs(WrapAngle(a.yaw - b.yaw));
}

}  // namespace ceilmap::localization::synthetic
