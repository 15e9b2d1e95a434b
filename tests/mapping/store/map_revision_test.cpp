#include "mapping/store/map_revision.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
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

void WriteSite(const std::filesystem::path& map,
               const std::filesystem::path& output,
               const survey::SiteFrame& site,
               const std::string& provenance) {
  MapRevision revision(map, output, provenance);
  revision.SetSiteFrame(site);
  revision.Commit();
}

MapHistory ExampleHistory() {
  MapHistory history;
  history.sessions.push_back({1, "2026-11-28T08:00:00Z", "up.mp4", "robot \"1\"", "0.2", 100, 98});
  history.sessions.push_back({2, "", "", "", "0.2", 3, 2, true, 1.0 / 3, 2.0 / 7});
  Change change;
  change.id = 4;
  change.kind = Change::Kind::kLamp;
  change.state = Change::State::kReplaced;
  change.first_session = 1;
  change.last_session = 2;
  change.frames = 12;
  change.difference = 1.0 / 3;
  change.area = 0.7;
  change.polygons = {{{{0, 0}, {1, 0}, {1, 1.0 / 3}}, {{0.2, 0.1}, {0.3, 0.1}, {0.3, 0.2}}},
                     {{{5, 5}, {6, 5}, {6, 6}}}};
  history.changes.push_back(change);
  history.looks.push_back({1, 2, {256, 0}, synthetic::Image(5, {Look::kSizePx, Look::kSizePx})});
  return history;
}

class MapRevisionTest : public testing::Test {
 protected:
  void SetUp() override { synthetic::SmallMap().Write(folder_ / "map.gpkg"); }

  support::TempFolder folder_;
};

TEST_F(MapRevisionTest, ASiteIsReadBackToTheLastBit) {
  WriteSite(folder_ / "map.gpkg", folder_ / "out.gpkg", ExampleSite(), "ceilmap align");
  const MapReader map(folder_ / "out.gpkg");
  ASSERT_TRUE(map.Metadata().site);
  ExpectEqual(*map.Metadata().site, ExampleSite());
  EXPECT_THAT(map.Metadata().provenance, HasSubstr("ceilmap map --up video.mp4\nceilmap align"));
  EXPECT_FALSE(MapReader(folder_ / "map.gpkg").Metadata().site);
}

TEST_F(MapRevisionTest, LeavesTheRestOfTheMap) {
  const MapReader before(folder_ / "map.gpkg");
  WriteSite(folder_ / "map.gpkg", folder_ / "out.gpkg", ExampleSite(), "");
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

TEST_F(MapRevisionTest, ReplacesAnEarlierAlignmentInPlace) {
  const auto map = folder_ / "map.gpkg";
  WriteSite(map, map, ExampleSite(), "first");
  survey::SiteFrame second = ExampleSite();
  second.crs_wkt.clear();
  second.S_site_map.scale = 1;
  second.points.pop_back();
  WriteSite(map, map, second, "second");
  ExpectEqual(*MapReader(map).Metadata().site, second);
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator((folder_ / "map.gpkg").parent_path())) {
    files += entry.is_regular_file() ? 1 : 0;
  }
  EXPECT_EQ(files, 1) << "no partial files and journals";
}

TEST_F(MapRevisionTest, AMapWrittenWithASiteHasIt) {
  synthetic::SmallMap map;
  map.metadata.site = ExampleSite();
  map.Write(folder_ / "whole.gpkg");
  ExpectEqual(*MapReader(folder_ / "whole.gpkg").Metadata().site, ExampleSite());
}

