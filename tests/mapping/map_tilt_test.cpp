// The tilt of frames in the map file.

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <string>

#include "mapping/store/map_file.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::mapping {
namespace {

/// A map whose frames stand tilted, each differently.
store::synthetic::SmallMap TiltedMap() {
  store::synthetic::SmallMap map;
  for (std::size_t i = 0; i < map.trajectory.size(); i += 2) {
    const double part = 1.0 / static_cast<double>(i + 3);
    map.trajectory[i].tilt = {-0.1 * part, 0.07 * part, 0.02 * part, Eigen::Matrix2d::Identity()};
  }
  map.keyframes[4].pose.tilt = {0.05, -1.0 / 3, 1e-3, Eigen::Matrix2d::Zero()};
  return map;
}

void ExpectSame(const Tilt& a, const Tilt& b) {
  EXPECT_EQ(a.pitch_rad, b.pitch_rad);
  EXPECT_EQ(a.roll_rad, b.roll_rad);
  EXPECT_EQ(a.lift_m, b.lift_m);
}

TEST(MapTilt, IsKeptExactly) {
  const support::TempFolder folder;
  const store::synthetic::SmallMap map = TiltedMap();
  map.Write(folder / "map.gpkg");
  const store::MapReader reader(folder / "map.gpkg");
  const std::vector<graph::FramePose> trajectory = reader.ReadTrajectory();
  ASSERT_EQ(trajectory.size(), map.trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(trajectory[i].tilt, map.trajectory[i].tilt);
  }
  EXPECT_TRUE(trajectory[1].tilt.IsLevel());
  const std::vector<graph::Keyframe> keyframes = reader.ReadKeyframes();
  ASSERT_EQ(keyframes.size(), map.keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(keyframes[i].pose.tilt, map.keyframes[i].pose.tilt);
  }
}

// Maps of earlier versions have no such columns: their robots were taken for level.
TEST(MapTilt, IsLevelInAMapWithoutIt) {
  const support::TempFolder folder;
  TiltedMap().Write(folder / "map.gpkg");
  GDALAllRegister();
  {
    const GDALDatasetUniquePtr dataset(
        GDALDataset::Open((folder / "map.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE));
    ASSERT_NE(dataset, nullptr);
    for (const char* const table : {"trajectory", "keyframes"}) {
      OGRLayer* const layer = dataset->GetLayerByName(table);
      ASSERT_NE(layer, nullptr) << table;
      for (const char* const column : {"pitch_rad", "roll_rad", "lift"}) {
        const int index = layer->GetLayerDefn()->GetFieldIndex(column);
        ASSERT_GE(index, 0) << column;
        ASSERT_EQ(layer->DeleteField(index), OGRERR_NONE);
      }
    }
  }
  const store::MapReader reader(folder / "map.gpkg");
  const store::synthetic::SmallMap map = TiltedMap();
  const std::vector<graph::FramePose> trajectory = reader.ReadTrajectory();
  ASSERT_EQ(trajectory.size(), map.trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    EXPECT_TRUE(trajectory[i].tilt.IsLevel()) << i;
    EXPECT_EQ(trajectory[i].T_map_base.yaw, map.trajectory[i].T_map_base.yaw);
    EXPECT_EQ(trajectory[i].covariance, map.trajectory[i].covariance);
  }
  for (const graph::Keyframe& keyframe : reader.ReadKeyframes()) {
    EXPECT_TRUE(keyframe.pose.tilt.IsLevel());
  }
}

}  // namespace
}  // namespace ceilmap::mapping
