#include <algorithm>
#include <filesystem>
#include <future>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/attribute_tables.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/history_tables.hpp"
#include "mapping/store/image_codec.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_metadata.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/site_tables.hpp"
#include "mapping/store/table_layout.hpp"

namespace ceilmap::store {
namespace {

/// Side of the windows in which the mosaic is rendered and written; a multiple of the tile's.
constexpr int kWindowPx = 4 * tables::kTilePx;

std::vector<cv::Rect> Windows(const MosaicGrid& grid) {
  std::vector<cv::Rect> windows;
  for (int y = 0; y < grid.height_px; y += kWindowPx) {
    for (int x = 0; x < grid.width_px; x += kWindowPx) {
      windows.emplace_back(
          x, y, std::min(kWindowPx, grid.width_px - x), std::min(kWindowPx, grid.height_px - y));
    }
  }
  return windows;
}

/// Reduction factors 2, 4, 8, ... until the whole mosaic fits into one tile.
std::vector<int> OverviewFactors(const MosaicGrid& grid) {
  std::vector<int> factors;
  const int side = std::max(grid.width_px, grid.height_px);
  for (int factor = 2; side > (factor / 2) * tables::kTilePx; factor *= 2)
    factors.push_back(factor);
  return factors;
}

struct RenderedWindow {
  cv::Mat grey;
  cv::Mat alpha;
};

RenderedWindow RenderWindow(const MosaicSource& source, const cv::Rect& window) {
  RenderedWindow rendered;
  source(window, rendered.grey, rendered.alpha);
  if (rendered.grey.size() != window.size() || rendered.alpha.size() != window.size() ||
      rendered.grey.type() != CV_8UC1 || rendered.alpha.type() != CV_8UC1) {
    throw RunError("the mosaic source gave an image of another size or type");
  }
  return rendered;
}

}  // namespace

struct MapWriter::Impl {
  static std::unique_ptr<Impl> Make(const std::filesystem::path& file, MapMetadata metadata);
  Impl(const std::filesystem::path& path, MapMetadata map_metadata)
      : file(path, {"-wal", "-shm", "-journal"}), metadata(std::move(map_metadata)) {}

  /// Throws when the previous call failed or GDAL reported an error.
  void Check(const GdalScope& gdal, bool succeeded) const {
    if (succeeded && !gdal.Failed()) return;
    throw RunError("cannot write " + file.Target().string() + ": " +
                   (gdal.Message().empty() ? "unknown GDAL error" : gdal.Message()));
  }

  void CreateTables();
  void CopyTables(const std::filesystem::path& map);
  void OpenDataset(const GdalScope& gdal);
  void CloseDataset(const GdalScope& gdal);
  void GatherDescriptors();
  void AddMosaicTable(const GdalScope& gdal, const MosaicGrid& grid);
  void WriteTiles(const cv::Rect& window, const RenderedWindow& rendered);
  OGRLayer& Layer(const char* name) const;

