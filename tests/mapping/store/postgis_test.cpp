#include <gmock/gmock.h>

#include <array>
#include <map>
#include <thread>

#include "calib/base/error.hpp"
#include "mapping/store/feature_tables.hpp"
#include "tests/mapping/store/postgis_fixture.hpp"

namespace ceilmap::store {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

void ExpectSameFrame(const graph::FramePose& a, const graph::FramePose& b) {
  EXPECT_EQ(a.frame_index, b.frame_index);
  EXPECT_EQ(a.keyframe_id, b.keyframe_id);
  EXPECT_EQ(a.stamp_s, b.stamp_s);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.T_map_base.x, b.T_map_base.x);
  EXPECT_EQ(a.T_map_base.y, b.T_map_base.y);
  EXPECT_EQ(a.T_map_base.yaw, b.T_map_base.yaw);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST_F(Postgis, HoldsAllLayersExactly) {
  const MapReader map(WriteMap());
  ExportPostgis(map, Connection(), Options("lab", false, "/maps/lab.tif"));
  OpenDatabase();
  const graph::MapGraph graph = map.ReadGraph();

  const auto keyframes = Rows("keyframes", [](OGRFeature& row) {
    row.SetFID(row.GetFieldAsInteger64("id"));
    return tables::ToKeyframe(row);
  });
  ASSERT_EQ(keyframes.size(), graph.keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    EXPECT_EQ(keyframes[i].id, graph.keyframes[i].id);
    EXPECT_EQ(keyframes[i].ambiguous, graph.keyframes[i].ambiguous);
    ExpectSameFrame(keyframes[i].pose, graph.keyframes[i].pose);
  }
  const auto trajectory = Rows("trajectory", tables::ToFramePose);
  ASSERT_EQ(trajectory.size(), graph.trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    ExpectSameFrame(trajectory[i], graph.trajectory[i]);
  }
  const auto edges = Rows("edges", tables::ToEdge);
  ASSERT_EQ(edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(edges[i].from, graph.edges[i].from);
    EXPECT_EQ(edges[i].to, graph.edges[i].to);
    EXPECT_EQ(edges[i].kind, graph.edges[i].kind);
    EXPECT_EQ(edges[i].T_from_to.x, graph.edges[i].T_from_to.x);
    EXPECT_EQ(edges[i].information, graph.edges[i].information);
  }
  const auto spots = Rows("weak_spots", tables::ToWeakSpot);
  ASSERT_EQ(spots.size(), graph.weak_spots.size());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    EXPECT_EQ(spots[i].kind, graph.weak_spots[i].kind);
    EXPECT_EQ(spots[i].x, graph.weak_spots[i].x);
    EXPECT_EQ(spots[i].extent, graph.weak_spots[i].extent);
  }
  const auto left_out = Rows("left_out", tables::ToLeftOut);
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out[0].kind, LeftOut::Kind::kMoves);
  EXPECT_EQ(left_out[0].area, 1.0 / 3);
  EXPECT_EQ(left_out[0].polygons, map.ReadLeftOut()[0].polygons);
  EXPECT_EQ(Ask("SELECT name || ' ' || robot || ' ' || mosaic || ' ' || unit FROM ceilmap.maps"),
            "lab robot 1 /maps/lab.tif m");
  EXPECT_EQ(Ask("SELECT count(*) FROM geometry_columns WHERE f_table_schema = 'ceilmap'"), "6");
}

TEST_F(Postgis, ReplacesAMapOnlyIfAsked) {
  const auto file = WriteMap();
  ExportPostgis(MapReader(file), Connection(), Options("it's \\ a \"map\""));
  EXPECT_THAT([&] { ExportPostgis(MapReader(file), Connection(), Options("it's \\ a \"map\"")); },
              ThrowsMessage<InputError>(
                  "the database has a map 'it's \\ a \"map\"' already; give --force to replace it, "
                  "or --name for another name"));
  ExportPostgis(MapReader(file), Connection(), Options("other"));
  ExportPostgis(MapReader(WriteMap("robot 2")), Connection(), Options("it's \\ a \"map\"", true));
  EXPECT_EQ(Ask("SELECT string_agg(robot, ', ' ORDER BY robot) FROM ceilmap.maps"),
            "robot 1, robot 2");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.trajectory"), "80");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.keyframes"), "12");
}

