// The contract of the file: complete or absent, shared by threads, replaced, refused.

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
using synthetic::Same;
using synthetic::SmallMap;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

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
