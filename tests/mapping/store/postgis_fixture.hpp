#pragma once

#include <gtest/gtest.h>
#include <ogrsf_frmts.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mapping/store/crs.hpp"
#include "mapping/store/postgis.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {

/// A server of the test's own, started once; all tests are skipped where there is none.
class Postgis : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<support::TempFolder>();
    std::filesystem::create_directory(*folder_ / "server");
    std::filesystem::permissions(*folder_ / "", std::filesystem::perms::all);
    status_ = Script("start");
  }
  static void TearDownTestSuite() {
    if (status_ == 0) Script("stop");
    folder_.reset();
  }
  static int Script(const std::string& action) {
    const std::string command = std::string(CEILMAP_SOURCE_DIR) + "/tests/support/postgres.sh " +
                                action + " " + (*folder_ / "server").string();
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  void SetUp() override {
    if (status_ == 77) GTEST_SKIP() << "PostgreSQL with PostGIS is not installed";
    ASSERT_EQ(status_, 0) << "the server did not start";
    GDALAllRegister();
    OpenDatabase();
    Ask("DROP SCHEMA IF EXISTS ceilmap CASCADE");
  }

  static std::string Connection(const std::string& database = "site") {
    return "PG:host=" + (*folder_ / "server").string() + " user=postgres dbname=" + database;
  }
  void OpenDatabase() {
    database_.reset(
        GDALDataset::Open(Connection().c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE, nullptr));
    ASSERT_NE(database_, nullptr);
  }
  /// The first column of the first row.
  std::string Ask(const std::string& sql) {
    OGRLayer* result = database_->ExecuteSQL(sql.c_str(), nullptr, nullptr);
    if (result == nullptr) return "";
    std::string answer;
    if (const OGRFeatureUniquePtr row{result->GetNextFeature()}) answer = row->GetFieldAsString(0);
    database_->ReleaseResultSet(result);
    return answer;
  }
  /// Rows of a table in their order, by the converters of the map file.
  template <typename Convert>
  auto Rows(const std::string& table, Convert convert) {
    std::vector<decltype(convert(std::declval<OGRFeature&>()))> rows;
    OGRLayer* result = database_->ExecuteSQL(
        ("SELECT * FROM ceilmap." + table + " ORDER BY map_id, fid").c_str(), nullptr, nullptr);
    EXPECT_NE(result, nullptr);
    for (const auto& row : *result) rows.push_back(convert(*row));
    database_->ReleaseResultSet(result);
    return rows;
  }

  static PostgisOptions Options(const std::string& name,
                                bool replace = false,
                                const std::string& mosaic = "") {
    PostgisOptions options;
    options.name = name;
    options.replace = replace;
    options.mosaic = mosaic;
    return options;
  }

  static std::filesystem::path WriteMap(const std::string& robot = "robot 1",
                                        const std::optional<survey::SiteFrame>& site = {}) {
    synthetic::SmallMap small;
    small.metadata.robot = robot;
    small.metadata.site = site;
    for (graph::Keyframe& keyframe : small.keyframes) {
      keyframe.pose.covariance << 1.0 / 3, 0.1, 0.2, 0.1, 1.0 / 7, 0.3, 0.2, 0.3, 1e-17;
    }
    const std::filesystem::path file = *folder_ / "map.gpkg";
    MapWriter writer(file, small.metadata);
    LeftOut fan;
    fan.kind = LeftOut::Kind::kMoves;
    fan.area = 1.0 / 3;
    fan.polygons = {{{{0, 0}, {2, 0}, {2, 1.0 / 3}}, {{0.5, 0.1}, {0.6, 0.1}, {0.6, 0.15}}}};
    writer.WriteLeftOut({fan});
    small.WriteTo(writer);
    writer.Commit();
    return file;
  }

  /// An alignment with two points, one of them not used.
  static survey::SiteFrame Site(const std::string& crs = "") {
    survey::SiteFrame site;
    site.S_site_map = {{691'000.1, 5'335'000.7, 1.0 / 3}, 1};
    site.sigma_position_m = 0.01;
    if (!crs.empty()) site.crs_wkt = ParseCrs(crs);
    site.points = {
        {{"A 'x'", {0.1, 1.0 / 3}, {691'001, 5'335'002}, 0.005}, {0.001, -0.002}, true, 0.004},
        {{"B", {2, 1}, {691'003, 5'335'003}, 0.01}, {1, 2}, false, {}}};
    return site;
  }
  static PostgisOptions InSite(const std::string& name) {
    PostgisOptions options = Options(name);
    options.frame = Frame::kSite;
    return options;
  }

  inline static std::unique_ptr<support::TempFolder> folder_;
  inline static int status_ = -1;
  GDALDatasetUniquePtr database_;
};

}  // namespace ceilmap::store