TEST_F(Postgis, KeepsTheOldMapWhenTheNewOneFails) {
  ExportPostgis(MapReader(WriteMap()), Connection(), Options("lab"));
  // Fails when most is written.
  Ask("ALTER TABLE ceilmap.left_out ADD CONSTRAINT small CHECK (area < 0.1) NOT VALID");
  const MapReader again(WriteMap("robot 2"));
  EXPECT_THAT([&] { ExportPostgis(again, Connection(), Options("lab", true)); },
              ThrowsMessage<RunError>(HasSubstr("the database refuses the map: ")));
  EXPECT_EQ(Ask("SELECT string_agg(robot, ',') FROM ceilmap.maps"), "robot 1");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.trajectory"), "40");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.left_out"), "1");
}

TEST_F(Postgis, LosesAndDoublesNothingOfTenWritersAtATime) {
  const auto file = WriteMap();
  std::vector<std::thread> writers;
  std::array<std::string, 10> errors;
  for (int i = 0; i < 10; ++i) {
    writers.emplace_back([&, i] {
      try {
        const MapReader map(file);
        // The tables are made by whoever comes first; all write the same map, and one of their own.
        ExportPostgis(map, Connection(), Options("site", true));
        ExportPostgis(map, Connection(), Options("robot " + std::to_string(i)));
        ExportPostgis(map, Connection(), Options("site", true));
      } catch (const std::exception& error) {
        errors.at(static_cast<std::size_t>(i)) = error.what();
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  for (const std::string& error : errors) EXPECT_EQ(error, "");
  EXPECT_EQ(Ask("SELECT count(*) FROM ceilmap.maps"), "11");
  for (const auto& [table, rows] : std::map<std::string, std::string>{
           {"keyframes", "6"}, {"trajectory", "40"}, {"edges", "5"}, {"weak_spots", "3"}}) {
    const std::string counts =
        "SELECT min(n) || ' ' || max(n) || ' ' || count(*) FROM (SELECT count(*) AS n FROM "
        "ceilmap." +
        table + " GROUP BY map_id) AS c";
    EXPECT_EQ(Ask(counts), rows + " " + rows + " 11") << table;
  }
}

TEST_F(Postgis, NamesWhatIsMissingButNoPassword) {
  const MapReader map(WriteMap());
  const auto export_to = [&](const std::string& connection) {
    return [&map, connection] { ExportPostgis(map, connection, Options("lab")); };
  };
  EXPECT_THAT(export_to(Connection("plain")),
              ThrowsMessage<InputError>("the database has no PostGIS; run 'CREATE EXTENSION "
                                        "postgis' in it, as its owner"));
  EXPECT_THAT(export_to(Connection("absent") + " password=secret"),
              ThrowsMessage<RunError>(AllOf(HasSubstr("the database cannot be reached: "),
                                            HasSubstr("\"absent\" does not exist"),
                                            Not(HasSubstr("secret")))));
  for (const char* wrong : {"PG:host=localhost password=my secret", "PG:secret", "PG:secret=1"}) {
    EXPECT_THAT(export_to(wrong),
                ThrowsMessage<InputError>(AllOf(HasSubstr("the connection string cannot be under"),
                                                Not(HasSubstr("secret")))))
        << wrong;
  }
  EXPECT_THAT(export_to("map.tif"),
              ThrowsMessage<InputError>(HasSubstr("is named by 'PG:host=HOST")));
}

}  // namespace
}  // namespace ceilmap::store
