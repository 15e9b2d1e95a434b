// A map as large as a hall, made of many copies of a small one, to measure how much of it is read
// over a network: `ceilmap_grow_map SMALL.gpkg COLUMNS ROWS LARGE.gpkg`. Only the copy at the
// origin looks as the small map; the others are of the same size in the file.

#include <fmt/format.h>

#include <cstdlib>
#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap {
namespace {

class Grown {
 public:
  Grown(const std::string& small, int columns, int rows, const std::string& large)
      : map_(small),
        writer_(large, map_.Metadata()),
        columns_(columns),
        rows_(rows),
        graph_(map_.ReadGraph()),
        ids_(graph_.keyframes.back().id + 1) {}

  void Write() {
    for (int copy = 0; copy < columns_ * rows_; ++copy) AddCopy(copy);
    writer_.WriteGraph(all_);
    store::MosaicGrid grid = map_.Grid();
    grid.max_y += (rows_ - 1) * grid.height_px * grid.resolution;
    grid.width_px *= columns_;
    grid.height_px *= rows_;
    map_.ReadMosaic({0, 0, map_.Grid().width_px, map_.Grid().height_px}, grey_, alpha_);
    cv::flip(255 - grey_, other_grey_, 1);
    cv::flip(alpha_, other_alpha_, 1);
    writer_.WriteMosaic(grid, [this](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
      Draw(window, grey, alpha);
    });
    writer_.Commit();
    fmt::print(
        "{:.0f} m^2, {} keyframes\n",
        static_cast<double>(grid.width_px) * grid.height_px * grid.resolution * grid.resolution,
        all_.keyframes.size());
  }

 private:
  void AddCopy(int copy) {
    const store::MosaicGrid& grid = map_.Grid();
    const Pose2 T_map_copy{copy % columns_ * grid.width_px * grid.resolution,
                           copy / columns_ * grid.height_px * grid.resolution,
                           0};
    const std::int64_t first = copy * ids_;
    for (graph::Keyframe keyframe : graph_.keyframes) {
      writer_.AddImage(first + keyframe.id, map_.ReadImage(keyframe.id));
      cv::Mat descriptors = map_.ReadDescriptors(keyframe.id);
      if (copy > 0) descriptors.colRange(2, descriptors.cols) *= -1;
      writer_.AddDescriptors(first + keyframe.id, descriptors);
      keyframe.id += first;
      Move(T_map_copy, first, keyframe.pose);
      all_.keyframes.push_back(keyframe);
    }
    for (graph::FramePose frame : graph_.trajectory) {
      Move(T_map_copy, first, frame);
      all_.trajectory.push_back(frame);
    }
    for (graph::Edge edge : graph_.edges) {
      edge.from += first;
      edge.to += first;
      all_.edges.push_back(edge);
    }
    if (copy == 0) return;
    graph::Edge link = graph_.edges.front();  // to the copy before
    const std::size_t n = graph_.keyframes.size();
    const auto& before = all_.keyframes[all_.keyframes.size() - 2 * n];
    const auto& here = all_.keyframes[all_.keyframes.size() - n];
    link.from = before.id;
    link.to = here.id;
    link.T_from_to = before.pose.T_map_base.Inverse() * here.pose.T_map_base;
    all_.edges.push_back(link);
  }
  static void Move(const Pose2& T_map_copy, std::int64_t first, graph::FramePose& frame) {
    frame.T_map_base = T_map_copy * frame.T_map_base;
    frame.keyframe_id += first;
  }

  void Draw(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const {
    grey.create(window.size(), CV_8UC1);
    alpha.create(window.size(), CV_8UC1);
    const cv::Size size = grey_.size();
    for (int v = 0; v < window.height; ++v) {
      for (int u = 0; u < window.width; ++u) {
        const cv::Point at(window.x + u, window.y + v);
        const cv::Point in(at.x % size.width, at.y % size.height);
        const bool original = at.x < size.width && at.y >= (rows_ - 1) * size.height;
        grey.at<unsigned char>(v, u) = (original ? grey_ : other_grey_).at<unsigned char>(in);
        alpha.at<unsigned char>(v, u) = (original ? alpha_ : other_alpha_).at<unsigned char>(in);
      }
    }
  }

  store::MapReader map_;
  store::MapWriter writer_;
  int columns_;
  int rows_;
  graph::MapGraph graph_;
  std::int64_t ids_;
  graph::MapGraph all_;
  cv::Mat grey_, alpha_, other_grey_, other_alpha_;
};

}  // namespace
}  // namespace ceilmap

int main(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "ceilmap_grow_map SMALL.gpkg COLUMNS ROWS LARGE.gpkg\n");
    return 2;
  }
  ceilmap::Grown(argv[1], std::atoi(argv[2]), std::atoi(argv[3]), argv[4]).Write();
  return 0;
}