TEST_F(MapRevisionTest, HistoryIsReadBackToTheLastBit) {
  const auto file = folder_ / "map.gpkg";
  EXPECT_TRUE(MapReader(file).ReadHistory().sessions.empty());
  for (int time = 0; time < 2; ++time) {  // the second replaces the first
    MapRevision revision(file, file, "update");
    revision.SetHistory(ExampleHistory());
    revision.Commit();
  }
  const MapHistory expected = ExampleHistory();
  const MapHistory history = MapReader(file).ReadHistory();
  ASSERT_EQ(history.sessions.size(), 2U);
  EXPECT_EQ(history.sessions[0].robot, expected.sessions[0].robot);
  EXPECT_EQ(history.sessions[0].placed, 98);
  EXPECT_FALSE(history.sessions[0].other_light);
  EXPECT_EQ(history.sessions[1].source, "");
  EXPECT_TRUE(history.sessions[1].other_light);
  EXPECT_EQ(history.sessions[1].seen_area, 1.0 / 3);
  EXPECT_EQ(history.sessions[1].changed_area, 2.0 / 7);
  ASSERT_EQ(history.changes.size(), 1U);
  const Change& change = history.changes[0];
  EXPECT_EQ(change.id, 4);
  EXPECT_EQ(change.kind, Change::Kind::kLamp);
  EXPECT_EQ(change.state, Change::State::kReplaced);
  EXPECT_EQ(change.last_session, 2);
  EXPECT_EQ(change.difference, 1.0 / 3);
  EXPECT_EQ(change.polygons, expected.changes[0].polygons);
  ASSERT_EQ(history.looks.size(), 1U);
  EXPECT_EQ(history.looks[0].session, 2);
  EXPECT_EQ(history.looks[0].origin_px, cv::Point(256, 0));
  EXPECT_TRUE(synthetic::Same(history.looks[0].image, expected.looks[0].image));
}

TEST_F(MapRevisionTest, LooksCanBeRemoved) {
  const auto file = folder_ / "map.gpkg";
  MapHistory history = ExampleHistory();
  for (int time = 0; time < 2; ++time) {
    MapRevision revision(file, file, "update");
    revision.SetHistory(history);
    revision.Commit();
    EXPECT_EQ(MapReader(file).ReadLooks().size(), history.looks.size());
    history.looks.clear();
  }
}

TEST_F(MapRevisionTest, DamagedLooksAreRefused) {
  const auto file = folder_ / "map.gpkg";
  const auto write = [&](const cv::Point& origin, const cv::Size& size) {
    MapHistory history = ExampleHistory();
    history.looks[0].origin_px = origin;
    history.looks[0].image = synthetic::Image(5, size);
    MapRevision revision(file, file, "update");
    revision.SetHistory(history);
    revision.Commit();
  };
  const cv::Size size(Look::kSizePx, Look::kSizePx);
  write({256, 256}, size);
  EXPECT_EQ(MapReader(file).ReadLooks().size(), 1U);
  write({256, 512}, size);  // below the mosaic
  EXPECT_THROW((void)MapReader(file).ReadLooks(), InputError);
  write({256, 256}, {64, 64});
  EXPECT_THROW((void)MapReader(file).ReadLooks(), InputError);
  write({256, 100}, size);
  EXPECT_THROW((void)MapReader(file).ReadLooks(), InputError);
  write({-256, 0}, size);
  EXPECT_THROW((void)MapReader(file).ReadLooks(), InputError);
}

// Numbers whose successors and sums would overflow.
TEST_F(MapRevisionTest, ImpossibleNumbersOfTheHistoryAreRefused) {
  const auto file = folder_ / "map.gpkg";
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  const auto message = [&](const auto& damage) {
    MapHistory history = ExampleHistory();
    damage(history);
    MapRevision revision(file, file, "update");
    revision.SetHistory(history);
    revision.Commit();
    try {
      (void)MapReader(file).ReadHistory();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](MapHistory&) {}), "accepted");
  EXPECT_THAT(message([](MapHistory& history) { history.sessions[1].id = kMax; }),
              HasSubstr("an impossible number"));
  EXPECT_THAT(message([](MapHistory& history) { history.sessions[1].frames = kMax; }),
              HasSubstr("impossible frames"));
  EXPECT_THAT(message([](MapHistory& history) { history.changes[0].frames = kMax; }),
              HasSubstr("impossible frames"));
  EXPECT_THAT(message([](MapHistory& history) { history.changes[0].last_session = kMax; }),
              HasSubstr("impossible last_session"));
}

