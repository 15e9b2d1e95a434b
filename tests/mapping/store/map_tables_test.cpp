// What is written into the tables of a map is what is read.

#include "mapping/store/map_file.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

using synthetic::Same;
using synthetic::SmallMap;

void ExpectSame(const graph::FramePose& a, const graph::FramePose& b) {
  EXPECT_EQ(a.frame_index, b.frame_index);
  EXPECT_EQ(a.stamp_s, b.stamp_s);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.T_map_base.x, b.T_map_base.x);
  EXPECT_EQ(a.T_map_base.y, b.T_map_base.y);
  EXPECT_EQ(a.T_map_base.yaw, b.T_map_base.yaw);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(MapTables, KeepsMetadataExactly) {
  const support::TempFolder folder;
  const SmallMap map;
  map.Write(folder / "map.gpkg");
  const MapReader reader(folder / "map.gpkg");
  const MapMetadata& read = reader.Metadata();
  EXPECT_EQ(read.format_version, 2);
  EXPECT_EQ(read.unit, map.metadata.unit);
  EXPECT_EQ(read.resolution, map.metadata.resolution);
  EXPECT_EQ(read.ceiling_height_m, map.metadata.ceiling_height_m);
  EXPECT_EQ(read.rig_yaml, map.metadata.rig_yaml);
  EXPECT_EQ(read.robot, map.metadata.robot);
  EXPECT_EQ(read.view_size, map.metadata.view_size);
  EXPECT_EQ(read.view_units_per_px, map.metadata.view_units_per_px);
  EXPECT_EQ(read.view_focal_px, map.metadata.view_focal_px);
  EXPECT_EQ(read.view_principal_px, map.metadata.view_principal_px);
  EXPECT_EQ(read.T_base_view.x, map.metadata.T_base_view.x);
  EXPECT_EQ(read.T_base_view.y, map.metadata.T_base_view.y);
  EXPECT_EQ(read.T_base_view.yaw, map.metadata.T_base_view.yaw);
  EXPECT_EQ(read.view_focal_px, map.metadata.view_focal_px);
  EXPECT_EQ(read.view_principal_px, map.metadata.view_principal_px);
  EXPECT_EQ(read.program_version, map.metadata.program_version);
  EXPECT_EQ(read.provenance, map.metadata.provenance);
}

TEST(MapMetadata, HeightsAboveTheFloorAreThoseOfTheReferencePlaneAndTheRatio) {
  MapMetadata metadata = SmallMap().metadata;
  metadata.ceiling_height_m = 5;
  metadata.view_units_per_px = 0.01;
  metadata.view_focal_px = 400;  // the camera is 4 m below the ceiling
  EXPECT_DOUBLE_EQ(HeightAboveFloor(metadata, 1).value(), 5);
  EXPECT_DOUBLE_EQ(HeightAboveFloor(metadata, 2).value(), 3);
  EXPECT_EQ(HeightAboveFloor(metadata, 0), std::nullopt);
  metadata.view_focal_px = 0;
  EXPECT_EQ(HeightAboveFloor(metadata, 1), std::nullopt);
  metadata.view_focal_px = 400;
  metadata.unit = "px";
  EXPECT_EQ(HeightAboveFloor(metadata, 1), std::nullopt);
}

TEST(MapTables, KeepsPosesEdgesAndImagesExactly) {
  const support::TempFolder folder;
  const SmallMap map;
  map.Write(folder / "map.gpkg");
  const MapReader reader(folder / "map.gpkg");

  const std::vector<graph::Keyframe> keyframes = reader.ReadKeyframes();
  ASSERT_EQ(keyframes.size(), map.keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    EXPECT_EQ(keyframes[i].id, map.keyframes[i].id);
    EXPECT_TRUE(keyframes[i].image.empty());
    ExpectSame(keyframes[i].pose, map.keyframes[i].pose);
    EXPECT_TRUE(Same(reader.ReadImage(keyframes[i].id),
                     synthetic::Image(keyframes[i].id, map.metadata.view_size)));
  }
  const std::vector<graph::FramePose> trajectory = reader.ReadTrajectory();
  ASSERT_EQ(trajectory.size(), map.trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) ExpectSame(trajectory[i], map.trajectory[i]);
  const std::vector<graph::Edge> edges = reader.ReadEdges();
  ASSERT_EQ(edges.size(), map.edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(edges[i].from, map.edges[i].from);
    EXPECT_EQ(edges[i].to, map.edges[i].to);
    EXPECT_EQ(edges[i].kind, map.edges[i].kind);
    EXPECT_EQ(edges[i].T_from_to.x, map.edges[i].T_from_to.x);
    EXPECT_EQ(edges[i].T_from_to.y, map.edges[i].T_from_to.y);
    EXPECT_EQ(edges[i].T_from_to.yaw, map.edges[i].T_from_to.yaw);
    EXPECT_EQ(edges[i].information, map.edges[i].information);
  }
}

