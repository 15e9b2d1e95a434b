#include "mapping/store/map_revision.hpp"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/parallel.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/store/attribute_tables.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/history_tables.hpp"
#include "mapping/store/image_codec.hpp"
#include "mapping/store/map_metadata.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/site_tables.hpp"
#include "mapping/store/table_layout.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

/// The bands of a level of the mosaic's pyramid: grey, alpha.
using Bands = std::array<GDALRasterBand*, 2>;

cv::Size SizeOf(const Bands& level) {
  return {level[0]->GetXSize(), level[0]->GetYSize()};
}

bool Transfer(GDALRWFlag direction, GDALRasterBand& band, const cv::Rect& window, cv::Mat& pixels) {
  return band.RasterIO(direction,
                       window.x,
                       window.y,
                       window.width,
                       window.height,
                       pixels.data,
                       window.width,
                       window.height,
                       GDT_Byte,
                       1,
                       static_cast<GSpacing>(pixels.step),
                       nullptr) == CE_None;
}

/// Means of 2 x 2 pixels, those of grey over what is not transparent.
void Halve(const cv::Mat& grey, const cv::Mat& alpha, cv::Mat& half_grey, cv::Mat& half_alpha) {
  for (int row = 0; row < half_grey.rows; ++row) {
    for (int col = 0; col < half_grey.cols; ++col) {
      const cv::Rect from = cv::Rect(2 * col, 2 * row, 2, 2) & cv::Rect({}, grey.size());
      int weight = 0;
      int sum = 0;
      for (int v = from.y; v < from.br().y; ++v) {
        for (int u = from.x; u < from.br().x; ++u) {
          const int opaque = alpha.ptr<unsigned char>(v)[u];
          weight += opaque;
          sum += opaque * grey.ptr<unsigned char>(v)[u];
        }
      }
      half_alpha.ptr<unsigned char>(row)[col] =
          cv::saturate_cast<unsigned char>(weight / static_cast<double>(from.area()));
      half_grey.ptr<unsigned char>(row)[col] =
          weight == 0 ? 0 : cv::saturate_cast<unsigned char>(sum / static_cast<double>(weight));
    }
  }
}

/// Rows whose keys the new ones replace.
bool RemoveRows(OGRLayer& metadata, bool site) {
  std::vector<GIntBig> old;
  for (const auto& row : metadata) {
    const int key = row->GetFieldIndex(tables::kKey);
    const std::string name = key >= 0 ? row->GetFieldAsString(key) : "";
    if (site ? name.starts_with(kSitePrefix) : name == kProvenanceKey) old.push_back(row->GetFID());
  }
  for (const GIntBig id : old) {
    if (metadata.DeleteFeature(id) != OGRERR_NONE) return false;
  }
  return true;
}

/// Removes a row, if there is one.
bool RemoveRow(OGRLayer& layer, std::int64_t id) {
  const OGRErr result = layer.DeleteFeature(id);
  return result == OGRERR_NONE || result == OGRERR_NON_EXISTING_FEATURE;
}

bool RemoveLayer(GDALDataset& dataset, const char* name) {
  for (int i = 0; i < dataset.GetLayerCount(); ++i) {
    if (std::string(name) == dataset.GetLayer(i)->GetName()) {
      return dataset.DeleteLayer(i) == OGRERR_NONE;
    }
  }
  return true;
}

}  // namespace

struct MapRevision::Impl {
  Impl(const fs::path& map, const fs::path& output, const std::string& added)
      : file(output, {"-wal", "-shm", "-journal"}), reader(map), metadata(reader.Metadata()) {
    metadata.provenance += "\n" + added;
  }

  void Check(const GdalScope& gdal, bool succeeded) const {
    if (succeeded && !gdal.Failed()) return;
    throw RunError("cannot write " + file.Target().string() + ": " +
                   (gdal.Message().empty() ? "unknown GDAL error" : gdal.Message()));
  }
  void Copy(const fs::path& map);
  void OpenCopy();
  void ShrinkFile() const;
  OGRLayer& Layer(const char* name) const;
  void Run(const GdalScope& gdal, const std::string& sql) const;
  std::uint64_t Number(const GdalScope& gdal, const std::string& sql) const;
  [[nodiscard]] std::vector<Bands> Pyramid() const;

  AtomicFile file;
  MapReader reader;
  MapMetadata metadata;
  bool shrinks = false;
  GDALDatasetUniquePtr dataset;  // after `file`: closed before the partial file is removed
};

void MapRevision::Impl::Copy(const fs::path& map) {
  std::error_code error;
  fs::copy_file(map, file.PartialPath(), fs::copy_options::overwrite_existing, error);
  if (error) throw RunError("cannot write " + file.Target().string() + ": " + error.message());
  fs::permissions(
      file.PartialPath(), fs::perms::owner_write, fs::perm_options::add, error);  // of a copy
  reader.CheckCurrent();
}