// As many small PNGs as fill the memory of the machine.
TEST(MapHistory, HoldsAsManyLooksAsFitInMemory) {
  LookSquares squares;
  for (int i = 0; i < static_cast<int>(kMaxLooks); ++i) squares[{i, 0}] = {};
  EXPECT_TRUE(NumberedLooks(squares).empty());  // none shows anything
  squares[{-1, 0}] = {};
  EXPECT_THROW((void)NumberedLooks(squares), RunError);
}

TEST_F(MapRevisionTest, AWindowOfTheMosaicAndItsPyramid) {
  const auto file = folder_ / "map.gpkg";
  const cv::Rect window(250, 100, 201, 77);
  const cv::Mat fresh = synthetic::Image(9, window.size());
  {
    MapRevision revision(file, file, "update");
    revision.WriteMosaic(window, fresh, cv::Mat(window.size(), CV_8UC1, cv::Scalar(255)));
    EXPECT_THROW(revision.WriteMosaic({690, 0, 20, 20}, fresh, fresh), InputError);
    revision.Commit();
  }
  const MapReader map(file);
  cv::Mat grey;
  cv::Mat alpha;
  map.ReadMosaic(window, grey, alpha);
  EXPECT_TRUE(synthetic::Same(grey, fresh));
  map.ReadMosaic({0, 0, synthetic::kGrid.width_px, synthetic::kGrid.height_px}, grey, alpha);
  for (int row = 0; row < grey.rows; ++row) {
    for (int col = 0; col < grey.cols; ++col) {
      if (alpha.at<unsigned char>(row, col) == 0 || window.contains({col, row})) continue;
      ASSERT_EQ(grey.at<unsigned char>(row, col), synthetic::Grey(col, row));
    }
  }
  // Each pixel of the overview is the mean of 4 x 4 pixels of the new mosaic.
  cv::Mat overview;
  cv::Mat seen;
  const MosaicGrid small = map.ReadOverview(200, overview, seen);
  ASSERT_EQ(small.width_px, synthetic::kGrid.width_px / 4);
  for (int row = 3; row < overview.rows; ++row) {
    for (int col = 6; col < overview.cols; ++col) {
      const double mean = cv::mean(grey(cv::Rect(4 * col, 4 * row, 4, 4)))[0];
      ASSERT_NEAR(overview.at<unsigned char>(row, col), mean, 1.1) << col << " " << row;
    }
  }
}

TEST_F(MapRevisionTest, AnImageIsReplacedWithItsDescriptors) {
  const auto file = folder_ / "map.gpkg";
  const std::int64_t id = MapReader(file).ReadKeyframes().front().id;
  const cv::Mat image = synthetic::Image(77, {64, 48});
  const cv::Mat descriptors(3, 66, CV_32FC1, cv::Scalar(0.25));
  {
    MapRevision revision(file, folder_ / "new.gpkg", "update");
    const cv::Mat small = image(cv::Rect(0, 0, 5, 5));
    EXPECT_THROW(revision.ReplaceImages({{id, small, descriptors}}, 1), InputError);
    revision.ReplaceImages({{id, image, descriptors}}, 2);
    revision.Commit();
  }
  EXPECT_TRUE(synthetic::Same(MapReader(folder_ / "new.gpkg").ReadImage(id), image));
  EXPECT_TRUE(synthetic::Same(MapReader(folder_ / "new.gpkg").ReadDescriptors(id), descriptors));
  EXPECT_FALSE(synthetic::Same(MapReader(file).ReadImage(id), image));
}

TEST_F(MapRevisionTest, OthersCannotWriteTheMapMeanwhile) {
  const auto file = folder_ / "map.gpkg";
  MapRevision first(file, file, "first");
  EXPECT_THROW(MapRevision(file, file, "second"), InputError);
  std::filesystem::copy_file(file, folder_ / "other.gpkg");
  std::filesystem::rename(folder_ / "other.gpkg", file);  // by a program without locks
  EXPECT_THAT([&] { first.Commit(); }, ThrowsMessage<InputError>(HasSubstr("map.gpkg")));
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
