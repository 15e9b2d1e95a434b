#include "mapping/store/export.hpp"

#include <gdal_priv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "calib/base/error.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;
using synthetic::kGrid;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
    GDALAllRegister();
    synthetic::SmallMap().Write(folder_ / "map.gpkg");
  }

  static GDALDatasetUniquePtr Open(const fs::path& file) {
    return GDALDatasetUniquePtr(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER));
  }

  static cv::Mat Pixels(GDALRasterBand& band) {
    cv::Mat pixels(band.GetYSize(), band.GetXSize(), CV_8UC1);
    const CPLErr error = band.RasterIO(GF_Read,
                                       0,
                                       0,
                                       pixels.cols,
                                       pixels.rows,
                                       pixels.data,
                                       pixels.cols,
                                       pixels.rows,
                                       GDT_Byte,
                                       0,
                                       0,
                                       nullptr);
    EXPECT_EQ(error, CE_None);
    return pixels;
  }

  static void ExpectMosaic(GDALDataset& dataset, bool flipped = false) {
    ASSERT_EQ(dataset.GetRasterXSize(), kGrid.width_px);
    ASSERT_EQ(dataset.GetRasterYSize(), kGrid.height_px);
    ASSERT_EQ(dataset.GetRasterCount(), 2);
    EXPECT_EQ(dataset.GetRasterBand(2)->GetColorInterpretation(), GCI_AlphaBand);
    std::array<cv::Mat, 2> expected;
    synthetic::FillMosaic({0, 0, kGrid.width_px, kGrid.height_px}, expected[0], expected[1]);
    for (int band = 1; band <= 2; ++band) {
      cv::Mat& image = expected[static_cast<std::size_t>(band) - 1];
      if (flipped) cv::flip(image, image, 1);
      EXPECT_EQ(cv::norm(Pixels(*dataset.GetRasterBand(band)), image, cv::NORM_INF), 0)
          << "band " << band;
    }
  }

  support::TempFolder folder_;
};

/// A ramp across a raster; nothing is known in its first column.
void FillHeights(const cv::Rect& window, cv::Mat& metres) {
  metres.create(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    for (int col = 0; col < window.width; ++col) {
      const int x = col + window.x;
      metres.at<float>(row, col) =
          x == 0 ? std::nanf("") : 3 + 1e-3F * static_cast<float>(x + 10 * (row + window.y));
    }
  }
}

