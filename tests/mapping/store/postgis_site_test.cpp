// Maps that are aligned with their building, in a database.

#include <gmock/gmock.h>

#include "calib/base/error.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/site_tables.hpp"
#include "tests/mapping/store/postgis_fixture.hpp"

namespace ceilmap::store {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST_F(Postgis, HoldsTheAlignmentOfAMap) {
  const survey::SiteFrame site = Site("EPSG:25832");
  const MapReader map(WriteMap("robot 1", site));
  ExportPostgis(map, Connection(), Options("lab"));
  OpenDatabase();
  const auto points = Rows("control_points", tables::ToAlignedPoint);
  ASSERT_EQ(points.size(), 2U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(points[i].point.name, site.points[i].point.name);
    EXPECT_EQ(points[i].point.p_map, site.points[i].point.p_map);
    EXPECT_EQ(points[i].point.p_site, site.points[i].point.p_site);
    EXPECT_EQ(points[i].point.sigma_m, site.points[i].point.sigma_m);
    EXPECT_EQ(points[i].residual_m, site.points[i].residual_m);
    EXPECT_EQ(points[i].leave_one_out_m, site.points[i].leave_one_out_m);
    EXPECT_EQ(points[i].used, site.points[i].used);
  }
  EXPECT_EQ(Ask("SELECT frame || ' ' || srid || ' ' || (site_x = 691000.1) || ' ' || (site_y = "
                "5335000.7) || ' ' || (site_yaw_rad = 1.0::float8 / 3) || ' ' || site_scale FROM "
                "ceilmap.maps"),
            "map 25832 true true true 1");
  EXPECT_EQ(Ask("SELECT site_crs FROM ceilmap.maps"), site.crs_wkt);
  EXPECT_EQ(Ask("SELECT max(ST_SRID(geom)) FROM ceilmap.keyframes"), "0") << "of the map";
}

TEST_F(Postgis, LiesInTheBuildingWithItsReferenceSystem) {
  const survey::SiteFrame site = Site("EPSG:25832");
  const MapReader map(WriteMap("robot 1", site));
  ExportPostgis(map, Connection(), InSite("lab"));
  OpenDatabase();
  const graph::MapGraph graph = map.ReadGraph();
  const auto keyframes = Rows("keyframes_25832", [](OGRFeature& row) {
    row.SetFID(row.GetFieldAsInteger64("id"));
    return tables::ToKeyframe(row);
  });
  ASSERT_EQ(keyframes.size(), graph.keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const graph::FramePose& before = graph.keyframes[i].pose;
    const PoseWithCovariance expected =
        survey::ToSite(site, {before.T_map_base, before.covariance});
    const graph::FramePose& frame = keyframes[i].pose;
    EXPECT_EQ(frame.T_map_base.x, expected.pose.x);
    EXPECT_EQ(frame.T_map_base.y, expected.pose.y);
    EXPECT_EQ(frame.T_map_base.yaw, expected.pose.yaw);
    EXPECT_EQ(frame.covariance(0, 0), expected.covariance(0, 0));
    EXPECT_GT(frame.covariance(0, 0), 1e-4) << "with the error of the alignment";
  }
  const auto edges = Rows("edges", tables::ToEdge);
  EXPECT_EQ(edges[0].T_from_to.x, graph.edges[0].T_from_to.x) << "relative to a keyframe";
  EXPECT_EQ(edges[0].information, graph.edges[0].information);
  const auto left_out = Rows("left_out", tables::ToLeftOut);
  const cv::Point2d corner = left_out[0].polygons[0][0][1];
  const Eigen::Vector2d place = site.S_site_map * Eigen::Vector2d(2, 0);
  EXPECT_EQ(corner, cv::Point2d(place.x(), place.y()));
  EXPECT_EQ(Ask("SELECT ST_X(geom)::text FROM ceilmap.control_points_25832 WHERE name = 'B'"),
            "691003");
  EXPECT_EQ(Ask("SELECT string_agg(DISTINCT f_table_name || ' ' || type, ', ') FROM "
                "geometry_columns WHERE srid = 25832"),
            "control_points_25832 POINT, edges_25832 LINESTRING, keyframes_25832 POINT, "
            "left_out_25832 MULTIPOLYGON, trajectory_25832 POINT, weak_spots_25832 POINT");
  EXPECT_EQ(Ask("SELECT frame || ' ' || srid || ' ' || unit FROM ceilmap.maps"), "site 25832 m");
  // In Munich.
  EXPECT_EQ(Ask("SELECT round(ST_Y(ST_Transform(geom, 4326)))::text FROM "
                "ceilmap.keyframes_25832 LIMIT 1"),
            "48");
}

TEST_F(Postgis, KnowsSystemsThatEpsgDoesNot) {
  const std::string crs =
      "+proj=tmerc +lat_0=48.1 +lon_0=11.5 +k=1 +x_0=691000 +y_0=5335000 +ellps=GRS80 +units=m";
  const MapReader map(WriteMap("robot 1", Site(crs)));
  ExportPostgis(map, Connection(), InSite("a"));
  ExportPostgis(map, Connection(), InSite("b"));
  OpenDatabase();
  const std::string srid = Ask("SELECT min(srid)::text FROM ceilmap.maps");
  EXPECT_GT(std::stoi(srid), 900'000);
  EXPECT_EQ(Ask("SELECT max(srid)::text FROM ceilmap.maps"), srid);
  EXPECT_EQ(Ask("SELECT count(*) FROM spatial_ref_sys WHERE auth_name = 'ceilmap'"), "1");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.keyframes_" + srid), "12");
  EXPECT_EQ(Ask("SELECT round(ST_Y(ST_Transform(geom, 4326))::numeric, 1)::text FROM "
                "ceilmap.keyframes_" +
                srid + " LIMIT 1"),
            "48.1");
}

TEST_F(Postgis, LocalSystemsHaveNoNumber) {
  const MapReader map(WriteMap("robot 1", Site()));
  ExportPostgis(map, Connection(), InSite("lab"));
  EXPECT_EQ(Ask("SELECT frame || ' ' || srid || '.' || site_crs FROM ceilmap.maps"), "site 0.");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.keyframes WHERE ST_SRID(geom) = 0 AND ST_X(geom) > "
                "690000"),
            "6");
  const MapReader plain(WriteMap());
  EXPECT_THAT([&] { ExportPostgis(plain, Connection(), InSite("plain")); },
              ThrowsMessage<InputError>(HasSubstr("run 'ceilmap align")));
}

