#include "mapping/mosaic/map_builder.hpp"

namespace ceilmap::mosaic {

WrittenMap WriteMap(const graph::MapGraph& graph,
                    const store::MapMetadata& metadata,
                    const MosaicParams& mosaic,
                    store::MapWriter& writer,
                    const std::function<void(int, int)>& progress) {
  writer.WriteGraph(graph);
  const MosaicRenderer renderer(
      graph.keyframes,
      metadata,
      [&writer](std::int64_t id) { return writer.ReadImage(id); },
      mosaic);
  return WriteMosaic(renderer, writer, progress);
}

WrittenMap WriteMosaic(const MosaicRenderer& renderer,
                       store::MapWriter& writer,
                       const std::function<void(int, int)>& progress) {
  writer.WriteLeftOut(renderer.LeftOutPlaces());
  writer.WriteMosaic(
      renderer.Grid(),
      [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
        renderer.Render(window, grey, alpha);
      },
      progress);
  return {renderer.Grid(), renderer.LeftOutPlaces()};
}

MosaicParams ParamsFor(const store::MapMetadata& metadata, MosaicParams params) {
  params.view_mask = metadata.view_mask;
  if (params.resolution <= 0) params.resolution = metadata.resolution;
  return params;
}

}  // namespace ceilmap::mosaic