TEST_F(Export, CloudOptimizedGeoTiffBeginsWithItsDirectories) {
  const MapReader map(folder_ / "map.gpkg");
  ExportCog(map, folder_ / "map.tif");
  const auto cog = Open(folder_ / "map.tif");
  ASSERT_NE(cog, nullptr);
  ExpectMosaic(*cog);
  EXPECT_STREQ(cog->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  std::array<double, 6> transform{};
  ASSERT_EQ(cog->GetGeoTransform(transform.data()), CE_None);
  EXPECT_EQ(transform, (std::array<double, 6>{-1.25, 0.005, 0, 3.5, 0, -0.005}));
  // The directories in order of falling size, and before all pixels, whose order is the opposite:
  // the rules of GDAL's validate_cloud_optimized_geotiff.py.
  const auto at = [](GDALRasterBand& band, const char* item) {
    const char* const text = band.GetMetadataItem(item, "TIFF");
    EXPECT_NE(text, nullptr) << item;
    return text == nullptr ? 0 : std::stoll(text);
  };
  GDALRasterBand& band = *cog->GetRasterBand(1);
  ASSERT_EQ(band.GetOverviewCount(), 2) << "700 x 300, 350 x 150, 175 x 75";
  long long directory = at(band, "IFD_OFFSET");
  long long pixels = at(band, "BLOCK_OFFSET_0_0");
  EXPECT_LT(directory, 300);
  for (int i = 0; i < 2; ++i) {
    GDALRasterBand& overview = *band.GetOverview(i);
    EXPECT_GT(at(overview, "IFD_OFFSET"), directory);
    EXPECT_LT(at(overview, "BLOCK_OFFSET_0_0"), pixels);
    directory = at(overview, "IFD_OFFSET");
    pixels = at(overview, "BLOCK_OFFSET_0_0");
  }
  EXPECT_GT(pixels, directory);
  EXPECT_EQ(folder_.CountFiles(), 2U) << "no temporary file remains";
}

TEST_F(Export, Heights) {
  ExportHeights(kGrid, FillHeights, folder_ / "heights.tif");
  EXPECT_EQ(folder_.CountFiles(), 2U);
  const GDALDatasetUniquePtr tiff = Open(folder_ / "heights.tif");
  ASSERT_NE(tiff, nullptr);
  ASSERT_EQ(tiff->GetRasterCount(), 1);
  GDALRasterBand& band = *tiff->GetRasterBand(1);
  EXPECT_STREQ(band.GetDescription(), "heights");
  EXPECT_STREQ(band.GetUnitType(), "m");
  EXPECT_EQ(band.GetRasterDataType(), GDT_Float32);
  int has_no_data = 0;
  EXPECT_TRUE(std::isnan(band.GetNoDataValue(&has_no_data)));
  EXPECT_TRUE(has_no_data);
  EXPECT_GT(band.GetOverviewCount(), 0);
  std::array<double, 6> transform{};
  ASSERT_EQ(tiff->GetGeoTransform(transform.data()), CE_None);
  EXPECT_DOUBLE_EQ(transform[0], kGrid.min_x);
  EXPECT_DOUBLE_EQ(transform[1], kGrid.resolution);
  EXPECT_DOUBLE_EQ(transform[3], kGrid.max_y);
  EXPECT_DOUBLE_EQ(transform[5], -kGrid.resolution);
  EXPECT_NE(tiff->GetSpatialRef(), nullptr);
  cv::Mat expected;
  FillHeights({0, 0, kGrid.width_px, kGrid.height_px}, expected);
  cv::Mat read(band.GetYSize(), band.GetXSize(), CV_32FC1);
  ASSERT_EQ(read.size(), expected.size());
  ASSERT_EQ(band.RasterIO(GF_Read,
                          0,
                          0,
                          read.cols,
                          read.rows,
                          read.data,
                          read.cols,
                          read.rows,
                          GDT_Float32,
                          0,
                          0,
                          nullptr),
            CE_None);
  EXPECT_TRUE(std::isnan(read.at<float>(17, 0)));
  const cv::Rect known(1, 0, read.cols - 1, read.rows);
  EXPECT_EQ(cv::norm(read(known), expected(known), cv::NORM_INF), 0);
}

TEST_F(Export, HeightsThatCannotBeMadeLeaveNothing) {
  EXPECT_THROW(
      ExportHeights(
          kGrid,
          [](const cv::Rect& window, cv::Mat& metres) { metres.create(window.size(), CV_8UC1); },
          folder_ / "heights.tif"),
      RunError);
  EXPECT_EQ(folder_.CountFiles(), 1U);
}

TEST_F(Export, Png) {
  const MapReader map(folder_ / "map.gpkg");
  ExportPng(map, folder_ / "map.png");
  ExpectMosaic(*Open(folder_ / "map.png"));
  ExportPng(map, folder_ / "map.png", {.seen_from_below = true});
  ExpectMosaic(*Open(folder_ / "map.png"), true);
  EXPECT_EQ(folder_.CountFiles(), 2U);
}

TEST_F(Export, GeoTiff) {
  ExportGeoTiff(MapReader(folder_ / "map.gpkg"), folder_ / "map.tif");
  EXPECT_EQ(folder_.CountFiles(), 2U);
  const GDALDatasetUniquePtr tiff = Open(folder_ / "map.tif");
  ASSERT_NE(tiff, nullptr);
  ExpectMosaic(*tiff);
  std::array<double, 6> transform{};
  ASSERT_EQ(tiff->GetGeoTransform(transform.data()), CE_None);
  EXPECT_DOUBLE_EQ(transform[0], kGrid.min_x);
  EXPECT_DOUBLE_EQ(transform[1], kGrid.resolution);
  EXPECT_DOUBLE_EQ(transform[3], kGrid.max_y);
  EXPECT_DOUBLE_EQ(transform[5], -kGrid.resolution);
  EXPECT_EQ(tiff->GetRasterBand(1)->GetOverviewCount(), 2);
  int block_x = 0;
  int block_y = 0;
  tiff->GetRasterBand(1)->GetBlockSize(&block_x, &block_y);
  EXPECT_EQ(block_x, 256);
  EXPECT_EQ(block_y, 256);
  const OGRSpatialReference* srs = tiff->GetSpatialRef();
  ASSERT_NE(srs, nullptr);
  EXPECT_TRUE(srs->IsLocal());
  EXPECT_EQ(srs->GetLinearUnits(), 1);
}

TEST_F(Export, PyramidOfTheMapKeepsGreyAtItsBorder) {
  // An even grey with a hole: averaging must not mix in the grey 0 of what was never seen.
  {
    MapWriter writer(folder_ / "even.gpkg", synthetic::SmallMap().metadata);
    writer.WriteMosaic({0, 0, 1, 700, 600}, [](const cv::Rect& window, cv::Mat& g, cv::Mat& a) {
      g = cv::Mat(window.size(), CV_8UC1, cv::Scalar(200));
      a = cv::Mat(window.size(), CV_8UC1, cv::Scalar(255));
      const cv::Rect hole(101, 103, 77, 55);
      g(hole).setTo(0);
      a(hole).setTo(0);
    });
    writer.Commit();
  }
  ExportGeoTiff(MapReader(folder_ / "even.gpkg"), folder_ / "even.tif");
  const std::array<const char*, 2> two_bands = {"BAND_COUNT=2", nullptr};
  const GDALDatasetUniquePtr gpkg(GDALDataset::Open(
      (folder_ / "even.gpkg").c_str(), GDAL_OF_RASTER, nullptr, two_bands.data(), nullptr));
  const GDALDatasetUniquePtr tiff = Open(folder_ / "even.tif");
  for (GDALDataset* dataset : {gpkg.get(), tiff.get()}) {
    ASSERT_NE(dataset, nullptr);
    ASSERT_EQ(dataset->GetRasterBand(1)->GetOverviewCount(), 2);
    for (int level = 0; level < 2; ++level) {
      const cv::Mat grey = Pixels(*dataset->GetRasterBand(1)->GetOverview(level));
      const cv::Mat alpha = Pixels(*dataset->GetRasterBand(2)->GetOverview(level));
      EXPECT_GT(cv::countNonZero(alpha == 0), 0);
      EXPECT_EQ(cv::countNonZero((alpha != 0) & (grey != 200)), 0) << "level " << level;
    }
  }
}

TEST_F(Export, Ros) {
  const MapReader map(folder_ / "map.gpkg");
  for (const char* name : {"site", "site.yaml"}) {
    ExportRos(map, folder_ / name);
    std::ostringstream text;
    text << std::ifstream(folder_ / "site.yaml").rdbuf();
    EXPECT_EQ(text.str(),
              "image: site.png\n"
              "mode: scale\n"
              "resolution: 0.005\n"
              "origin: [-1.25, 2, 0]\n"
              "negate: 0\n"
              "occupied_thresh: 0.65\n"
              "free_thresh: 0.196\n");
    ExpectMosaic(*Open(folder_ / "site.png"));
    EXPECT_EQ(folder_.CountFiles(), 3U);
  }
}

TEST_F(Export, RosNeedsMetres) {
  MapMetadata metadata = synthetic::SmallMap().metadata;
  metadata.unit = "px";
  {
    MapWriter writer(folder_ / "px.gpkg", metadata);
    writer.WriteMosaic({0, 0, 1, 30, 30}, synthetic::FillMosaic);
    writer.Commit();
  }
  const MapReader map(folder_ / "px.gpkg");
  EXPECT_THAT([&] { ExportRos(map, folder_ / "site"); },
              ThrowsMessage<InputError>(HasSubstr("no metres")));
  ExportGeoTiff(map, folder_ / "px.tif");
  EXPECT_TRUE(Open(folder_ / "px.tif")->GetSpatialRef()->IsLocal());
}

TEST_F(Export, UnusableTargetsAndMaps) {
  const MapReader map(folder_ / "map.gpkg");
  const fs::path missing = folder_ / "none/out";
  EXPECT_THROW(ExportPng(map, missing), InputError);
  EXPECT_THROW(ExportGeoTiff(map, missing), InputError);
  EXPECT_THROW(ExportRos(map, missing), InputError);
  {
    MapWriter writer(folder_ / "empty.gpkg", map.Metadata());
    writer.Commit();
  }
  const MapReader empty(folder_ / "empty.gpkg");
  EXPECT_THROW(ExportPng(empty, folder_ / "x.png"), InputError);
  EXPECT_THROW(ExportGeoTiff(empty, folder_ / "x.tif"), InputError);
  EXPECT_THROW(ExportRos(empty, folder_ / "x"), InputError);
  EXPECT_EQ(folder_.CountFiles(), 2U);
}

}  // namespace
}  // namespace ceilmap::store
