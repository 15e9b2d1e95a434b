#include <gdal_priv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/integration/command_results.hpp"
#include "tests/integration/recordings.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

/// align, and results in the coordinates of the building.
namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::HasSubstr;
using testing::StartsWith;

/// The site's x axis is the map's y axis: x_site = 1000 - y, y_site = 2000 + x.
constexpr char kPoints[] =
    "name,x,y,site_x,site_y\n"
    "A,0,0,1000.002,2000\n"
    "B,3,0,1000,2003.001\n"
    "C,3,2,998,2002.999\n"
    "D,0,2,997.999,2000\n"
    "E,1,1,999.5,2001.8\n";  // a blunder

class Align : public testing::Test {
 protected:
  void SetUp() override {
    test_.out.Write("points.csv", kPoints);
    store::synthetic::SmallMap().Write(test_.out / "m.gpkg");
  }

  Recordings test_;
};

TEST_F(Align, PlacesTheMapAndNamesTheBlunder) {
  const support::ProcessResult result = test_.Run({"align",
                                                   "m.gpkg",
                                                   "--points=points.csv",
                                                   "--crs=EPSG:25832",
                                                   "--picture=m.svg",
                                                   "--summary=s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("point 'E' contradicts the others by 0.9"));
  EXPECT_THAT(result.out, HasSubstr("4 of 5"));
  EXPECT_THAT(result.out, HasSubstr("not used"));
  EXPECT_THAT(ReadAll(test_.out / "m.svg"), StartsWith("<svg"));

  const auto summary = nlohmann::json::parse(ReadAll(test_.out / "s.json"));
  EXPECT_EQ(summary["quality"]["used"], 4);
  const auto info = nlohmann::json::parse(test_.Run({"info", "m.gpkg", "--json"}).out);
  EXPECT_NEAR(info["site"]["S_site_map"]["x_m"].get<double>(), 1000, 0.003);
  EXPECT_NEAR(info["site"]["S_site_map"]["y_m"].get<double>(), 2000, 0.003);
  EXPECT_NEAR(info["site"]["S_site_map"]["yaw_deg"].get<double>(), 90, 0.05);
  EXPECT_EQ(info["site"]["points"].size(), 5U);
  EXPECT_THAT(test_.Run({"info", "m.gpkg"}).out, HasSubstr("ETRS89 / UTM zone 32N"));
}

TEST_F(Align, LeavesTheMapWhereAnotherResultIsNamed) {
  const std::string before = ReadAll(test_.out / "m.gpkg");
  EXPECT_EQ(test_.Run({"align", "m.gpkg", "--points=points.csv", "-o", "site.gpkg"}).exit_code, 0);
  EXPECT_EQ(ReadAll(test_.out / "m.gpkg"), before);
  EXPECT_TRUE(store::MapReader(test_.out / "site.gpkg").Metadata().site);
}

TEST_F(Align, TakesPixelsOfTheMosaic) {
  const store::MosaicGrid grid = store::MapReader(test_.out / "m.gpkg").Grid();
  std::string points = "name,col,row,site_x,site_y\n";
  for (const auto& [col, row] : {std::pair{0, 0}, {100, 0}, {0, 80}, {100, 80}}) {
    const Eigen::Vector2d p_map = store::PixelToMap(grid, Eigen::Vector2d(col, row));
    points += "P" + std::to_string(col + row) + "," + std::to_string(col) + "," +
              std::to_string(row) + "," + std::to_string(50 + p_map.x()) + "," +
              std::to_string(60 + p_map.y()) + "\n";
  }
  test_.out.Write("pixels.csv", points);
  EXPECT_EQ(test_.Run({"align", "m.gpkg", "--points=pixels.csv"}).exit_code, 0);
  const store::MapReader map(test_.out / "m.gpkg");
  EXPECT_NEAR(map.Metadata().site->S_site_map.motion.x, 50, 1e-4);
  EXPECT_NEAR(map.Metadata().site->S_site_map.motion.y, 60, 1e-4);
}

TEST_F(Align, ExportsLieInTheBuilding) {
  ASSERT_EQ(test_.Run({"align", "m.gpkg", "--points=points.csv", "--crs=EPSG:25832"}).exit_code, 0);
  ASSERT_EQ(
      test_.Run({"export", "m.gpkg", "--format=geotiff", "--frame=site", "-o", "m.tif"}).exit_code,
      0);
  GDALAllRegister();
  const GDALDatasetUniquePtr tiff(GDALDataset::Open((test_.out / "m.tif").c_str(), GDAL_OF_RASTER));
  std::array<double, 6> t{};
  ASSERT_EQ(tiff->GetGeoTransform(t.data()), CE_None);
  const store::MapReader map(test_.out / "m.gpkg");
  const store::MosaicGrid& grid = map.Grid();
  // The centre of pixel (7, 3), by the file and by hand.
  const Eigen::Vector2d p_map = store::PixelToMap(grid, {7, 3});
  EXPECT_NEAR(t[0] + 7.5 * t[1] + 3.5 * t[2], 1000 - p_map.y(), 0.004);
  EXPECT_NEAR(t[3] + 7.5 * t[4] + 3.5 * t[5], 2000 + p_map.x(), 0.004);
  EXPECT_EQ(std::string(tiff->GetSpatialRef()->GetName()), "ETRS89 / UTM zone 32N");

  ASSERT_EQ(
      test_.Run({"export", "m.gpkg", "--format=tum", "--frame=site", "-o", "s.tum"}).exit_code, 0);
  ASSERT_EQ(test_.Run({"export", "m.gpkg", "--format=tum", "-o", "m.tum"}).exit_code, 0);
  const std::vector<StampedPose> in_map = files::ReadTum(test_.out / "m.tum");
  const std::vector<StampedPose> in_site = files::ReadTum(test_.out / "s.tum");
  ASSERT_EQ(in_map.size(), in_site.size());
  for (std::size_t i = 0; i < in_map.size(); ++i) {
    EXPECT_NEAR(PlanarPose(in_site[i]).x, 1000 - PlanarPose(in_map[i]).y, 0.004);
    EXPECT_NEAR(PlanarPose(in_site[i]).y, 2000 + PlanarPose(in_map[i]).x, 0.004);
  }
  ASSERT_EQ(test_.Run({"export", "m.gpkg", "--format=ros", "--frame=site", "-o", "ros"}).exit_code,
            0);
  EXPECT_THAT(ReadAll(test_.out / "ros.yaml"), HasSubstr(", 1.57"));
}

TEST_F(Align, BadInputIsOneLine) {
  const auto expect = [this](std::vector<std::string> arguments, const char* text) {
    const support::ProcessResult result = test_.Run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(text));
    EXPECT_EQ(Lines(result.err).size(), 1U) << result.err;
  };
  test_.out.Write("one.csv", "name,x,y,site_x,site_y\nA,0,0,1,2\n");
  test_.out.Write("outside.csv", "name,col,row,site_x,site_y\nA,0,0,1,2\nB,99999,0,3,4\n");
  expect({"align", "m.gpkg", "--points=none.csv"}, "none.csv");
  expect({"align", "m.gpkg", "--points=one.csv"}, "one.csv: 1 point: at least two");
  expect({"align", "m.gpkg", "--points=outside.csv"}, "point 'B' lies outside the mosaic");
  expect({"align", "m.gpkg", "--points=points.csv", "--crs=EPSG:4326"}, "not projected");
  expect({"align", "m.gpkg", "--points=points.csv", "--sigma=0"}, "sigma_m = 0");
  expect({"align", "m.gpkg", "--points=points.csv", "--plan=p.png"}, "--picture");
  expect({"export", "m.gpkg", "--format=geotiff", "--frame=site", "-o", "m.tif"}, "ceilmap align");
  expect({"export", "m.gpkg", "--format=png", "--frame=site", "-o", "m.png"}, "geotiff");
}

TEST(LocalizeInSite, PosesAreThoseOfTheMapInTheBuilding) {
  const Recordings test;
  test.out.Write("points.csv", kPoints);
  ASSERT_EQ(
      test.Run({"map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"})
          .exit_code,
      0);
  ASSERT_EQ(test.Run({"align", "m.gpkg", "--points=points.csv"}).exit_code, 0);
  const auto localize = [&test](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"localize",
                                       "m.gpkg",
                                       "--up=@run.avi",
                                       "--stamps=@stamps.csv",
                                       "-o",
                                       name + ".tum",
                                       "--status=" + name + ".csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test.Run(arguments);
  };
  ASSERT_EQ(localize("map", {"--start=0,0,0"}).exit_code, 0);
  test.out.Write("plan.geojson",
                 R"({"type": "LineString", "coordinates": [[990, 1999], [1010, 1999]]})");
  const support::ProcessResult in_site = localize(
      "site", {"--frame=site", "--start=1000,2000,90", "--report=report", "--plan=plan.geojson"});
  EXPECT_EQ(in_site.exit_code, 0) << in_site.err;
  const files::StatusRecord map = files::ReadStatus(test.out / "map.csv");
  const files::StatusRecord site = files::ReadStatus(test.out / "site.csv");
  ASSERT_EQ(map.poses.size(), static_cast<std::size_t>(kFrames));
  ASSERT_EQ(site.poses.size(), map.poses.size());
  for (std::size_t i = 0; i < site.poses.size(); ++i) {
    const Pose2 a = PlanarPose(map.poses[i]);
    const Pose2 b = PlanarPose(site.poses[i]);
    EXPECT_NEAR(b.x, 1000 - a.y, 0.006);
    EXPECT_NEAR(b.y, 2000 + a.x, 0.006);
    EXPECT_NEAR(WrapAngle(b.yaw - a.yaw), 1.5708, 0.003);
    EXPECT_GT(site.covariances[i](0, 0), map.covariances[i](0, 0));
  }
  // The page has the same poses, over the plan.
  const nlohmann::json page = DocumentOf(test.out / "report/index.html");
  EXPECT_EQ(page["plan"]["lines"], nlohmann::json({{0, 0, 20'000, 0}}));
  EXPECT_NEAR(page["placement"]["x"].get<double>(), 1000, 0.003);
  const nlohmann::json& path = page["paths"][0];
  EXPECT_NEAR(1e-4 * path["x"].back().get<double>(), PlanarPose(site.poses.back()).x, 2e-4);
  EXPECT_NEAR(1e-4 * path["y"].back().get<double>(), PlanarPose(site.poses.back()).y, 2e-4);
  EXPECT_EQ(localize("bag", {"--frame=site", "-o", "t.mcap"}).exit_code, 2);
}

TEST(SolveWithPoints, PlacesOneMapAndNamesTheBlunder) {
  const Recordings test;
  test.out.Write("points.csv", kPoints);
  test.out.Write("far.csv", "name,x,y,site_x,site_y\nA,0,0,1,2\nB,90,0,91,2\n");
  ASSERT_EQ(
      test.Run({"map", "--rig=@rig.yaml", "--up=@run.avi", "--stamps=@stamps.csv", "-o", "m.gpkg"})
          .exit_code,
      0);
  const support::ProcessResult solved =
      test.Run({"solve", "m.gpkg", "--points=points.csv", "-o", "s.gpkg"});
  EXPECT_EQ(solved.exit_code, 0) << solved.err;
  EXPECT_THAT(solved.err, HasSubstr("point 'E' contradicts"));
  EXPECT_THAT(solved.out, HasSubstr("not used"));
  const store::MapReader before(test.out / "m.gpkg");
  const store::MapReader after(test.out / "s.gpkg");
  ASSERT_TRUE(after.Metadata().site);
  EXPECT_NEAR(after.Metadata().site->S_site_map.motion.x, 1000, 0.004);
  // A map that is right stays as it is: its images are more exact than the points.
  const std::vector<graph::Keyframe> a = before.ReadKeyframes();
  const std::vector<graph::Keyframe> b = after.ReadKeyframes();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a[i].pose.T_map_base.x, b[i].pose.T_map_base.x, 0.002);
    EXPECT_NEAR(a[i].pose.T_map_base.y, b[i].pose.T_map_base.y, 0.002);
  }
  const support::ProcessResult far =
      test.Run({"solve", "m.gpkg", "--points=far.csv", "-o", "x.gpkg"});
  EXPECT_EQ(far.exit_code, 2);
  EXPECT_THAT(far.err, HasSubstr("far.csv: point 'B' at 90.000, 0.000 lies outside the map"));
}

}  // namespace
}  // namespace ceilmap::integration