TEST_F(Postgis, ServesUsersWhoMayOnlyWriteRows) {
  const std::string crs = "+proj=tmerc +lat_0=47 +lon_0=11.5 +ellps=GRS80 +units=m";
  const MapReader map(WriteMap("robot 1", Site(crs)));
  ExportPostgis(MapReader(WriteMap()), Connection(), Options("first"));
  Ask("DROP ROLE IF EXISTS writer");
  Ask("CREATE ROLE writer LOGIN");
  Ask("GRANT USAGE ON SCHEMA ceilmap TO writer");
  Ask("GRANT SELECT, INSERT, DELETE ON ALL TABLES IN SCHEMA ceilmap TO writer");
  Ask("GRANT USAGE ON ALL SEQUENCES IN SCHEMA ceilmap TO writer");
  std::string connection = Connection();
  connection.replace(connection.find("user=postgres"), 13, "user=writer");
  ExportPostgis(map, connection, InSite("lab"));
  EXPECT_EQ(Ask("SELECT srid || ' ' || (site_crs <> '') FROM ceilmap.maps WHERE name = 'lab'"),
            "0 true");
  EXPECT_EQ(Ask("SELECT count(*) FROM pg_views WHERE schemaname = 'ceilmap'"), "0");
  Ask("DROP OWNED BY writer");
  Ask("DROP ROLE writer");
}

TEST_F(Postgis, ExtendsTablesOfEarlierVersions) {
  ExportPostgis(MapReader(WriteMap()), Connection(), Options("old"));
  Ask("DROP TABLE ceilmap.control_points");
  Ask("ALTER TABLE ceilmap.maps DROP COLUMN frame, DROP COLUMN srid, DROP COLUMN site_crs, DROP "
      "COLUMN site_scale, DROP COLUMN site_x, DROP COLUMN site_y, DROP COLUMN site_yaw_rad");
  ExportPostgis(MapReader(WriteMap("robot 2", Site())), Connection(), Options("new"));
  EXPECT_EQ(Ask("SELECT string_agg(name || ' ' || frame || ' ' || srid, ', ' ORDER BY id) FROM "
                "ceilmap.maps"),
            "old map 0, new map 0");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.control_points"), "2");
}

}  // namespace
}  // namespace ceilmap::store
