#include "mapping/map_builder.hpp"

namespace ceilmap::mapping {

MosaicGrid WriteMap(const MapGraph& graph,
                    const MapMetadata& metadata,
                    const MosaicParams& mosaic,
                    MapWriter& writer,
                    const std::function<void(int, int)>& progress) {
  writer.WriteGraph(graph);
  const MosaicRenderer renderer(
      graph.keyframes,
      metadata,
      [&writer](std::int64_t id) { return writer.ReadPicture(id); },
      mosaic);
  writer.WriteMosaic(
      renderer.Grid(),
      [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
        renderer.Render(window, grey, alpha);
      },
      progress);
  return renderer.Grid();
}

}  // namespace ceilmap::mapping
