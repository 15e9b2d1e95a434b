#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <zstd.h>

#include <random>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "tests/app/bags/mcap_bytes.hpp"
#include "tests/app/bags/read_bag.hpp"
#include "tests/support/sqlite_file.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {
namespace {

using support::kRosbag2Schema;
using support::kTables;
using support::kTwoTopics;
using support::SqliteFile;
using testing::ElementsAre;
using testing::IsEmpty;

std::string PackedByZstd(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 1));
  return packed;
}

class SqliteBagTest : public testing::Test {
 protected:
  std::filesystem::path Path(const std::string& name = "run_0.db3") const { return folder_ / name; }
  std::vector<std::string> Warnings(const BagReader& bag) const {
    std::vector<std::string> warnings = bag.Warnings();
    for (std::string& text : warnings) text = text.substr(folder_.Path().string().size() + 1);
    return warnings;
  }

  support::TestFolder folder_;
};

TEST_F(SqliteBagTest, ReadsInOrderOfTime) {
  SqliteFile(Path(), kRosbag2Schema + kTwoTopics).Add(1, 20, "b").Add(2, 10, "a").Add(1, 30, "c");
  ASSERT_TRUE(BagReader::IsBag(Path()));
  const auto bag = BagReader::Open(Path());
  ASSERT_EQ(bag->Topics().size(), 2U);
  EXPECT_EQ(bag->Topics()[0].name, "/odom");
  EXPECT_EQ(bag->Topics()[0].messages, 1);
  EXPECT_EQ(bag->Topics()[1].type, "sensor_msgs/msg/Image");
  EXPECT_EQ(bag->Topics()[1].encoding, MessageEncoding::kCdr);
  EXPECT_EQ(bag->Facts().format, "rosbag2 (SQLite)");
  EXPECT_EQ(bag->Facts().compression, "none");
  EXPECT_EQ(bag->Facts().first_ns, 10);
  EXPECT_EQ(bag->Facts().last_ns, 30);
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/odom 10 a", "/up 20 b", "/up 30 c"));
  bag->Select({1});
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 20 b", "/up 30 c"));
  bag->Select({});
  EXPECT_THAT(ReadAll(*bag), IsEmpty());
  EXPECT_THAT(bag->Warnings(), IsEmpty());
  EXPECT_THAT(folder_.Names(), ElementsAre("run_0.db3"));
}

TEST_F(SqliteBagTest, ReadsMessagesThatAreCompressed) {
  SqliteFile(Path(), kRosbag2Schema + kTwoTopics)
      .Add(1, 1, PackedByZstd("first"))
      .Add(1, 2, PackedByZstd("second").substr(0, 12))
      .Add(1, 3, PackedByZstd("third"));
  const auto bag = BagReader::Open(Path());
  EXPECT_EQ(bag->Facts().compression, "zstd");
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 first", "/up 3 third"));
  EXPECT_THAT(Warnings(*bag),
              ElementsAre("run_0.db3: messages of '/up' are skipped: one cannot be decompressed"));
}

TEST_F(SqliteBagTest, ReadsAsWrittenWithoutAnIndexOfTimes) {
  SqliteFile(Path(), kTables + kTwoTopics).Add(1, 20, "b").Add(2, 10, "a");
  EXPECT_THAT(ReadAll(*BagReader::Open(Path())), ElementsAre("/up 20 b", "/odom 10 a"));
}

TEST_F(SqliteBagTest, SaysWhatItSkips) {
  SqliteFile(Path(), kRosbag2Schema + kTwoTopics + "INSERT INTO messages VALUES(9, 1, 5, NULL);")
      .Add(7, 1, "x")
      .Add(1, 2, "a");
  support::TestFolder other;
  const auto bag = BagReader::Open(Path());
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 2 a"));
  EXPECT_THAT(Warnings(*bag),
              ElementsAre("run_0.db3: messages of topic 7, which is not in its table, are skipped",
                          "run_0.db3: has messages without data, which are skipped"));
}

TEST_F(SqliteBagTest, MentionsAnUnfinishedRecording) {
  SqliteFile(Path(), kRosbag2Schema + kTwoTopics).Add(1, 2, "a");
  folder_.Write("run_0.db3-wal", "pages");
  EXPECT_THAT(Warnings(*BagReader::Open(Path())),
              ElementsAre("run_0.db3: its recording was not finished; messages in the file beside "
                          "it that ends in '-wal' are not read, unless you run: sqlite3 FILE "
                          "'PRAGMA wal_checkpoint'"));
}

TEST_F(SqliteBagTest, RefusesOtherDatabases) {
  const std::string start = ": is no rosbag2 recording that can be read (";
  SqliteFile(Path("a.db3"), "CREATE TABLE other(id);");
  EXPECT_EQ(ErrorOf(Path("a.db3")), Path("a.db3").string() + start + "it has no table 'topics')");
  SqliteFile(Path("b.db3"),
             "CREATE TABLE topics(id, name, type, serialization_format);"
             "CREATE VIEW messages AS SELECT 1 AS topic_id;");
  EXPECT_EQ(ErrorOf(Path("b.db3")),
            Path("b.db3").string() + start + "'messages' is no plain table)");
  SqliteFile(Path("c.db3"), "CREATE TABLE topics(id); CREATE TABLE messages(id);");
  EXPECT_EQ(ErrorOf(Path("c.db3")), Path("c.db3").string() + start + "no such column: name)");
  SqliteFile(Path("map.gpkg"), "PRAGMA application_id=1196444487; CREATE TABLE topics(id);");
  EXPECT_FALSE(BagReader::IsBag(Path("map.gpkg")));
}

