#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/core.hpp>

#include "calib/base/error.hpp"
#include "mapping/store/block_store.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/file_server.hpp"
#include "tests/support/temp_folder.hpp"

/// Maps on a server.
namespace ceilmap::store {
namespace {

using support::FileServer;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::ThrowsMessage;

/// With a cache of its own, and short pauses between attempts.
class RemoteMap : public testing::Test {
 protected:
  RemoteMap() {
    setenv("CEILMAP_CACHE", (folder_ / "cache").c_str(), 1);
    setenv("GDAL_HTTP_MAX_RETRY", "2", 1);
    setenv("GDAL_HTTP_RETRY_DELAY", "0.01", 1);
    unsetenv("CEILMAP_CACHE_MB");
  }
  ~RemoteMap() override {
    for (const char* name :
         {"CEILMAP_CACHE", "CEILMAP_CACHE_MB", "GDAL_HTTP_MAX_RETRY", "GDAL_HTTP_RETRY_DELAY"}) {
      unsetenv(name);
    }
  }

  /// A map with the robot's name, descriptors and 2 MB of images.
  std::string Content(const std::string& robot = "robot 1") {
    static std::map<std::string, std::string> made;
    std::string& content = made[robot];
    if (content.empty()) content = MakeContent(robot);
    std::ofstream(folder_ / "map.gpkg", std::ios::binary) << content;
    return content;
  }
  std::string MakeContent(const std::string& robot) {
    synthetic::SmallMap small;
    small.metadata = synthetic::Metadata({320, 240}, 0.005);
    small.metadata.robot = robot;
    small.keyframes = synthetic::Lawnmower(9, 3, 0.1);
    {
      MapWriter writer(folder_ / "map.gpkg", small.metadata);
      for (const graph::Keyframe& keyframe : small.keyframes) {  // in turn, as `map` does
        writer.AddImage(keyframe.id, synthetic::Image(keyframe.id, small.metadata.view_size));
        writer.AddDescriptors(keyframe.id, Descriptors(keyframe.id));
      }
      writer.WriteGraph(small.Graph());
      writer.WriteMosaic(synthetic::kGrid, synthetic::FillMosaic);
      writer.Commit();
    }
    return FileServer::ContentOf(folder_ / "map.gpkg");
  }
  static cv::Mat Descriptors(std::int64_t id) {
    return cv::Mat(8, 66, CV_32FC1, cv::Scalar(0.25 + static_cast<double>(id)));
  }

  static std::string MessageOf(const std::function<void()>& action) {
    try {
      action();
    } catch (const RunError& error) {
      return std::string("run: ") + error.what();
    } catch (const InputError& error) {
      return std::string("input: ") + error.what();
    }
    return "none";
  }
  static std::string OpeningOf(const std::string& url) {
    return MessageOf([&] { const MapReader map(url); });
  }