void MapRevision::Impl::OpenCopy() {
  const GdalScope gdal;
  const FastSqlite fast;
  const bool has_mosaic = reader.Grid().width_px > 0;
  const std::array<const char*, 2> drivers = {"GPKG", nullptr};
  const std::array<const char*, 5> raster = {
      "TABLE=mosaic", "BAND_COUNT=2", "TILE_FORMAT=PNG", "ZLEVEL=1", nullptr};
  const unsigned int kinds = GDAL_OF_VECTOR | (has_mosaic ? GDAL_OF_RASTER : 0U);
  dataset.reset(GDALDataset::Open(file.PartialPath().c_str(),
                                  kinds | GDAL_OF_UPDATE,
                                  drivers.data(),
                                  has_mosaic ? raster.data() : nullptr,
                                  nullptr));
  Check(gdal, dataset && dataset->StartTransaction() == OGRERR_NONE);
}

OGRLayer& MapRevision::Impl::Layer(const char* name) const {
  OGRLayer* layer = dataset ? dataset->GetLayerByName(name) : nullptr;
  if (layer == nullptr) {
    throw RunError("cannot write " + file.Target().string() + ": no table " + name);
  }
  return *layer;
}

/// A statement without a result.
void MapRevision::Impl::Run(const GdalScope& gdal, const std::string& sql) const {
  OGRLayer* result = dataset->ExecuteSQL(sql.c_str(), nullptr, nullptr);
  if (result != nullptr) dataset->ReleaseResultSet(result);
  Check(gdal, true);
}

/// The only value that a statement results in.
std::uint64_t MapRevision::Impl::Number(const GdalScope& gdal, const std::string& sql) const {
  OGRLayer* result = dataset->ExecuteSQL(sql.c_str(), nullptr, nullptr);
  Check(gdal, result != nullptr);
  const OGRFeatureUniquePtr row(result->GetNextFeature());
  const std::int64_t value = row == nullptr ? -1 : row->GetFieldAsInteger64(0);
  dataset->ReleaseResultSet(result);
  Check(gdal, value >= 0);
  return static_cast<std::uint64_t>(value);
}

void MapRevision::Impl::ShrinkFile() const {
  try {
    ShrinkDatabase(file.PartialPath());
  } catch (const RunError& error) {
    throw RunError("cannot write " + file.Target().string() + ": " + error.what());
  }
}

/// The mosaic, then its reductions.
std::vector<Bands> MapRevision::Impl::Pyramid() const {
  const Bands whole = {dataset->GetRasterBand(1), dataset->GetRasterBand(2)};
  std::vector<Bands> levels{whole};
  for (int i = 0; i < whole[0]->GetOverviewCount(); ++i) {
    levels.push_back({whole[0]->GetOverview(i), whole[1]->GetOverview(i)});
  }
  return levels;
}

MapRevision::MapRevision(const fs::path& map,
                         const fs::path& output,
                         const std::string& provenance) {
  if (output.extension() != ".gpkg") {
    throw InputError(output.string() + ": a map file's name must end in .gpkg");
  }
  if (IsRemoteName(map.string())) {
    throw InputError(WithoutSecrets(map.string()) + ": is on a server; download it to change it");
  }
  impl_ = std::make_unique<Impl>(map, output, provenance);
  impl_->Copy(map);
  impl_->OpenCopy();
}

MapRevision::~MapRevision() {
  const GdalScope gdal;  // closing an unfinished file may report errors that no longer matter
  impl_.reset();
}

const MapReader& MapRevision::Map() const {
  return impl_->reader;
}

void MapRevision::WriteMosaic(const cv::Rect& window, const cv::Mat& grey, const cv::Mat& alpha) {
  const GdalScope gdal;
  const std::vector<Bands> levels = impl_->Pyramid();
  if (window.empty() || (window & cv::Rect({}, SizeOf(levels[0]))) != window) {
    throw InputError("the window to write lies outside the mosaic");
  }
  cv::Rect changed = window;
  cv::Mat pixels = grey;
  cv::Mat opaque = alpha;
  for (std::size_t i = 0;; ++i) {
    impl_->Check(gdal,
                 Transfer(GF_Write, *levels[i][0], changed, pixels) &&
                     Transfer(GF_Write, *levels[i][1], changed, opaque));
    if (i + 1 == levels.size()) break;
    // The pixels of the next level that depend on these.
    const cv::Rect next = cv::Rect(cv::Point(changed.x / 2, changed.y / 2),
                                   cv::Point((changed.br().x + 1) / 2, (changed.br().y + 1) / 2)) &
                          cv::Rect({}, SizeOf(levels[i + 1]));
    if (next.empty()) break;
    const cv::Rect from = cv::Rect(2 * next.tl(), 2 * next.br()) & cv::Rect({}, SizeOf(levels[i]));
    cv::Mat whole(from.size(), CV_8UC1);
    cv::Mat whole_alpha(from.size(), CV_8UC1);
    impl_->Check(gdal,
                 Transfer(GF_Read, *levels[i][0], from, whole) &&
                     Transfer(GF_Read, *levels[i][1], from, whole_alpha));
    pixels.release();
    opaque.release();
    pixels.create(next.size(), CV_8UC1);
    opaque.create(next.size(), CV_8UC1);
    Halve(whole, whole_alpha, pixels, opaque);
    changed = next;
  }
}

