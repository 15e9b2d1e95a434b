#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <unordered_set>

#include "calib/base/error.hpp"
#include "mapping/store/attribute_tables.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/history_tables.hpp"
#include "mapping/store/image_codec.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_metadata.hpp"
#include "mapping/store/map_origin.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/site_tables.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

/// Maximum number of rows of a table in memory: the frames of a week at 30 a second.
constexpr std::size_t kMaxRows = 20'000'000;

GDALDatasetUniquePtr Open(const std::string& name,
                          unsigned kind,
                          const std::vector<const char*>& options) {
  const std::array<const char*, 2> drivers = {"GPKG", nullptr};
  return GDALDatasetUniquePtr(
      GDALDataset::Open(name.c_str(), kind, drivers.data(), options.data(), nullptr));
}

}  // namespace

struct MapReader::Impl {
  Impl(const fs::path& path, FileKind kind);

  [[noreturn]] void Throw(const std::string& what) const { origin.Throw(what); }
  void Check(const GdalScope& gdal) const {
    origin.CheckConnection();
    if (gdal.Failed()) Throw("the file is damaged (" + gdal.Message() + ")");
  }
  /// Runs `read` and adds the file's name to its errors.
  template <typename Read>
  auto Named(const Read& read) const {
    try {
      return read();
    } catch (const InputError& error) {
      Throw(error.what());
    }
  }
  OGRLayer& Layer(const char* table) const;
  [[nodiscard]] bool Has(const char* table) const;
  template <typename Row, typename Convert>
  std::vector<Row> ReadAll(const char* table, Convert convert) const;

  void AddHeights(std::vector<graph::Keyframe>& keyframes) const;

  void OpenTables();
  void OpenMosaic();

  MapOrigin origin;
  MapMetadata metadata;
  graph::MapQuality quality;
  MosaicGrid grid;
  mutable std::mutex mutex;  // GDAL datasets are not thread-safe
  GDALDatasetUniquePtr database;
  GDALDatasetUniquePtr mosaic;  // null: the map has none
};

MapReader::Impl::Impl(const fs::path& path, FileKind kind) : origin(path) {
  OpenTables();
  if (kind == FileKind::kMap && metadata.part) {
    Throw("is a part of a mosaic; 'ceilmap mosaic MAP --assemble' makes a map of all parts");
  }
  if (kind == FileKind::kMosaicPart && !metadata.part) {
    Throw("is a map; give files of 'ceilmap mosaic MAP --part'");
  }
  OpenMosaic();
  // Each dataset was opened by name: they must not be of two different files. On a server all that
  // is read is of one version.
  if (!origin.IsRemote()) origin.CheckCurrent();
}

void MapReader::Impl::OpenTables() {
  const GdalScope gdal;
  database = Open(origin.Name(), GDAL_OF_VECTOR, {"LIST_ALL_TABLES=NO", nullptr});
  if (!database) Throw("cannot be read as a GeoPackage (" + gdal.Message() + ")");
  if (!Has(tables::kMetadata)) {
    Throw("is a GeoPackage but no ceilmap map; give one made by 'ceilmap map'");
  }
  std::map<std::string, std::string> rows;
  for (const auto& row : Layer(tables::kMetadata)) {
    const int key = row->GetFieldIndex(tables::kKey);
    const int value = row->GetFieldIndex(tables::kValue);
    if (key >= 0 && value >= 0) rows[row->GetFieldAsString(key)] = row->GetFieldAsString(value);
  }
  Check(gdal);
  metadata = Named([&] { return FromRows(rows); });
  // A map without a graph has no quality either.
  if (rows.contains("loops_compared")) quality = Named([&] { return QualityFromRows(rows); });
  for (const char* table : {tables::kKeyframes,
                            tables::kTrajectory,
                            tables::kEdges,
                            tables::kWeakSpots,
                            tables::kDescriptors,
                            tables::kMask,
                            tables::kImages}) {
    Layer(table);
  }
  if (Layer(tables::kMask).GetFeatureCount() > 0) {
    metadata.view_mask = Named(
        [&] { return DecodeImage(tables::ReadPng(Layer(tables::kMask), 0), metadata.view_size); });
  }
  if (metadata.site) {
    metadata.site->points =
        ReadAll<survey::AlignedPoint>(tables::kControlPoints, tables::ToAlignedPoint);
  }
  Check(gdal);
}

void MapReader::Impl::OpenMosaic() {
  const GdalScope gdal;
  OGRLayer* found = database->ExecuteSQL(
      "SELECT 1 FROM gpkg_contents WHERE table_name = 'mosaic' AND data_type = 'tiles'",
      nullptr,
      nullptr);
  const bool has_mosaic = found != nullptr && OGRFeatureUniquePtr(found->GetNextFeature());
  database->ReleaseResultSet(found);
  Check(gdal);
  if (!has_mosaic) return;

  mosaic = Open(origin.Name(), GDAL_OF_RASTER, {"TABLE=mosaic", "BAND_COUNT=2", nullptr});
  std::array<double, 6> transform{};
  if (!mosaic || mosaic->GetRasterCount() != 2 ||
      mosaic->GetGeoTransform(transform.data()) != CE_None) {
    Throw("the mosaic cannot be read (" + gdal.Message() + "); the file is damaged");
  }
  Check(gdal);
  grid.min_x = transform[0];
  grid.max_y = transform[3];
  grid.resolution = transform[1];
  grid.width_px = mosaic->GetRasterXSize();
  grid.height_px = mosaic->GetRasterYSize();
  if (const std::string problem = Problem(grid); !problem.empty() || transform[2] != 0 ||
                                                 transform[4] != 0 ||
                                                 transform[5] != -grid.resolution) {
    Throw("the mosaic's size or position is impossible; the file is damaged");
  }
}