TEST_F(SqliteBagTest, ReadsWhatIsLeftOfADamagedFile) {
  {
    SqliteFile file(Path(), kRosbag2Schema + kTwoTopics);
    for (int i = 0; i < 100; ++i) file.Add(1, i, std::string(3000, 'x'));
  }
  const std::string bytes = support::ReadAll(Path());
  constexpr std::size_t kPageBytes = 4096;
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); size += kPageBytes / 2) {
    std::filesystem::remove(Path("cut.db3"));  // faster than to write it anew
    const auto cut = folder_.Write("cut.db3", bytes.substr(0, size));
    std::size_t messages = 0;
    try {
      const auto bag = BagReader::Open(cut);
      messages = ReadAll(*bag).size();
      EXPECT_FALSE(bag->Warnings().empty()) << size;
    } catch (const InputError&) {
      EXPECT_LT(size, 8 * kPageBytes);
    }
    most = std::max(most, messages);
  }
  EXPECT_GE(most, 90U);
}

class FolderBagTest : public SqliteBagTest {
 protected:
  void WriteMetadata(const std::string& files) {
    folder_.Write("metadata.yaml",
                  "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
                  "  relative_file_paths: [" +
                      files + "]\n  compression_mode: file\n");
  }
};

TEST_F(FolderBagTest, ReadsSplitFilesInOrderOfTime) {
  SqliteFile(Path("b.db3"), kRosbag2Schema + kTwoTopics).Add(1, 30, "d").Add(2, 50, "f");
  SqliteFile(Path("a.db3"), kRosbag2Schema + kTwoTopics).Add(2, 10, "a").Add(1, 40, "e");
  folder_.Write("c.mcap",
                bytes::McapFile(bytes::McapSchema(1, "nav_msgs/msg/Odometry") +
                                    bytes::McapChannel(1, 1, "/odom") +
                                    bytes::McapMessage(1, 20, "b") + bytes::McapMessage(1, 25, "c"),
                                ""));
  WriteMetadata("b.db3, run/a.db3, c.mcap, b.db3");
  ASSERT_TRUE(BagReader::IsBag(folder_.Path()));
  const auto bag = BagReader::Open(folder_.Path());
  ASSERT_EQ(bag->Topics().size(), 2U);
  EXPECT_EQ(bag->Topics()[0].name, "/odom");
  EXPECT_EQ(bag->Topics()[0].messages, 4);
  EXPECT_EQ(bag->Topics()[1].messages, 2);
  EXPECT_EQ(bag->Facts().format, "rosbag2 (MCAP, 3 files)");
  EXPECT_EQ(bag->Facts().first_ns, 10);
  EXPECT_EQ(bag->Facts().last_ns, 50);
  const auto all =
      ElementsAre("/odom 10 a", "/odom 20 b", "/odom 25 c", "/up 30 d", "/up 40 e", "/odom 50 f");
  EXPECT_THAT(ReadAll(*bag), all);
  bag->Select({1});
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 30 d", "/up 40 e"));
  bag->Select({0, 1});
  EXPECT_THAT(ReadAll(*bag), all);
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(FolderBagTest, ReadsFilesThatAreCompressed) {
  std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): the same each time
  std::string large(400'000, ' ');
  for (char& c : large) c = static_cast<char>(random());
  SqliteFile(Path("a.db3"), kRosbag2Schema + kTwoTopics).Add(1, 10, "a").Add(1, 11, large);
  const std::string packed = PackedByZstd(support::ReadAll(Path("a.db3")));
  std::filesystem::remove(Path("a.db3"));
  folder_.Write("a.db3.zstd", packed);
  WriteMetadata("a.db3");
  const auto bag = BagReader::Open(folder_.Path());
  EXPECT_EQ(bag->Facts().compression, "zstd");
  EXPECT_TRUE(ReadAll(*bag) == std::vector<std::string>({"/up 10 a", "/up 11 " + large}));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
  folder_.Write("cut.db3.zstd", packed.substr(0, packed.size() - 100'000));
  const auto cut = BagReader::Open(Path("cut.db3.zstd"));
  EXPECT_THAT(ReadAll(*cut), ElementsAre("/up 10 a"));
  EXPECT_THAT(
      Warnings(*cut),
      testing::Contains("cut.db3.zstd: is cut off or damaged; what can be decompressed is used"));
}

TEST_F(FolderBagTest, SaysWhatIsMissing) {
  WriteMetadata("a.db3, b.db3");
  EXPECT_EQ(ErrorOf(folder_.Path()),
            Path("metadata.yaml").string() +
                ": names no file that exists; 'ros2 bag reindex' writes it anew");
  SqliteFile(Path("a.db3"), kRosbag2Schema + kTwoTopics).Add(1, 10, "a");
  folder_.Write("b.db3", "text");
  WriteMetadata("a.db3, b.db3, c.db3");
  EXPECT_THAT(Warnings(*BagReader::Open(folder_.Path())),
              ElementsAre("metadata.yaml: names 'c.db3', which is missing",
                          "b.db3: is no bag; must be MCAP, rosbag2 (.db3 or its folder with "
                          "metadata.yaml) or ROS 1"));
  folder_.Write("metadata.yaml", "rosbag2_bagfile_information: {version: 5}");
  EXPECT_EQ(ErrorOf(folder_.Path()),
            Path("metadata.yaml").string() +
                ":1: rosbag2_bagfile_information.relative_file_paths is missing, must be given; "
                "add it; 'ros2 bag reindex' writes it anew");
}

}  // namespace
}  // namespace ceilmap::bags