void MapRevision::ReplaceImages(const std::vector<NewImage>& images, int threads) {
  for (const NewImage& to : images) {
    if (to.image.type() != CV_8UC1 || to.image.size() != impl_->metadata.view_size) {
      throw InputError("keyframe " + std::to_string(to.keyframe_id) +
                       ": the image must be 8 bit grey and of the view's size");
    }
  }
  std::vector<std::vector<unsigned char>> encoded(images.size());
  ParallelFor(static_cast<int>(images.size()), threads, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    encoded[k] = EncodeImage(images[k].image);
  });
  const GdalScope gdal;
  OGRLayer& pictures = impl_->Layer(tables::kImages);
  OGRLayer& described = impl_->Layer(tables::kDescriptors);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::int64_t id = images[i].keyframe_id;
    impl_->Check(gdal,
                 RemoveRow(pictures, id) && RemoveRow(described, id) &&
                     tables::Append(pictures, id, encoded[i]) &&
                     tables::Append(described, id, images[i].descriptors));
  }
}

void MapRevision::SetHistory(const MapHistory& history) {
  const GdalScope gdal;
  GDALDataset& dataset = *impl_->dataset;
  impl_->Check(gdal,
               RemoveLayer(dataset, tables::kSessions) && RemoveLayer(dataset, tables::kChanges) &&
                   RemoveLayer(dataset, tables::kLooks));
  OGRSpatialReference srs = LocalSrs(impl_->metadata.unit);
  impl_->Check(gdal, tables::AddHistory(dataset, srs, history));
}

std::uint64_t MapRevision::UsedBytes() const {
  const GdalScope gdal;
  return (impl_->Number(gdal, "PRAGMA page_count") - impl_->Number(gdal, "PRAGMA freelist_count")) *
         impl_->Number(gdal, "PRAGMA page_size");
}

void MapRevision::RemoveKeyframe(std::int64_t id, std::int64_t heir) {
  const GdalScope gdal;
  impl_->Check(gdal, impl_->Layer(tables::kKeyframes).DeleteFeature(id) == OGRERR_NONE);
  for (const char* table : tables::kOfKeyframes) {
    OGRLayer* layer = impl_->dataset->GetLayerByName(table);
    impl_->Check(gdal, layer == nullptr || RemoveRow(*layer, id));
  }
  // In SQL, so that the other columns keep their bits.
  for (const char* table : {tables::kTrajectory, tables::kWeakSpots}) {
    impl_->Run(gdal,
               "UPDATE " + std::string(table) + " SET keyframe_id = " + std::to_string(heir) +
                   " WHERE keyframe_id = " + std::to_string(id));
  }
}

void MapRevision::SetEdges(const std::vector<graph::Edge>& edges) {
  const GdalScope gdal;
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : impl_->reader.ReadKeyframes()) {
    poses[keyframe.id] = keyframe.pose.T_map_base;
  }
  OGRLayer& layer = impl_->Layer(tables::kEdges);
  std::vector<GIntBig> old;
  for (const auto& row : layer) old.push_back(row->GetFID());
  for (const GIntBig id : old) impl_->Check(gdal, layer.DeleteFeature(id) == OGRERR_NONE);
  for (const graph::Edge& edge : edges) {
    impl_->Check(gdal, tables::Append(layer, edge, poses.at(edge.from), poses.at(edge.to)));
  }
}

void MapRevision::Shrink() {
  impl_->shrinks = true;
}

void MapRevision::SetSiteFrame(const survey::SiteFrame& site) {
  impl_->metadata.site = site;
  if (const std::string problem = Problem(impl_->metadata); !problem.empty()) {
    throw InputError(problem);
  }
  const GdalScope gdal;
  OGRLayer& rows = impl_->Layer(tables::kMetadata);
  impl_->Check(gdal, RemoveRows(rows, true));
  for (const auto& [key, value] : ToRows(site)) {
    impl_->Check(gdal, tables::Append(rows, key, value));
  }
  impl_->Check(gdal, RemoveLayer(*impl_->dataset, tables::kControlPoints));
  OGRSpatialReference srs = LocalSrs(impl_->metadata.unit);
  OGRLayer* points = tables::CreateControlPoints(*impl_->dataset, srs);
  impl_->Check(gdal, points != nullptr);
  for (const survey::AlignedPoint& point : site.points) {
    impl_->Check(gdal, tables::Append(*points, point));
  }
}

void MapRevision::Commit() {
  {
    const GdalScope gdal;
    OGRLayer& rows = impl_->Layer(tables::kMetadata);
    impl_->Check(gdal,
                 RemoveRows(rows, false) &&
                     tables::Append(rows, kProvenanceKey, impl_->metadata.provenance) &&
                     impl_->dataset->CommitTransaction() == OGRERR_NONE);
    impl_->dataset.reset();
    impl_->Check(gdal, true);
  }
  if (impl_->shrinks) impl_->ShrinkFile();
  impl_->reader.CheckCurrent();
  impl_->file.Commit();
}

}  // namespace ceilmap::store