bool MapReader::Impl::Has(const char* table) const {
  const bool found = database->GetLayerByName(table) != nullptr;
  origin.CheckConnection();
  return found;
}

OGRLayer& MapReader::Impl::Layer(const char* table) const {
  OGRLayer* layer = database->GetLayerByName(table);
  if (layer == nullptr) Throw(std::string("has no table ") + table + "; the file is damaged");
  return *layer;
}

template <typename Row, typename Convert>
std::vector<Row> MapReader::Impl::ReadAll(const char* table, Convert convert) const {
  const std::lock_guard lock(mutex);
  const GdalScope gdal;
  std::vector<Row> rows;
  Named([&] {
    for (const auto& row : Layer(table)) {
      if (rows.size() == kMaxRows) {
        throw InputError(std::string("table ") + table + " has more than " +
                         std::to_string(kMaxRows) + " rows; the file is damaged");
      }
      rows.push_back(convert(*row));
    }
  });
  Check(gdal);
  return rows;
}

/// @param keyframes  by id.
void MapReader::Impl::AddHeights(std::vector<graph::Keyframe>& keyframes) const {
  {
    const std::lock_guard lock(mutex);
    const GdalScope gdal;
    if (!Has(tables::kHeights)) return;
  }
  using Row = std::pair<std::int64_t, std::shared_ptr<const heights::HeightField>>;
  for (Row& row : ReadAll<Row>(tables::kHeights, tables::ToHeights)) {
    const auto found = std::lower_bound(
        keyframes.begin(),
        keyframes.end(),
        row.first,
        [](const graph::Keyframe& keyframe, std::int64_t id) { return keyframe.id < id; });
    if (found == keyframes.end() || found->id != row.first) {
      Throw("table " + std::string(tables::kHeights) + ": keyframe " + std::to_string(row.first) +
            " is missing; the file is damaged");
    }
    found->heights = std::move(row.second);
  }
}

MapReader::MapReader(const fs::path& file, FileKind kind)
    : impl_(std::make_unique<Impl>(file, kind)) {}
MapReader::~MapReader() {
  const GdalScope gdal;
  impl_.reset();
}

void MapReader::CheckCurrent() const {
  impl_->origin.CheckCurrent();
}

bool MapReader::IsRemote() const {
  return impl_->origin.IsRemote();
}

std::uint64_t MapReader::FileBytes() const {
  return impl_->origin.FileBytes();
}

const MapMetadata& MapReader::Metadata() const {
  return impl_->metadata;
}
const MosaicGrid& MapReader::Grid() const {
  return impl_->grid;
}

std::vector<graph::Keyframe> MapReader::ReadKeyframes() const {
  auto keyframes = impl_->ReadAll<graph::Keyframe>(tables::kKeyframes, tables::ToKeyframe);
  std::sort(keyframes.begin(),
            keyframes.end(),
            [](const graph::Keyframe& a, const graph::Keyframe& b) { return a.id < b.id; });
  impl_->AddHeights(keyframes);
  return keyframes;
}

bool MapReader::HasHeights() const {
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  return impl_->Has(tables::kHeights) && impl_->Layer(tables::kHeights).GetFeatureCount() > 0;
}

std::vector<graph::FramePose> MapReader::ReadTrajectory() const {
  return impl_->ReadAll<graph::FramePose>(tables::kTrajectory, tables::ToFramePose);
}

std::vector<graph::Edge> MapReader::ReadEdges() const {
  return impl_->ReadAll<graph::Edge>(tables::kEdges, tables::ToEdge);
}

std::vector<graph::WeakSpot> MapReader::ReadWeakSpots() const {
  return impl_->ReadAll<graph::WeakSpot>(tables::kWeakSpots, tables::ToWeakSpot);
}

std::vector<LeftOut> MapReader::ReadLeftOut() const {
  {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    if (!impl_->Has(tables::kLeftOut)) return {};
  }
  return impl_->ReadAll<LeftOut>(tables::kLeftOut, tables::ToLeftOut);
}

MapHistory MapReader::ReadHistory() const {
  {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    if (!impl_->Has(tables::kSessions) || !impl_->Has(tables::kChanges)) return {};
  }
  return {impl_->ReadAll<Session>(tables::kSessions, tables::ToSession),
          impl_->ReadAll<Change>(tables::kChanges, tables::ToChange),
          ReadLooks()};
}