  support::TempFolder folder_;
};

TEST_F(RemoteMap, ReadsAllAsFromTheFile) {
  FileServer server(Content());
  const MapReader here(folder_ / "map.gpkg");
  for (const std::string& name : {server.Url(), "/vsicurl/" + server.Url()}) {
    const MapReader there(name);
    EXPECT_TRUE(there.IsRemote());
    EXPECT_EQ(there.FileBytes(), here.FileBytes());
    EXPECT_EQ(there.Metadata().rig_yaml, here.Metadata().rig_yaml);
    EXPECT_EQ(there.ReadGraph().edges.size(), here.ReadGraph().edges.size());
    EXPECT_EQ(there.ReadTrajectory().back().covariance, here.ReadTrajectory().back().covariance);
    EXPECT_TRUE(synthetic::Same(there.ReadImage(5), here.ReadImage(5)));
    EXPECT_TRUE(synthetic::Same(there.ReadDescriptors(7), Descriptors(7)));
    cv::Mat grey;
    cv::Mat alpha;
    cv::Mat grey_here;
    there.ReadMosaic({200, 40, 300, 200}, grey, alpha);
    here.ReadMosaic({200, 40, 300, 200}, grey_here, alpha);
    EXPECT_TRUE(synthetic::Same(grey, grey_here));
    there.CheckCurrent();
  }
}

TEST_F(RemoteMap, ReadsOnlyWhatIsAskedFor) {
  setenv("CEILMAP_CACHE_MB", "0", 1);
  FileServer server(Content());
  const MapReader map(server.Url());
  cv::Mat grey;
  cv::Mat alpha;
  map.ReadMosaic({0, 0, 100, 100}, grey, alpha);
  EXPECT_LT(server.bytes, map.FileBytes() / 8);
  // Descriptors follow each other in the file.
  const std::size_t before = server.bytes;
  std::size_t wanted = 0;
  for (std::int64_t id = 0; id < 27; ++id) {
    const cv::Mat descriptors = map.ReadDescriptors(id);
    wanted += descriptors.total() * descriptors.elemSize();
  }
  EXPECT_LE(server.bytes - before, wanted + wanted / 2 + (64U << 10U));
}

TEST_F(RemoteMap, ReadsNothingTwice) {
  FileServer server(Content());
  (void)MapReader(server.Url()).ReadGraph();
  server.bytes = 0;
  (void)MapReader(server.Url()).ReadGraph();
  EXPECT_EQ(server.bytes, 16U << 10U) << "the check whether the map is the same";
}

TEST_F(RemoteMap, ForgetsAMapThatWasReplacedBetweenRuns) {
  FileServer server(Content());
  EXPECT_EQ(MapReader(server.Url()).Metadata().robot, "robot 1");
  server.Replace(Content("robot 2"), "\"2\"");
  EXPECT_EQ(MapReader(server.Url()).Metadata().robot, "robot 2");
}

TEST_F(RemoteMap, NoticesAMapThatIsReplacedDuringTheRun) {
  FileServer server(Content());
  const MapReader map(server.Url());
  server.Replace(Content("robot 2"), "\"2\"");
  const std::string expected =
      "run: " + server.Url() + ": was replaced on the server while it was read; run again";
  EXPECT_EQ(MessageOf([&] { (void)map.ReadImage(20); }), expected);
  // Nothing of the two is mixed afterwards, not even what could be read.
  EXPECT_EQ(MessageOf([&] { (void)map.ReadImage(21); }), expected);
  cv::Mat grey;
  cv::Mat alpha;
  EXPECT_EQ(MessageOf([&] { map.ReadMosaic({300, 100, 256, 200}, grey, alpha); }), expected);
  EXPECT_EQ(MessageOf([&] { map.CheckCurrent(); }), expected);
}

TEST_F(RemoteMap, NoticesAShorterMap) {
  FileServer server(Content());
  const MapReader map(server.Url());
  server.Replace(Content().substr(0, 50'000), "\"1\"");
  EXPECT_THAT(MessageOf([&] { (void)map.ReadImage(20); }), HasSubstr("was replaced on the server"));
}

TEST_F(RemoteMap, AsksAgainAfterFailuresAndTruncatedAnswers) {
  FileServer server(Content());
  const MapReader here(folder_ / "map.gpkg");
  server.failing = 2;
  const MapReader map(server.Url());
  server.truncated = 2;
  EXPECT_TRUE(synthetic::Same(map.ReadImage(12), here.ReadImage(12)));
  server.truncated = 3;
  EXPECT_THAT(MessageOf([&] { (void)map.ReadImage(25); }),
              StartsWith("run: " + server.Url() + ": cannot be read from the server, after 3 "));
}

TEST_F(RemoteMap, StopsWhenTheServerIsGone) {
  auto server = std::make_unique<FileServer>(Content());
  const std::string url = server->Url();
  const MapReader map(url);
  server.reset();
  const std::string message = MessageOf([&] { (void)map.ReadImage(20); });
  EXPECT_THAT(message, StartsWith("run: " + url + ": cannot be read from the server, after 3 "));
  EXPECT_THAT(message, Not(HasSubstr("\n")));
  EXPECT_THAT(OpeningOf(url), StartsWith("run: " + url + ": cannot be read from the server"));
}

TEST_F(RemoteMap, NamesWhatTheServerLacks) {
  FileServer server(Content());
  const std::string at = "input: " + server.Url() + ": ";
  server.ranges = false;
  EXPECT_THAT(OpeningOf(server.Url()), StartsWith(at + "the server does not send parts of a file"));
  server.ranges = true;
  server.Replace(Content(), "");
  EXPECT_THAT(OpeningOf(server.Url()), StartsWith(at + "the server sends neither ETag nor"));
  server.failing = 1;
  server.status = 404;
  EXPECT_EQ(OpeningOf(server.Url()),
            at + "the server has no such file (HTTP status 404); check the name");
  server.failing = 1;
  server.status = 403;
  EXPECT_THAT(OpeningOf(server.Url()),
              StartsWith(at + "the server does not allow to read it (HTTP status 403); give"));
}

TEST_F(RemoteMap, DoesNotShowPasswords) {
  FileServer server(Content());
  server.failing = 1;
  server.status = 404;
  const std::string message = OpeningOf(server.Url("ann:secret@") + "?signature=hidden");
  EXPECT_THAT(message, StartsWith("input: http://ann:***@127.0.0.1:"));
  EXPECT_THAT(message, Not(HasSubstr("hidden")));
}

TEST_F(RemoteMap, RefusesOtherFilesAndHostileMaps) {
  FileServer server("<html>", "\"1\"");
  EXPECT_EQ(OpeningOf(server.Url()),
            "input: " + server.Url() + ": is no GeoPackage; give a map made by 'ceilmap map'");
  const std::string content = Content();
  server.Replace(content.substr(0, content.size() / 2), "\"2\"");
  EXPECT_THAT(OpeningOf(server.Url()), HasSubstr(": is truncated; copy it again"));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "map.gpkg").c_str(), &database), SQLITE_OK);
  const char* const sql =
      "DROP TABLE gpkg_contents; CREATE VIEW gpkg_contents AS WITH RECURSIVE endless(x) AS "
      "(SELECT 1 UNION ALL SELECT x FROM endless) SELECT x FROM endless";
  ASSERT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  server.Replace(FileServer::ContentOf(folder_ / "map.gpkg"), "\"3\"");
  EXPECT_THAT(OpeningOf(server.Url()),
              HasSubstr(": has a view, 'gpkg_contents', which no map has"));
}

TEST_F(RemoteMap, IsNotWrittenTo) {
  EXPECT_EQ(MessageOf([] {
              const MapWriter writer("https://ann:secret@host/map.gpkg",
                                     synthetic::Metadata({64, 48}, 0.005));
            }),
            "input: https://ann:***@host/map.gpkg: a server is only read from; write a file here "
            "and copy it to the server");
}

TEST_F(RemoteMap, HasACacheOfLimitedSize) {
  const std::vector<unsigned char> block(1000, 7);
  const auto fill = [&](const std::string& name) {
    BlockStore store(folder_ / "small", 10'000);
    store.Use(name, "1");
    for (int i = 0; i < 8; ++i) store.Add(i, block);
  };
  const auto has = [&](const std::string& name, const std::string& version) {
    BlockStore store(folder_ / "small", 10'000);
    store.Use(name, version);
    return store.Find(3) == block;
  };
  fill("https://host/a.gpkg");
  EXPECT_TRUE(has("https://host/a.gpkg", "1"));
  fill("https://host/b.gpkg");
  EXPECT_TRUE(has("https://host/b.gpkg", "1"));
  EXPECT_FALSE(has("https://host/a.gpkg", "1")) << "it made room";
  EXPECT_FALSE(has("https://host/b.gpkg", "2"));
  EXPECT_FALSE(has("https://host/b.gpkg", "1")) << "one version of each";
}

TEST_F(RemoteMap, NeedsNoCache) {
  const std::string content = Content();
  FileServer server(content);
  std::ofstream(folder_ / "file") << "no folder";
  setenv("CEILMAP_CACHE", (folder_ / "file").c_str(), 1);
  EXPECT_EQ(MapReader(server.Url()).Metadata().robot, "robot 1");
  std::filesystem::create_directory(folder_ / "cache");
  std::ofstream(folder_ / "cache" / "maps.sqlite") << std::string(5000, 'x');
  setenv("CEILMAP_CACHE", (folder_ / "cache").c_str(), 1);
  EXPECT_EQ(MapReader(server.Url()).Metadata().robot, "robot 1");
  setenv("CEILMAP_CACHE_MB", "many", 1);
  EXPECT_EQ(OpeningOf(server.Url()),
            "input: " + server.Url() +
                ": CEILMAP_CACHE_MB is no number of megabytes; give one, or 0 for no cache");
}

}  // namespace
}  // namespace ceilmap::store
