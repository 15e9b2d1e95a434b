#include "mapping/store/export.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

constexpr int kTilePx = 256;

void Check(const GdalScope& gdal, bool succeeded, const fs::path& file) {
  if (succeeded && !gdal.Failed()) return;
  throw RunError("cannot write " + file.string() + ": " +
                 (gdal.Message().empty() ? "unknown GDAL error" : gdal.Message()));
}

GDALDriver& Driver(const char* name) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(name);
  if (driver == nullptr) {
    throw RunError(std::string("this GDAL has no driver for ") + name);
  }
  return *driver;
}

void CheckHasMosaic(const MapReader& map) {
  if (map.Grid().width_px == 0) {
    throw InputError("the map holds no mosaic, so there is no image to export");
  }
}

/// Grey and alpha, interleaved (CV_8UC2).
cv::Mat ReadWindow(const MapReader& map, const cv::Rect& window) {
  std::array<cv::Mat, 2> bands;
  map.ReadMosaic(window, bands[0], bands[1]);
  cv::Mat pixels;
  cv::merge(bands.data(), bands.size(), pixels);
  return pixels;
}

CPLErr WriteWindow(GDALDataset& dataset, const cv::Rect& window, cv::Mat& pixels) {
  return dataset.RasterIO(GF_Write,
                          window.x,
                          window.y,
                          window.width,
                          window.height,
                          pixels.data,
                          window.width,
                          window.height,
                          GDT_Byte,
                          2,
                          nullptr,
                          2,
                          static_cast<GSpacing>(pixels.step),
                          1,
                          nullptr);
}

CPLErr WriteHeights(GDALRasterBand& band, const cv::Rect& window, cv::Mat& metres) {
  return band.RasterIO(GF_Write,
                       window.x,
                       window.y,
                       window.width,
                       window.height,
                       metres.data,
                       window.width,
                       window.height,
                       GDT_Float32,
                       0,
                       static_cast<GSpacing>(metres.step),
                       nullptr);
}

CPLStringList TiffOptions() {
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BLOCKXSIZE", std::to_string(kTilePx).c_str());
  options.SetNameValue("BLOCKYSIZE", std::to_string(kTilePx).c_str());
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  return options;
}

/// GDAL's affine transform from pixels, counted from the corner of the first one, to coordinates.
std::array<double, 6> GeoTransform(const MosaicGrid& grid, const survey::SiteFrame* site) {
  const Similarity2 S = site != nullptr ? site->S_site_map : Similarity2{};
  const Eigen::Vector2d corner = S * Eigen::Vector2d(grid.min_x, grid.max_y);
  const Eigen::Matrix2d step = grid.resolution * S.scale * S.motion.Rotation();
  return {corner.x(), step(0, 0), -step(0, 1), corner.y(), step(1, 0), -step(1, 1)};
}

OGRSpatialReference SrsOf(const std::string& unit, const survey::SiteFrame* site) {
  if (site == nullptr) return LocalSrs(unit);
  if (site->crs_wkt.empty()) return LocalSrs("m");
  OGRSpatialReference srs;
  if (srs.importFromWkt(site->crs_wkt.c_str()) != OGRERR_NONE) {
    throw InputError(
        "the map's coordinate reference system cannot be read; run 'ceilmap align' again");
  }
  return srs;
}

/// Sets the dataset's position in the map or the site.
bool Place(GDALDataset& dataset,
           const MosaicGrid& grid,
           const std::string& unit,
           const survey::SiteFrame* site) {
  std::array<double, 6> transform = GeoTransform(grid, site);
  const OGRSpatialReference srs = SrsOf(unit, site);
  return dataset.SetSpatialRef(&srs) == CE_None &&
         dataset.SetGeoTransform(transform.data()) == CE_None;
}

/// Windows of one row of tiles each.
std::vector<cv::Rect> Strips(const MosaicGrid& grid) {
  std::vector<cv::Rect> strips;
  for (int y = 0; y < grid.height_px; y += kTilePx) {
    strips.emplace_back(0, y, grid.width_px, std::min(kTilePx, grid.height_px - y));
  }
  return strips;
}

/// The pyramid, until the whole image fits into one tile.
bool BuildOverviews(GDALDataset& dataset, const char* resampling) {
  std::vector<int> factors;
  const int side = std::max(dataset.GetRasterXSize(), dataset.GetRasterYSize());
  for (int factor = 2; side > factor / 2 * kTilePx; factor *= 2) factors.push_back(factor);
  return factors.empty() || dataset.BuildOverviews(resampling,
                                                   static_cast<int>(factors.size()),
                                                   factors.data(),
                                                   0,
                                                   nullptr,
                                                   nullptr,
                                                   nullptr,
                                                   nullptr) == CE_None;
}

/// Writes an image that is transparent in unmapped areas.
void WritePng(cv::Mat pixels, const AtomicFile& file) {
  const GdalScope gdal;
  const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");  // no .aux.xml beside the image
  const GDALDatasetUniquePtr memory(
      Driver("MEM").Create("", pixels.cols, pixels.rows, 2, GDT_Byte, nullptr));
  Check(gdal,
        memory && WriteWindow(*memory, cv::Rect({0, 0}, pixels.size()), pixels) == CE_None &&
            memory->GetRasterBand(2)->SetColorInterpretation(GCI_AlphaBand) == CE_None,
        file.Target());
  const GDALDatasetUniquePtr png(Driver("PNG").CreateCopy(
      file.PartialPath().c_str(), memory.get(), FALSE, nullptr, nullptr, nullptr));
  Check(gdal, png != nullptr, file.Target());
}