std::vector<Look> MapReader::ReadLooks() const {
  {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    if (!impl_->Has(tables::kLooks)) return {};
  }
  const cv::Size mosaic(impl_->grid.width_px, impl_->grid.height_px);
  std::size_t count = 0;
  return impl_->ReadAll<Look>(tables::kLooks, [&](OGRFeature& row) {
    // A small PNG may hold a large image of one grey: each takes as much memory.
    if (++count > kMaxLooks) {
      throw InputError("table " + std::string(tables::kLooks) + " has more than " +
                       std::to_string(kMaxLooks) + " rows; the file is damaged");
    }
    return tables::ToLook(row, mosaic);
  });
}

const graph::MapQuality& MapReader::Quality() const {
  return impl_->quality;
}

graph::MapGraph MapReader::ReadGraph() const {
  graph::MapGraph graph;
  graph.keyframes = ReadKeyframes();
  graph.trajectory = ReadTrajectory();
  graph.edges = ReadEdges();
  graph.weak_spots = ReadWeakSpots();
  graph.quality = Quality();
  std::unordered_set<std::int64_t> known;
  for (const graph::Keyframe& keyframe : graph.keyframes) known.insert(keyframe.id);
  const auto check = [&](std::int64_t id) {
    if (!known.contains(id)) {
      impl_->Throw("keyframe " + std::to_string(id) + " is missing; the file is damaged");
    }
  };
  for (const graph::FramePose& frame : graph.trajectory) check(frame.keyframe_id);
  for (const graph::WeakSpot& spot : graph.weak_spots) check(spot.keyframe_id);
  for (const graph::Edge& edge : graph.edges) {
    check(edge.from);
    check(edge.to);
  }
  return graph;
}

cv::Mat MapReader::ReadDescriptors(std::int64_t keyframe_id) const {
  return impl_->Named([&] {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    cv::Mat descriptors = tables::ReadDescriptors(impl_->Layer(tables::kDescriptors), keyframe_id);
    impl_->Check(gdal);
    return descriptors;
  });
}

std::vector<unsigned char> MapReader::ReadPng(std::int64_t keyframe_id) const {
  return impl_->Named([&] {
    const std::lock_guard lock(impl_->mutex);
    const GdalScope gdal;
    std::vector<unsigned char> png = tables::ReadPng(impl_->Layer(tables::kImages), keyframe_id);
    impl_->Check(gdal);
    return png;
  });
}

cv::Mat MapReader::ReadImage(std::int64_t keyframe_id) const {
  const std::vector<unsigned char> png = ReadPng(keyframe_id);
  return impl_->Named([&] { return DecodeImage(png, impl_->metadata.view_size); });
}

void MapReader::ReadMosaic(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const {
  const cv::Rect all(0, 0, impl_->grid.width_px, impl_->grid.height_px);
  if (window.empty() || (window & all) != window) {
    impl_->Throw("the window asked for lies outside the mosaic");
  }
  grey.create(window.size(), CV_8UC1);
  alpha.create(window.size(), CV_8UC1);
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  for (const auto& [band, image] : {std::pair{1, &grey}, std::pair{2, &alpha}}) {
    const CPLErr error =
        impl_->mosaic->GetRasterBand(band)->RasterIO(GF_Read,
                                                     window.x,
                                                     window.y,
                                                     window.width,
                                                     window.height,
                                                     image->data,
                                                     window.width,
                                                     window.height,
                                                     GDT_Byte,
                                                     1,
                                                     static_cast<GSpacing>(image->step),
                                                     nullptr);
    if (error != CE_None) impl_->Throw("the mosaic is damaged (" + gdal.Message() + ")");
  }
  impl_->Check(gdal);
}

MosaicGrid MapReader::ReadOverview(int max_px, cv::Mat& grey, cv::Mat& alpha) const {
  MosaicGrid grid = impl_->grid;
  const int side = std::max(grid.width_px, grid.height_px);
  int factor = 1;  // of a level of the pyramid
  while (side / factor > max_px && factor <= side) factor *= 2;
  grid.width_px /= factor;
  grid.height_px /= factor;
  grid.resolution *= factor;
  if (grid.width_px == 0 || grid.height_px == 0) {
    grey.release();
    alpha.release();
    grid.width_px = grid.height_px = 0;
    return grid;
  }
  grey.create(grid.height_px, grid.width_px, CV_8UC1);
  alpha.create(grid.height_px, grid.width_px, CV_8UC1);
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  const std::lock_guard lock(impl_->mutex);
  const GdalScope gdal;
  for (const auto& [band, image] : {std::pair{1, &grey}, std::pair{2, &alpha}}) {
    const CPLErr error =
        impl_->mosaic->GetRasterBand(band)->RasterIO(GF_Read,
                                                     0,
                                                     0,
                                                     grid.width_px * factor,
                                                     grid.height_px * factor,
                                                     image->data,
                                                     grid.width_px,
                                                     grid.height_px,
                                                     GDT_Byte,
                                                     1,
                                                     static_cast<GSpacing>(image->step),
                                                     &how);
    if (error != CE_None) impl_->Throw("the mosaic is damaged (" + gdal.Message() + ")");
  }
  impl_->Check(gdal);
  return grid;
}

}  // namespace ceilmap::store
