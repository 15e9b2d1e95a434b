#include "mapping/store/site_update.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "calib/base/error.hpp"
#include "mapping/store/crs.hpp"
#include "mapping/store/site_plan.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

survey::SiteFrame ExampleSite() {
  survey::SiteFrame site;
  site.S_site_map = {{691'000.1, 5'335'000.7, -2.0 / 7}, 1.0 / 3};
  site.centre_map = {0.1, -0.2};
  site.sigma_position_m = 0.0031;
  site.sigma_yaw_rad = 0.00017;
  site.sigma_scale = 0.0002;
  site.crs_wkt = ParseCrs("EPSG:25832");
  survey::AlignedPoint point;
  point.point = {"column \"A\", 1", {0.5, 0.25}, {691'000.5, 5'335'001}, 0.004};
  point.residual_m = {0.001, -0.002};
  point.leave_one_out_m = 0.0042;
  site.points.push_back(point);
  point.point.name = "B";
  point.used = false;
  point.leave_one_out_m.reset();
  site.points.push_back(point);
  return site;
}

void ExpectEqual(const survey::SiteFrame& a, const survey::SiteFrame& b) {
  EXPECT_EQ(a.S_site_map.scale, b.S_site_map.scale);
  EXPECT_EQ(a.S_site_map.motion.x, b.S_site_map.motion.x);
  EXPECT_EQ(a.S_site_map.motion.y, b.S_site_map.motion.y);
  EXPECT_EQ(a.S_site_map.motion.yaw, b.S_site_map.motion.yaw);
  EXPECT_EQ(a.centre_map, b.centre_map);
  EXPECT_EQ(a.sigma_position_m, b.sigma_position_m);
  EXPECT_EQ(a.sigma_yaw_rad, b.sigma_yaw_rad);
  EXPECT_EQ(a.sigma_scale, b.sigma_scale);
  EXPECT_EQ(a.crs_wkt, b.crs_wkt);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].point.name, b.points[i].point.name);
    EXPECT_EQ(a.points[i].point.p_map, b.points[i].point.p_map);
    EXPECT_EQ(a.points[i].point.p_site, b.points[i].point.p_site);
    EXPECT_EQ(a.points[i].point.sigma_m, b.points[i].point.sigma_m);
    EXPECT_EQ(a.points[i].residual_m, b.points[i].residual_m);
    EXPECT_EQ(a.points[i].leave_one_out_m, b.points[i].leave_one_out_m);
    EXPECT_EQ(a.points[i].used, b.points[i].used);
  }
}

class SiteUpdate : public testing::Test {
 protected:
  void SetUp() override { synthetic::SmallMap().Write(folder_ / "map.gpkg"); }

  support::TempFolder folder_;
};

TEST_F(SiteUpdate, IsReadBackToTheLastBit) {
  WriteSiteFrame(folder_ / "map.gpkg", folder_ / "out.gpkg", ExampleSite(), "ceilmap align");
  const MapReader map(folder_ / "out.gpkg");
  ASSERT_TRUE(map.Metadata().site);
  ExpectEqual(*map.Metadata().site, ExampleSite());
  EXPECT_THAT(map.Metadata().provenance, HasSubstr("ceilmap map --up video.mp4\nceilmap align"));
  EXPECT_FALSE(MapReader(folder_ / "map.gpkg").Metadata().site);
}

TEST_F(SiteUpdate, LeavesTheRestOfTheMap) {
  const MapReader before(folder_ / "map.gpkg");
  WriteSiteFrame(folder_ / "map.gpkg", folder_ / "out.gpkg", ExampleSite(), "");
  const MapReader after(folder_ / "out.gpkg");
  const graph::MapGraph a = before.ReadGraph();
  const graph::MapGraph b = after.ReadGraph();
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  EXPECT_EQ(a.edges.size(), b.edges.size());
  EXPECT_EQ(a.trajectory.size(), b.trajectory.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(a.keyframes[i].pose.T_map_base.x, b.keyframes[i].pose.T_map_base.x);
    EXPECT_EQ(
        cv::norm(
            before.ReadImage(a.keyframes[i].id), after.ReadImage(a.keyframes[i].id), cv::NORM_INF),
        0);
  }
  EXPECT_EQ(before.Grid().width_px, after.Grid().width_px);
}

TEST_F(SiteUpdate, ReplacesAnEarlierAlignmentInPlace) {
  const auto map = folder_ / "map.gpkg";
  WriteSiteFrame(map, map, ExampleSite(), "first");
  survey::SiteFrame second = ExampleSite();
  second.crs_wkt.clear();
  second.S_site_map.scale = 1;
  second.points.pop_back();
  WriteSiteFrame(map, map, second, "second");
  ExpectEqual(*MapReader(map).Metadata().site, second);
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator((folder_ / "map.gpkg").parent_path())) {
    files += entry.is_regular_file() ? 1 : 0;
  }
  EXPECT_EQ(files, 1) << "no partial files and journals";
}