  AtomicFile file;
  MapMetadata metadata;
  // GDAL datasets take one call at a time; while a window is written, the next one is rendered from
  // images read back by another thread.
  mutable std::mutex mutex;
  GDALDatasetUniquePtr dataset;  // after `file`: closed before the partial file is removed
};

std::unique_ptr<MapWriter::Impl> MapWriter::Impl::Make(const std::filesystem::path& file,
                                                       MapMetadata metadata) {
  if (file.extension() != ".gpkg") {
    throw InputError(file.string() + ": a map file's name must end in .gpkg");
  }
  if (const std::string problem = Problem(metadata); !problem.empty()) {
    throw InputError(file.string() + ": cannot describe the map: " + problem);
  }
  metadata.format_version = kMapFormatVersion;
  return std::make_unique<Impl>(file, std::move(metadata));
}

void MapWriter::Impl::CreateTables() {
  const GdalScope gdal;
  const FastSqlite fast;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  if (driver == nullptr) throw RunError("this GDAL has no GeoPackage driver");
  std::filesystem::remove(file.PartialPath());  // GDAL creates the file itself
  dataset.reset(driver->Create(file.PartialPath().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  Check(gdal, dataset && dataset->StartTransaction() == OGRERR_NONE);
  OGRSpatialReference srs = LocalSrs(metadata.unit);
  Check(gdal,
        tables::CreateKeyframes(*dataset, srs) && tables::CreateTrajectory(*dataset, srs) &&
            tables::CreateEdges(*dataset, srs) && tables::CreateWeakSpots(*dataset, srs) &&
            tables::CreateLeftOut(*dataset, srs) &&
            tables::CreateImages(*dataset, tables::kImages) &&
            tables::CreateImages(*dataset, tables::kMask) && tables::CreateDescriptors(*dataset) &&
            tables::CreateHeights(*dataset));
  if (metadata.site) {
    OGRLayer* points = tables::CreateControlPoints(*dataset, srs);
    Check(gdal, points != nullptr);
    for (const auto& point : metadata.site->points) Check(gdal, tables::Append(*points, point));
  }
  OGRLayer* rows = tables::CreateMetadata(*dataset);
  Check(gdal, rows != nullptr);
  for (const auto& [key, value] : ToRows(metadata)) Check(gdal, tables::Append(*rows, key, value));
  if (metadata.view_mask.empty()) return;
  const std::vector<unsigned char> mask = EncodeImage(metadata.view_mask);
  Check(gdal, tables::Append(Layer(tables::kMask), 0, mask));
}

void MapWriter::Impl::CopyTables(const std::filesystem::path& map) {
  std::error_code error;
  std::filesystem::copy_file(
      map, file.PartialPath(), std::filesystem::copy_options::overwrite_existing, error);
  if (error) throw RunError("cannot write " + file.Target().string() + ": " + error.message());
  const GdalScope gdal;
  OpenDataset(gdal);
}

void MapWriter::Impl::OpenDataset(const GdalScope& gdal) {
  const FastSqlite fast;
  const std::array<const char*, 2> drivers = {"GPKG", nullptr};
  const std::array<const char*, 4> options = {
      "BAND_COUNT=2", "TILE_FORMAT=PNG", "ZLEVEL=1", nullptr};
  dataset.reset(GDALDataset::Open(file.PartialPath().c_str(),
                                  GDAL_OF_RASTER | GDAL_OF_VECTOR | GDAL_OF_UPDATE,
                                  drivers.data(),
                                  options.data(),
                                  nullptr));
  Check(gdal, dataset && dataset->StartTransaction() == OGRERR_NONE);
}

void MapWriter::Impl::CloseDataset(const GdalScope& gdal) {
  Check(gdal, dataset->CommitTransaction() == OGRERR_NONE);
  dataset.reset();
  Check(gdal, true);
}

/// They were written between images. A robot that is lost reads them all, over a network too.
void MapWriter::Impl::GatherDescriptors() {
  try {
    GatherTable(file.PartialPath(), tables::kDescriptors);
  } catch (const RunError& error) {
    throw RunError("cannot write " + file.Target().string() + ": " + error.what());
  }
}

void MapWriter::Impl::AddMosaicTable(const GdalScope& gdal, const MosaicGrid& grid) {
  const FastSqlite fast;
  CPLStringList options;
  options.SetNameValue("APPEND_SUBDATASET", "YES");
  options.SetNameValue("RASTER_TABLE", tables::kMosaic);
  options.SetNameValue("RASTER_DESCRIPTION", "Ceiling mosaic, seen from above");
  options.SetNameValue("TILE_FORMAT", "PNG");
  options.SetNameValue("BLOCKSIZE", std::to_string(tables::kTilePx).c_str());
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  const GDALDatasetUniquePtr raster(driver->Create(
      file.PartialPath().c_str(), grid.width_px, grid.height_px, 2, GDT_Byte, options.List()));
  Check(gdal, raster != nullptr);
  std::array<double, 6> geo_transform = {
      grid.min_x, grid.resolution, 0, grid.max_y, 0, -grid.resolution};
  const OGRSpatialReference srs = LocalSrs(metadata.unit);
  Check(gdal, raster->SetSpatialRef(&srs) == CE_None);
  Check(gdal, raster->SetGeoTransform(geo_transform.data()) == CE_None);
}

/// One tile at a time, so that a thread that reads images waits for at most one tile.
void MapWriter::Impl::WriteTiles(const cv::Rect& window, const RenderedWindow& rendered) {
  for (int y = 0; y < window.height; y += tables::kTilePx) {
    for (int x = 0; x < window.width; x += tables::kTilePx) {
      const cv::Rect tile(x,
                          y,
                          std::min(tables::kTilePx, window.width - x),
                          std::min(tables::kTilePx, window.height - y));
      if (cv::countNonZero(rendered.alpha(tile)) == 0) continue;  // an absent tile is transparent
      const std::array<cv::Mat, 2> bands = {rendered.grey(tile), rendered.alpha(tile)};
      cv::Mat pixels;
      cv::merge(bands.data(), bands.size(), pixels);

      const std::lock_guard lock(mutex);
      const GdalScope gdal;
      const CPLErr error = dataset->RasterIO(GF_Write,
                                             window.x + x,
                                             window.y + y,
                                             tile.width,
                                             tile.height,
                                             pixels.data,
                                             tile.width,
                                             tile.height,
                                             GDT_Byte,
                                             2,
                                             nullptr,
                                             2,
                                             static_cast<GSpacing>(pixels.step),
                                             1,
                                             nullptr);
      // GDAL would keep written tiles until its cache is full, which wastes memory.
      if (error == CE_None) dataset->FlushCache(false);
      Check(gdal, error == CE_None);
    }
  }
}

OGRLayer& MapWriter::Impl::Layer(const char* name) const {
  OGRLayer* layer = dataset ? dataset->GetLayerByName(name) : nullptr;
  if (layer == nullptr) throw RunError("cannot write " + file.Target().string());
  return *layer;
}

MapWriter::MapWriter(const std::filesystem::path& file, MapMetadata metadata)
    : impl_(Impl::Make(file, std::move(metadata))) {
  impl_->CreateTables();
}

MapWriter::MapWriter(const std::filesystem::path& file,
                     MapMetadata metadata,
                     const std::filesystem::path& map)
    : impl_(Impl::Make(file, std::move(metadata))) {
  impl_->CopyTables(map);
}

MapWriter::~MapWriter() {
  const GdalScope gdal;  // closing an unfinished file may report errors that no longer matter
  impl_.reset();
}

void MapWriter::AddImage(std::int64_t keyframe_id, const cv::Mat& image) {
  if (image.type() != CV_8UC1 || image.size() != impl_->metadata.view_size) {
    throw InputError("keyframe " + std::to_string(keyframe_id) +
                     ": the image must be 8 bit grey and of the view's size");
  }
  const std::vector<unsigned char> png = EncodeImage(image);
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  impl_->Check(gdal, tables::Append(impl_->Layer(tables::kImages), keyframe_id, png));
}

cv::Mat MapWriter::ReadImage(std::int64_t keyframe_id) const {
  std::vector<unsigned char> png;
  {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    png = tables::ReadPng(impl_->Layer(tables::kImages), keyframe_id);
  }
  return DecodeImage(png, impl_->metadata.view_size);
}

void MapWriter::CopyImage(const MapReader& from, std::int64_t id_there, std::int64_t keyframe_id) {
  const std::vector<unsigned char> png = from.ReadPng(id_there);
  AddDescriptors(keyframe_id, from.ReadDescriptors(id_there));
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  impl_->Check(gdal, tables::Append(impl_->Layer(tables::kImages), keyframe_id, png));
}

void MapWriter::AddDescriptors(std::int64_t keyframe_id, const cv::Mat& descriptors) {
  if (descriptors.type() != CV_32FC1) {
    throw InputError("keyframe " + std::to_string(keyframe_id) +
                     ": place descriptors must be 32 bit numbers");
  }
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  impl_->Check(gdal, tables::Append(impl_->Layer(tables::kDescriptors), keyframe_id, descriptors));
}

cv::Mat MapWriter::ReadDescriptors(std::int64_t keyframe_id) const {
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  return tables::ReadDescriptors(impl_->Layer(tables::kDescriptors), keyframe_id);
}

void MapWriter::RemoveImage(std::int64_t keyframe_id) {
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  impl_->Check(gdal,
               impl_->Layer(tables::kImages).DeleteFeature(keyframe_id) == OGRERR_NONE &&
                   impl_->Layer(tables::kDescriptors).DeleteFeature(keyframe_id) == OGRERR_NONE);
}

void MapWriter::WriteGraph(const graph::MapGraph& graph) {
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    impl_->Check(gdal, tables::Append(impl_->Layer(tables::kKeyframes), keyframe));
    poses[keyframe.id] = keyframe.pose.T_map_base;
    if (!keyframe.heights) continue;
    OGRLayer& heights = impl_->Layer(tables::kHeights);
    impl_->Check(gdal, tables::Append(heights, keyframe.id, *keyframe.heights));
  }
  for (const graph::FramePose& frame : graph.trajectory) {
    impl_->Check(gdal, tables::Append(impl_->Layer(tables::kTrajectory), frame));
  }
  for (const graph::Edge& edge : graph.edges) {
    const auto from = poses.find(edge.from);
    const auto to = poses.find(edge.to);
    if (from == poses.end() || to == poses.end()) {
      throw InputError("edge " + std::to_string(edge.from) + " -> " + std::to_string(edge.to) +
                       ": the graph lacks its keyframes");
    }
    OGRLayer& edges = impl_->Layer(tables::kEdges);
    impl_->Check(gdal, tables::Append(edges, edge, from->second, to->second));
  }
  for (const graph::WeakSpot& spot : graph.weak_spots) {
    impl_->Check(gdal, tables::Append(impl_->Layer(tables::kWeakSpots), spot));
  }
  OGRLayer& metadata = impl_->Layer(tables::kMetadata);
  for (const auto& [key, value] : ToRows(graph.quality)) {
    impl_->Check(gdal, tables::Append(metadata, key, value));
  }
}

void MapWriter::WriteLeftOut(const std::vector<LeftOut>& places) {
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  for (const LeftOut& place : places) {
    impl_->Check(gdal, tables::Append(impl_->Layer(tables::kLeftOut), place));
  }
}

void MapWriter::WriteHistory(const MapHistory& history) {
  if (history.sessions.empty() && history.changes.empty()) return;
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  OGRSpatialReference srs = LocalSrs(impl_->metadata.unit);
  impl_->Check(gdal, impl_->dataset && tables::AddHistory(*impl_->dataset, srs, history));
}

void MapWriter::WriteMosaic(const MosaicGrid& grid,
                            const MosaicSource& source,
                            const std::function<void(int, int)>& progress) {
  if (grid.width_px == 0 || grid.height_px == 0) return;  // a map without a mosaic
  if (const std::string problem = Problem(grid); !problem.empty()) {
    throw RunError("cannot write " + impl_->file.Target().string() + ": " + problem);
  }
  {
    const GdalScope gdal;
    impl_->CloseDataset(gdal);
    impl_->GatherDescriptors();
    impl_->AddMosaicTable(gdal, grid);
    impl_->OpenDataset(gdal);
  }
  const std::vector<cv::Rect> windows = Windows(grid);
  const auto render = [&](std::size_t i) {
    return std::async(std::launch::async, [&, i] { return RenderWindow(source, windows[i]); });
  };
  std::future<RenderedWindow> next = render(0);
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const RenderedWindow rendered = next.get();
    if (i + 1 < windows.size()) next = render(i + 1);
    impl_->WriteTiles(windows[i], rendered);
    if (progress) progress(static_cast<int>(i + 1), static_cast<int>(windows.size()));
  }
  const std::vector<int> factors = OverviewFactors(grid);
  if (factors.empty()) return;
  const GdalScope gdal;
  impl_->Check(gdal,
               impl_->dataset->BuildOverviews("AVERAGE",
                                              static_cast<int>(factors.size()),
                                              factors.data(),
                                              0,
                                              nullptr,
                                              nullptr,
                                              nullptr,
                                              nullptr) == CE_None);
}

void MapWriter::Commit() {
  {
    const GdalScope gdal;
    impl_->Check(gdal, impl_->dataset != nullptr);
    impl_->CloseDataset(gdal);
  }
  impl_->file.Commit();
}

}  // namespace ceilmap::store
