// The mosaic of a map file, which is written and read by windows.

#include "mapping/store/map_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

using synthetic::Same;
using synthetic::SmallMap;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// The window is as synthetic::FillMosaic draws it.
void ExpectMosaic(const MapReader& reader, const cv::Rect& window) {
  cv::Mat grey;
  cv::Mat alpha;
  cv::Mat expected_grey;
  cv::Mat expected_alpha;
  reader.ReadMosaic(window, grey, alpha);
  synthetic::FillMosaic(window, expected_grey, expected_alpha);
  EXPECT_TRUE(Same(grey, expected_grey)) << window;
  EXPECT_TRUE(Same(alpha, expected_alpha)) << window;
}

TEST(MapMosaic, KeepsEachPixel) {
  const support::TempFolder folder;
  SmallMap().Write(folder / "map.gpkg");
  const MapReader reader(folder / "map.gpkg");
  const MosaicGrid& grid = reader.Grid();
  EXPECT_EQ(grid.min_x, synthetic::kGrid.min_x);
  EXPECT_EQ(grid.max_y, synthetic::kGrid.max_y);
  EXPECT_EQ(grid.resolution, synthetic::kGrid.resolution);
  EXPECT_EQ(grid.width_px, synthetic::kGrid.width_px);
  EXPECT_EQ(grid.height_px, synthetic::kGrid.height_px);

  for (const cv::Rect& window :
       {cv::Rect(0, 0, 700, 300), cv::Rect(250, 250, 300, 50), cv::Rect(0, 0, 1, 1)}) {
    ExpectMosaic(reader, window);
  }
  cv::Mat grey;
  cv::Mat alpha;
  EXPECT_THROW(reader.ReadMosaic({690, 0, 20, 20}, grey, alpha), InputError);
  EXPECT_THROW(reader.ReadMosaic({-1, 0, 20, 20}, grey, alpha), InputError);
  EXPECT_THROW(reader.ReadMosaic({0, 0, 0, 0}, grey, alpha), InputError);
}

TEST(MapMosaic, StoresMosaicOfManyWindowsAndReportsProgress) {
  const support::TempFolder folder;
  const MosaicGrid grid{-3.0, 2.0, 0.01, 2100, 1100};
  std::vector<int> done;
  {
    MapWriter writer(folder / "map.gpkg", SmallMap().metadata);
    writer.WriteMosaic(grid, synthetic::FillMosaic, [&](int count, int total) {
      EXPECT_EQ(total, 6);
      done.push_back(count);
    });
    writer.Commit();
  }
  EXPECT_THAT(done, ::testing::ElementsAre(1, 2, 3, 4, 5, 6));
  const MapReader reader(folder / "map.gpkg");
  ExpectMosaic(reader, {0, 0, 2100, 1100});
}

TEST(MapMosaic, UnmappedMosaicIsTransparent) {
  const support::TempFolder folder;
  {
    MapWriter writer(folder / "map.gpkg", SmallMap().metadata);
    writer.WriteMosaic({0, 0, 1, 300, 300}, [](const cv::Rect& window, cv::Mat& g, cv::Mat& a) {
      g = cv::Mat(window.size(), CV_8UC1, cv::Scalar(0));
      a = g.clone();
    });
    writer.Commit();
  }
  const MapReader reader(folder / "map.gpkg");
  cv::Mat grey;
  cv::Mat alpha;
  reader.ReadMosaic({0, 0, 300, 300}, grey, alpha);
  EXPECT_EQ(cv::countNonZero(alpha), 0);
}

TEST(MapMosaic, MapInPixelsWithoutMosaicOrFrames) {
  const support::TempFolder folder;
  MapMetadata metadata = SmallMap().metadata;
  metadata.unit = "px";
  {
    MapWriter writer(folder / "empty.gpkg", metadata);
    writer.WriteMosaic({0, 0, 1, 0, 0}, synthetic::FillMosaic);
    writer.Commit();
  }
  const MapReader reader(folder / "empty.gpkg");
  EXPECT_EQ(reader.Metadata().unit, "px");
  EXPECT_EQ(reader.Grid().width_px, 0);
  EXPECT_EQ(reader.Grid().height_px, 0);
  EXPECT_TRUE(reader.ReadKeyframes().empty());
  EXPECT_TRUE(reader.ReadTrajectory().empty());
  EXPECT_TRUE(reader.ReadEdges().empty());
  cv::Mat grey;
  cv::Mat alpha;
  EXPECT_THROW(reader.ReadMosaic({0, 0, 1, 1}, grey, alpha), InputError);
  EXPECT_THROW((void)reader.ReadImage(0), InputError);
}

TEST(MapMosaic, MosaicSourceMayThrow) {
  const support::TempFolder folder;
  MapWriter writer(folder / "map.gpkg", SmallMap().metadata);
  const auto write = [&] {
    writer.WriteMosaic({0, 0, 1, 3000, 100}, [](const cv::Rect& window, cv::Mat& g, cv::Mat& a) {
      if (window.x > 0) throw RunError("no image");
      synthetic::FillMosaic(window, g, a);
    });
  };
  EXPECT_THAT(write, ThrowsMessage<RunError>(HasSubstr("no image")));
}

TEST(MapMosaic, WriterReadsImagesBackWhileTheMosaicIsWritten) {
  const support::TempFolder folder;
  const SmallMap map;
  MapWriter writer(folder / "map.gpkg", map.metadata);
  for (const graph::Keyframe& keyframe : map.keyframes) {
    writer.AddImage(keyframe.id, synthetic::Image(keyframe.id, map.metadata.view_size));
    EXPECT_TRUE(
        Same(writer.ReadImage(keyframe.id), synthetic::Image(keyframe.id, map.metadata.view_size)));
  }
  int wrong = 0;
  writer.WriteMosaic({0, 0, 1, 2100, 1100},
                     [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
                       synthetic::FillMosaic(window, grey, alpha);
                       for (const graph::Keyframe& keyframe : map.keyframes) {
                         wrong += Same(writer.ReadImage(keyframe.id),
                                       synthetic::Image(keyframe.id, map.metadata.view_size))
                                      ? 0
                                      : 1;
                       }
                     });
  EXPECT_EQ(wrong, 0);
  EXPECT_THROW((void)writer.ReadImage(77), InputError);
  writer.Commit();
}

}  // namespace
}  // namespace ceilmap::store