TEST_F(SiteUpdate, AMapWrittenWithASiteHasIt) {
  synthetic::SmallMap map;
  map.metadata.site = ExampleSite();
  map.Write(folder_ / "whole.gpkg");
  ExpectEqual(*MapReader(folder_ / "whole.gpkg").Metadata().site, ExampleSite());
}

TEST(Crs, KnowsCodesAndRefusesDegreesAndFeet) {
  EXPECT_EQ(NameOfCrs(ParseCrs("EPSG:25832")), "ETRS89 / UTM zone 32N");
  EXPECT_EQ(NameOfCrs(""), "local");
  EXPECT_THAT([] { ParseCrs("EPSG:4326"); }, ThrowsMessage<InputError>(HasSubstr("not projected")));
  EXPECT_THAT([] { ParseCrs("EPSG:2263"); }, ThrowsMessage<InputError>(HasSubstr("foot")));
  EXPECT_THAT([] { ParseCrs("nonsense"); },
              ThrowsMessage<InputError>(HasSubstr("nonsense: is no known")));
}

TEST(SitePlan, ReadsAnImageWithAWorldFile) {
  const support::TempFolder folder;
  cv::Mat image(20, 30, CV_8UC3, cv::Scalar(10, 20, 30));
  cv::imwrite((folder / "plan.png").string(), image);
  EXPECT_THAT([&] { ReadSitePlan(folder / "plan.png"); },
              ThrowsMessage<InputError>(HasSubstr("world file")));
  // Pixels of 0.1 m; the centre of the first one at (100.05, 199.95).
  std::ofstream(folder / "plan.pgw") << "0.1\n0\n0\n-0.1\n100.05\n199.95\n";
  const SitePlan plan = ReadSitePlan(folder / "plan.png");
  EXPECT_EQ(plan.image.size(), image.size());
  EXPECT_EQ(plan.image.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  EXPECT_NEAR(plan.transform[0], 100, 1e-9);
  EXPECT_NEAR(plan.transform[3], 200, 1e-9);
  EXPECT_NEAR(plan.transform[5], -0.1, 1e-12);
}

TEST(SitePlan, ReadsTheLinesOfADrawing) {
  const support::TempFolder folder;
  std::ofstream(folder / "plan.dxf") << "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\nwalls\n10\n1\n20\n2\n"
                                        "11\n3\n21\n4\n0\nENDSEC\n0\nEOF\n";
  const SitePlan plan = ReadSitePlan(folder / "plan.dxf");
  ASSERT_EQ(plan.lines.size(), 1U);
  ASSERT_EQ(plan.lines[0].size(), 2U);
  EXPECT_EQ(plan.lines[0][1], Eigen::Vector2d(3, 4));
  EXPECT_THAT([&] { ReadSitePlan(folder / "none.dxf"); },
              ThrowsMessage<InputError>(HasSubstr("no such file")));
}

}  // namespace
}  // namespace ceilmap::store