void WriteText(const std::string& text, const AtomicFile& file) {
  std::ofstream stream(file.PartialPath(), std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) throw RunError("cannot write " + file.Target().string() + ": disk full?");
}

/// Shortest text that gives the same value when it is read, with '.' in any locale. YAML readers
/// take "1" as an integer, but map_server expects a floating-point number; both forms are valid for
/// it.
std::string Number(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

}  // namespace

const survey::SiteFrame* SiteOf(const MapReader& map, Frame frame) {
  if (frame == Frame::kMap) return nullptr;
  if (!map.Metadata().site) {
    throw InputError(
        "the map has no coordinates of a building; run 'ceilmap align MAP.gpkg --points P.csv'");
  }
  return &*map.Metadata().site;
}

void ExportPng(const MapReader& map, const fs::path& file, const PngOptions& options) {
  CheckHasMosaic(map);
  AtomicFile target(file);
  cv::Mat pixels = ReadWindow(map, {0, 0, map.Grid().width_px, map.Grid().height_px});
  if (options.seen_from_below) cv::flip(pixels, pixels, 1);
  WritePng(pixels, target);
  target.Commit();
}

void ExportGeoTiff(const MapReader& map, const fs::path& file, Frame frame) {
  CheckHasMosaic(map);
  const survey::SiteFrame* site = SiteOf(map, frame);
  AtomicFile target(file);
  const MosaicGrid& grid = map.Grid();
  {
    const GdalScope gdal;
    const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");
    CPLStringList options = TiffOptions();
    options.SetNameValue("PREDICTOR", "2");
    options.SetNameValue("ALPHA", "YES");
    GDALDatasetUniquePtr tiff(Driver("GTiff").Create(
        target.PartialPath().c_str(), grid.width_px, grid.height_px, 2, GDT_Byte, options.List()));
    Check(gdal, tiff && Place(*tiff, grid, map.Metadata().unit, site), file);
    for (const cv::Rect& window : Strips(grid)) {
      cv::Mat pixels = ReadWindow(map, window);
      Check(gdal, WriteWindow(*tiff, window, pixels) == CE_None, file);
    }
    Check(gdal, BuildOverviews(*tiff, "AVERAGE"), file);
    tiff.reset();
    Check(gdal, true, file);
  }
  target.Commit();
}

void ExportHeights(const MosaicGrid& grid,
                   const HeightSource& source,
                   const fs::path& file,
                   const survey::SiteFrame* site) {
  if (const std::string problem = Problem(grid); !problem.empty()) throw InputError(problem);
  AtomicFile target(file);
  {
    const GdalScope gdal;
    const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");
    CPLStringList options = TiffOptions();
    options.SetNameValue("PREDICTOR", "3");
    GDALDatasetUniquePtr tiff(Driver("GTiff").Create(target.PartialPath().c_str(),
                                                     grid.width_px,
                                                     grid.height_px,
                                                     1,
                                                     GDT_Float32,
                                                     options.List()));
    Check(gdal, tiff && Place(*tiff, grid, "m", site), file);
    GDALRasterBand& band = *tiff->GetRasterBand(1);
    band.SetDescription("heights");
    Check(gdal,
          band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) == CE_None &&
              band.SetUnitType("m") == CE_None,
          file);
    for (const cv::Rect& window : Strips(grid)) {
      cv::Mat metres;
      source(window, metres);
      if (metres.size() != window.size() || metres.type() != CV_32FC1) {
        throw RunError("the source of the heights gave an image of another size or type");
      }
      Check(gdal, WriteHeights(band, window, metres) == CE_None, file);
    }
    // A mean of two surfaces would be the height of neither.
    Check(gdal, BuildOverviews(*tiff, "NEAREST"), file);
    tiff.reset();
    Check(gdal, true, file);
  }
  target.Commit();
}

void ExportRos(const MapReader& map, const fs::path& path, Frame frame) {
  CheckHasMosaic(map);
  const survey::SiteFrame* site = SiteOf(map, frame);
  if (map.Metadata().unit != "m" && site == nullptr) {
    throw InputError("a map in pixels has no metres, which ROS needs; make the map with a rig");
  }
  fs::path yaml = path;
  if (yaml.extension() != ".yaml") yaml += ".yaml";
  fs::path image = yaml;
  image.replace_extension(".png");
  AtomicFile yaml_file(yaml);
  AtomicFile image_file(image);

  const MosaicGrid& grid = map.Grid();
  WritePng(ReadWindow(map, {0, 0, grid.width_px, grid.height_px}), image_file);
  const Similarity2 S = site != nullptr ? site->S_site_map : Similarity2{};
  const Eigen::Vector2d corner =
      S * Eigen::Vector2d(grid.min_x, grid.max_y - grid.height_px * grid.resolution);
  WriteText("image: " + image.filename().string() +
                "\n"
                "mode: scale\n"
                "resolution: " +
                Number(S.scale * grid.resolution) +
                "\n"
                "origin: [" +
                Number(corner.x()) + ", " + Number(corner.y()) + ", " + Number(S.motion.yaw) +
                "]\n"
                "negate: 0\n"
                "occupied_thresh: 0.65\n"
                "free_thresh: 0.196\n",
            yaml_file);
  // The image first, so that the yaml file never names a missing image.
  image_file.Commit();
  yaml_file.Commit();
}

}  // namespace ceilmap::store