TEST(MapTables, KeepsHeightsExactly) {
  const support::TempFolder folder;
  const SmallMap map;
  map.Write(folder / "map.gpkg");
  const std::vector<graph::Keyframe> read = MapReader(folder / "map.gpkg").ReadGraph().keyframes;
  ASSERT_EQ(read.size(), map.keyframes.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(read[i].heights != nullptr, i == 1 || i == 4) << i;
    if (!read[i].heights) continue;
    const heights::HeightField& a = *read[i].heights;
    const heights::HeightField& b = *map.keyframes[i].heights;
    EXPECT_EQ(a.grid, b.grid);
    EXPECT_EQ(a.first_px, b.first_px);
    EXPECT_EQ(a.step_px, b.step_px);
    EXPECT_EQ(a.scale_sigma, b.scale_sigma);
    ASSERT_EQ(a.cells.size(), b.cells.size());
    for (std::size_t c = 0; c < a.cells.size(); ++c) {
      EXPECT_EQ(a.cells[c].rho, b.cells[c].rho);
      EXPECT_EQ(a.cells[c].sigma, b.cells[c].sigma);
    }
  }
}

TEST(MapTables, KeepsWhatIsLeftOut) {
  const support::TempFolder folder;
  LeftOut walls;
  walls.area = 12.25;
  walls.polygons = {{{{0, 0}, {4, 0}, {4, 3}, {0, 3}}, {{1, 1}, {1, 2}, {2, 2}}},
                    {{{5, 5}, {6, 5}, {6, 6.5}}}};
  LeftOut fan;
  fan.kind = LeftOut::Kind::kMoves;
  fan.area = 0.5;
  fan.polygons = {{{{1.5, 1.5}, {2, 1.5}, {2, 2.5}}}};
  {
    MapWriter writer(folder / "map.gpkg", synthetic::Metadata({64, 48}, 0.01));
    writer.WriteLeftOut({walls, fan});
    writer.Commit();
  }
  const std::vector<LeftOut> read = MapReader(folder / "map.gpkg").ReadLeftOut();
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].kind, LeftOut::Kind::kBelowCeiling);
  EXPECT_EQ(read[0].area, walls.area);
  EXPECT_EQ(read[0].polygons, walls.polygons);
  EXPECT_EQ(read[1].kind, LeftOut::Kind::kMoves);
  EXPECT_EQ(read[1].polygons, fan.polygons);
}

TEST(MapTables, KeepsWeakSpotsAndQualityExactly) {
  const support::TempFolder folder;
  const graph::MapGraph graph = SmallMap().Graph();
  SmallMap().Write(folder / "map.gpkg");
  const graph::MapGraph read = MapReader(folder / "map.gpkg").ReadGraph();
  ASSERT_EQ(read.weak_spots.size(), graph.weak_spots.size());
  for (std::size_t i = 0; i < read.weak_spots.size(); ++i) {
    EXPECT_EQ(read.weak_spots[i].kind, graph.weak_spots[i].kind);
    EXPECT_EQ(read.weak_spots[i].keyframe_id, graph.weak_spots[i].keyframe_id);
    EXPECT_EQ(read.weak_spots[i].x, graph.weak_spots[i].x);
    EXPECT_EQ(read.weak_spots[i].y, graph.weak_spots[i].y);
    EXPECT_EQ(read.weak_spots[i].extent, graph.weak_spots[i].extent);
  }
  EXPECT_EQ(read.keyframes[3].ambiguous, true);
  EXPECT_EQ(read.keyframes[2].ambiguous, false);
  EXPECT_EQ(read.trajectory[5].keyframe_id, graph.trajectory[5].keyframe_id);
  const graph::MapQuality& a = read.quality;
  const graph::MapQuality& b = graph.quality;
  EXPECT_EQ(a.loops.compared, b.loops.compared);
  EXPECT_EQ(a.loops.accepted, b.loops.accepted);
  EXPECT_EQ(a.loops.no_match, b.loops.no_match);
  EXPECT_EQ(a.loops.ambiguous, b.loops.ambiguous);
  EXPECT_EQ(a.loops.off_prediction, b.loops.off_prediction);
  EXPECT_EQ(a.loops.unconfirmed, b.loops.unconfirmed);
  EXPECT_EQ(a.loops.outliers, b.loops.outliers);
  EXPECT_EQ(a.chi2_per_dof, b.chi2_per_dof);
  EXPECT_EQ(a.max_edge_sigmas, b.max_edge_sigmas);
  EXPECT_EQ(a.odometry_rms, b.odometry_rms);
  EXPECT_EQ(a.loop_rms, b.loop_rms);
}

}  // namespace
}  // namespace ceilmap::store
