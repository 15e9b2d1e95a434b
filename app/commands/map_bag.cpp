#include "app/commands/map_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"
#include "app/files/trajectory_bag.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

constexpr const char* kGridTopic = "/map";
constexpr const char* kKeyframesTopic = "/keyframes";
// Viewers draw a grid as one texture, and this is the size that all of them support.
constexpr int kMaxGridSide = 4096;
constexpr std::uint8_t kUnknown = 255;  // -1 as a byte

// As map_server's mode `scale`, without its thresholds, which would clip the greys.
std::uint8_t CellOf(std::uint8_t grey, std::uint8_t alpha) {
  return alpha < 128 ? kUnknown : static_cast<std::uint8_t>((200 * (255 - grey) + 255) / 510);
}

// Rows of a grid run with y, those of the mosaic against it.
bags::GridMessage GridOf(const store::MosaicGrid& grid,
                         const cv::Mat& grey,
                         const cv::Mat& alpha,
                         std::int64_t stamp_ns) {
  bags::GridMessage message;
  message.header = {stamp_ns, files::kMapFrame};
  message.resolution_m = static_cast<float>(grid.resolution);
  message.width = static_cast<std::uint32_t>(grid.width_px);
  message.height = static_cast<std::uint32_t>(grid.height_px);
  message.origin.translation = {grid.min_x, grid.max_y - grid.height_px * grid.resolution, 0};
  message.data.reserve(grey.total());
  for (int row = grid.height_px - 1; row >= 0; --row) {
    const auto* const greys = grey.ptr<std::uint8_t>(row);
    const auto* const alphas = alpha.ptr<std::uint8_t>(row);
    for (int column = 0; column < grid.width_px; ++column) {
      message.data.push_back(CellOf(greys[column], alphas[column]));
    }
  }
  return message;
}

bags::PathMessage PathOf(const std::vector<graph::Keyframe>& keyframes, std::int64_t stamp_ns) {
  bags::PathMessage path;
  path.header = {stamp_ns, files::kMapFrame};
  for (const graph::Keyframe& keyframe : keyframes) {
    const std::int64_t at_ns = bags::Nanoseconds(keyframe.pose.stamp_s);
    path.poses.push_back({{at_ns, files::kMapFrame}, files::TransformOf(keyframe.pose)});
  }
  return path;
}

// Stamps may repeat if recordings were merged.
std::vector<graph::FramePose> FramesByTime(const store::MapReader& map) {
  std::vector<graph::FramePose> frames = map.ReadTrajectory();
  std::stable_sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) {
    return a.stamp_s < b.stamp_s;
  });
  return frames;
}

void WriteMap(const store::MosaicGrid& grid,
              const cv::Mat& grey,
              const cv::Mat& alpha,
              const store::MapReader& map,
              bags::McapWriter& writer) {
  const std::vector<graph::FramePose> frames = FramesByTime(map);
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  // A player publishes the map first.
  std::int64_t first_ns = frames.empty() ? 0 : bags::Nanoseconds(frames.front().stamp_s);
  for (const graph::Keyframe& keyframe : keyframes) {
    first_ns = std::min(first_ns, bags::Nanoseconds(keyframe.pose.stamp_s));
  }
  using bags::Durability;
  const auto on_map = writer.Add(kGridTopic, bags::kGridType, Durability::kTransientLocal);
  const auto on_path = writer.Add(kKeyframesTopic, bags::kPathType, Durability::kTransientLocal);
  writer.Write(on_map, first_ns, bags::Encode(GridOf(grid, grey, alpha, first_ns)));
  writer.Write(on_path, first_ns, bags::Encode(PathOf(keyframes, first_ns)));
  files::TrajectoryBag trajectory(writer);
  for (const graph::FramePose& frame : frames) {
    trajectory.Add(frame, graph::HasPose(frame.status));
  }
}

}  // namespace

store::MosaicGrid ExportMapBag(const store::MapReader& map, const std::filesystem::path& file) {
  if (map.Metadata().unit != "m") {
    throw InputError("a map in pixels has no metres, which ROS needs; make the map with a rig");
  }
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid grid = map.ReadOverview(kMaxGridSide, grey, alpha);
  if (grid.width_px == 0) {
    throw InputError("the map holds no mosaic, so there is no image to export");
  }
  bags::McapWriter writer(file);
  try {
    WriteMap(grid, grey, alpha, map, writer);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  writer.Commit();
  return grid;
}

}  // namespace ceilmap::commands
