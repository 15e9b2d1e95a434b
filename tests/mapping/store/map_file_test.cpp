#include "mapping/store/map_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "calib/base/error.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;
using synthetic::SmallMap;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

void ExpectSame(const graph::FramePose& a, const graph::FramePose& b) {
  EXPECT_EQ(a.frame_index, b.frame_index);
  EXPECT_EQ(a.stamp_s, b.stamp_s);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.T_map_base.x, b.T_map_base.x);
  EXPECT_EQ(a.T_map_base.y, b.T_map_base.y);
  EXPECT_EQ(a.T_map_base.yaw, b.T_map_base.yaw);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(MapFile, KeepsMetadataExactly) {
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

TEST(MapFile, KeepsPosesEdgesAndImagesExactly) {
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

TEST(MapFile, HeightsAboveTheFloorAreThoseOfTheReferencePlaneAndTheRatio) {
  MapMetadata metadata = SmallMap().metadata;
  metadata.ceiling_height_m = 5;
  metadata.view_units_per_px = 0.01;
  metadata.view_focal_px = 400;  // the camera is 4 m below the ceiling
  EXPECT_DOUBLE_EQ(HeightAboveFloor(metadata, 1).value(), 5);
  EXPECT_DOUBLE_EQ(HeightAboveFloor(metadata, 2).value(), 3);
  EXPECT_EQ(HeightAboveFloor(metadata, 0), std::nullopt);
  metadata.unit = "px";
  EXPECT_EQ(HeightAboveFloor(metadata, 1), std::nullopt);
}

TEST(MapFile, KeepsHeightsExactly) {
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

TEST(MapFile, KeepsWhatIsLeftOut) {
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

TEST(MapFile, KeepsWeakSpotsAndQualityExactly) {
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

TEST(MapFile, KeepsMosaicExactly) {
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
    cv::Mat grey;
    cv::Mat alpha;
    cv::Mat expected_grey;
    cv::Mat expected_alpha;
    reader.ReadMosaic(window, grey, alpha);
    synthetic::FillMosaic(window, expected_grey, expected_alpha);
    EXPECT_TRUE(Same(grey, expected_grey)) << window;
    EXPECT_TRUE(Same(alpha, expected_alpha)) << window;
  }
  cv::Mat grey;
  cv::Mat alpha;
  EXPECT_THROW(reader.ReadMosaic({690, 0, 20, 20}, grey, alpha), InputError);
  EXPECT_THROW(reader.ReadMosaic({-1, 0, 20, 20}, grey, alpha), InputError);
  EXPECT_THROW(reader.ReadMosaic({0, 0, 0, 0}, grey, alpha), InputError);
}

TEST(MapFile, StoresMosaicOfManyWindowsAndReportsProgress) {
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
  const cv::Rect all(0, 0, 2100, 1100);
  cv::Mat grey;
  cv::Mat alpha;
  cv::Mat expected_grey;
  cv::Mat expected_alpha;
  reader.ReadMosaic(all, grey, alpha);
  synthetic::FillMosaic(all, expected_grey, expected_alpha);
  EXPECT_TRUE(Same(grey, expected_grey));
  EXPECT_TRUE(Same(alpha, expected_alpha));
}

TEST(MapFile, WriterReadsImagesBackWhileTheMosaicIsWritten) {
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

TEST(MapFile, MapInPixelsWithoutMosaicOrFrames) {
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

TEST(MapFile, UnmappedMosaicIsTransparent) {
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

TEST(MapFile, ReaderMayBeSharedBetweenThreads) {
  const support::TempFolder folder;
  const SmallMap map;
  map.Write(folder / "map.gpkg");
  const MapReader reader(folder / "map.gpkg");
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (int i = 0; i < 5; ++i) {
          const cv::Rect window(100 * t, 50 * i, 90, 40);
          cv::Mat grey;
          cv::Mat alpha;
          cv::Mat expected_grey;
          cv::Mat expected_alpha;
          reader.ReadMosaic(window, grey, alpha);
          synthetic::FillMosaic(window, expected_grey, expected_alpha);
          if (!Same(grey, expected_grey)) ++wrong;
          const std::int64_t id = (t + i) % 6;
          if (!Same(reader.ReadImage(id), synthetic::Image(id, map.metadata.view_size))) {
            ++wrong;
          }
          if (reader.ReadTrajectory().size() != map.trajectory.size()) ++wrong;
        }
      });
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(MapFile, WithoutCommitTheOldMapStays) {
  const support::TempFolder folder;
  SmallMap map;
  map.Write(folder / "map.gpkg");
  map.metadata.robot = "another";
  {
    MapWriter writer(folder / "map.gpkg", map.metadata);
    map.WriteTo(writer);
    EXPECT_TRUE(fs::exists(folder / ".map.gpkg.partial"));
    EXPECT_EQ(MapReader(folder / "map.gpkg").Metadata().robot, "robot 1");
  }
  EXPECT_EQ(MapReader(folder / "map.gpkg").Metadata().robot, "robot 1");
  EXPECT_EQ(folder.CountFiles(), 1U);
  map.Write(folder / "map.gpkg");
  EXPECT_EQ(MapReader(folder / "map.gpkg").Metadata().robot, "another");
  EXPECT_EQ(folder.CountFiles(), 1U);
}

TEST(MapFile, SaysThatAnotherReplacedIt) {
  const support::TempFolder folder;
  const fs::path file = folder / "map.gpkg";
  SmallMap().Write(file);
  const MapReader reader(file);
  EXPECT_NO_THROW(reader.CheckCurrent());
  (void)reader.ReadGraph();
  EXPECT_NO_THROW(reader.CheckCurrent());
  {
    MapWriter writer(file, reader.Metadata());
    SmallMap().WriteTo(writer);
    EXPECT_NO_THROW(reader.CheckCurrent());
    writer.Commit();
  }
  EXPECT_THROW(reader.CheckCurrent(), InputError);
  EXPECT_EQ(reader.ReadKeyframes().size(), 6U);  // of the old one
  EXPECT_NO_THROW(MapReader(file).CheckCurrent());
  fs::remove(file);
  EXPECT_THROW(reader.CheckCurrent(), InputError);
}

TEST(MapFile, ReplacesWhatAKilledRunLeftBehind) {
  const support::TempFolder folder;
  for (const char* name : {".map.gpkg.partial", ".map.gpkg.partial-journal"}) {
    std::ofstream(folder / name) << "half a map";
  }
  SmallMap().Write(folder / "map.gpkg");
  EXPECT_EQ(MapReader(folder / "map.gpkg").ReadKeyframes().size(), 6U);
  EXPECT_EQ(folder.CountFiles(), 1U);
}

TEST(MapFile, WriterNamesUnusableTargets) {
  const support::TempFolder folder;
  const MapMetadata metadata = SmallMap().metadata;
  const auto open = [&](const fs::path& file) {
    return [=] { const MapWriter writer(file, metadata); };
  };
  EXPECT_THAT(open(folder / "map.png"), ThrowsMessage<InputError>(HasSubstr("must end in .gpkg")));
  EXPECT_THAT(open(folder / "none/map.gpkg"),
              ThrowsMessage<InputError>(HasSubstr("does not exist")));
  fs::create_directory(folder / "dir.gpkg");
  EXPECT_THAT(open(folder / "dir.gpkg"), ThrowsMessage<InputError>(HasSubstr("is a folder")));
  MapMetadata bad = metadata;
  bad.resolution = 0;
  EXPECT_THROW(MapWriter(folder / "map.gpkg", bad), InputError);
  EXPECT_EQ(folder.CountFiles(), 1U);
}

TEST(MapFile, WriterRefusesWrongInput) {
  const support::TempFolder folder;
  const SmallMap map;
  MapWriter writer(folder / "map.gpkg", map.metadata);
  EXPECT_THROW(writer.AddImage(0, cv::Mat(48, 65, CV_8UC1)), InputError);
  EXPECT_THROW(writer.AddImage(0, cv::Mat(48, 64, CV_8UC3)), InputError);
  graph::MapGraph without_keyframes;
  without_keyframes.edges = map.edges;
  EXPECT_THROW(writer.WriteGraph(without_keyframes), InputError);
  writer.AddImage(3, synthetic::Image(3, map.metadata.view_size));
  EXPECT_THROW(writer.AddImage(3, synthetic::Image(3, map.metadata.view_size)), RunError);
}

TEST(MapFile, MosaicSourceMayThrow) {
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

/// Lets files of this process grow up to a limit only: the effect of a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);  // else the signal ends the process
    const rlimit limit{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

TEST(MapFile, FullDiskIsARunErrorAndLeavesTheOldMap) {
  const support::TempFolder folder;
  SmallMap map;
  map.Write(folder / "map.gpkg");
  map.metadata.robot = "another";
  const auto whole = static_cast<rlim_t>(fs::file_size(folder / "map.gpkg"));
  for (const rlim_t bytes : {rlim_t{0}, whole / 8, whole / 2, whole * 3 / 4, whole - 4096}) {
    SCOPED_TRACE(bytes);
    ::testing::internal::CaptureStderr();
    std::string message;
    {
      const FileSizeLimit limit(bytes);
      try {
        map.Write(folder / "map.gpkg");
      } catch (const RunError& error) {
        message = error.what();
      }
    }
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_THAT(message, HasSubstr("cannot write"));
    EXPECT_THAT(message, HasSubstr("map.gpkg"));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_EQ(folder.CountFiles(), 1U);
    EXPECT_EQ(MapReader(folder / "map.gpkg").Metadata().robot, "robot 1");
  }
}

}  // namespace
}  // namespace ceilmap::store
