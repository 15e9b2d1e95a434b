#include "mapping/store/site_plan.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "calib/base/error.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {
namespace {

constexpr int kMaxSidePx = 4096;
constexpr std::size_t kMaxVertices = 1'000'000;

/// The bands of an image as blue, green and red, reduced to the image's size.
void ReadBands(GDALDataset& dataset, cv::Mat& image) {
  const bool coloured = dataset.GetRasterCount() >= 3;
  GDALColorTable* palette = dataset.GetRasterBand(1)->GetColorTable();
  std::array<cv::Mat, 3> planes;
  for (int i = 0; i < 3; ++i) {
    cv::Mat& plane = planes.at(static_cast<std::size_t>(i));
    plane.create(image.size(), CV_8UC1);
    const CPLErr error = dataset.GetRasterBand(coloured ? 3 - i : 1)
                             ->RasterIO(GF_Read,
                                        0,
                                        0,
                                        dataset.GetRasterXSize(),
                                        dataset.GetRasterYSize(),
                                        plane.data,
                                        plane.cols,
                                        plane.rows,
                                        GDT_Byte,
                                        0,
                                        0,
                                        nullptr);
    if (error != CE_None) throw InputError("the image cannot be read");
    if (palette == nullptr || coloured) continue;
    cv::Mat table(1, 256, CV_8UC1, cv::Scalar(0));
    for (int k = 0; k < std::min(256, palette->GetColorEntryCount()); ++k) {
      const GDALColorEntry* colour = palette->GetColorEntry(k);
      const std::array<short, 3> values = {colour->c3, colour->c2, colour->c1};
      table.at<unsigned char>(k) =
          static_cast<unsigned char>(values.at(static_cast<std::size_t>(i)));
    }
    cv::LUT(plane, table, plane);
  }
  cv::merge(planes.data(), planes.size(), image);
}

SitePlan ReadImagePlan(GDALDataset& dataset) {
  SitePlan plan;
  if (dataset.GetGeoTransform(plan.transform.data()) != CE_None) {
    throw InputError(
        "the image has no position in the building; give a GeoTIFF, or put a world file beside the "
        "image (plan.pgw beside plan.png)");
  }
  const int side = std::max(dataset.GetRasterXSize(), dataset.GetRasterYSize());
  const double factor = std::max(1.0, static_cast<double>(side) / kMaxSidePx);
  const auto reduced = [&](int length) {
    return std::max(1, static_cast<int>(std::lround(length / factor)));
  };
  plan.image.create(reduced(dataset.GetRasterYSize()), reduced(dataset.GetRasterXSize()), CV_8UC3);
  const double per_col = static_cast<double>(dataset.GetRasterXSize()) / plan.image.cols;
  const double per_row = static_cast<double>(dataset.GetRasterYSize()) / plan.image.rows;
  for (const std::size_t i : {1, 4}) plan.transform.at(i) *= per_col;
  for (const std::size_t i : {2, 5}) plan.transform.at(i) *= per_row;
  ReadBands(dataset, plan.image);
  return plan;
}

void AddLines(const OGRGeometry& geometry, SitePlan& plan, std::size_t& vertices) {
  if (const auto* collection = dynamic_cast<const OGRGeometryCollection*>(&geometry)) {
    for (const OGRGeometry* part : *collection) AddLines(*part, plan, vertices);
    return;
  }
  if (const auto* polygon = dynamic_cast<const OGRPolygon*>(&geometry)) {
    for (const OGRLinearRing* ring : *polygon) AddLines(*ring, plan, vertices);
    return;
  }
  const auto* line = dynamic_cast<const OGRSimpleCurve*>(&geometry);
  if (line == nullptr) return;  // a point or a text
  vertices += static_cast<std::size_t>(line->getNumPoints());
  if (vertices > kMaxVertices) {
    throw InputError("the drawing has more than a million vertices; export the walls alone");
  }
  plan.lines.emplace_back();
  for (int i = 0; i < line->getNumPoints(); ++i) {
    plan.lines.back().emplace_back(line->getX(i), line->getY(i));
  }
}

SitePlan ReadDrawnPlan(GDALDataset& dataset) {
  SitePlan plan;
  std::size_t vertices = 0;
  for (OGRLayer* layer : dataset.GetLayers()) {
    for (const auto& feature : *layer) {
      const OGRGeometry* geometry = feature->GetGeometryRef();
      if (geometry == nullptr) continue;
      const OGRGeometryUniquePtr linear(geometry->getLinearGeometry());  // arcs become lines
      if (linear) AddLines(*linear, plan, vertices);
    }
  }
  if (plan.lines.empty()) throw InputError("the drawing has no lines");
  return plan;
}

}  // namespace

SitePlan ReadSitePlan(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(file.string() + ": no such file");
  }
  const GdalScope gdal;
  const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");
  const std::array<const char*, 6> drivers = {"GTiff", "PNG", "JPEG", "DXF", "GeoJSON", nullptr};
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(
      file.c_str(), GDAL_OF_RASTER | GDAL_OF_VECTOR, drivers.data(), nullptr, nullptr));
  if (!dataset) {
    throw InputError(file.string() +
                     ": is no plan; give a GeoTIFF, a PNG or JPEG image with a world file, a DXF "
                     "drawing, or GeoJSON");
  }
  try {
    return dataset->GetRasterCount() > 0 ? ReadImagePlan(*dataset) : ReadDrawnPlan(*dataset);
  } catch (const InputError& problem) {
    throw InputError(file.string() + ": " + problem.what());
  }
}

}  // namespace ceilmap::store
