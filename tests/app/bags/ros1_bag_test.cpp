#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "tests/app/bags/read_bag.hpp"
#include "tests/app/bags/ros1_bytes.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {
namespace {

using namespace bytes;  // NOLINT: composes files
using testing::ElementsAre;
using testing::IsEmpty;

const std::string kConnections =
    Ros1Connection(0, "/up", "sensor_msgs/Image") + Ros1Connection(5, "/tf", "tf/tfMessage");

std::string PackBz2(const std::string& text) {
  std::string packed(text.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  std::string in = text;
  const int result = BZ2_bzBuffToBuffCompress(
      packed.data(), &size, in.data(), static_cast<unsigned>(in.size()), 9, 0, 0);
  EXPECT_EQ(result, BZ_OK);
  return packed.substr(0, size);
}

std::string PackLz4Frame(const std::string& text) {
  std::string packed(LZ4F_compressFrameBound(text.size(), nullptr), '\0');
  packed.resize(
      LZ4F_compressFrame(packed.data(), packed.size(), text.data(), text.size(), nullptr));
  return packed;
}

class Ros1BagTest : public testing::Test {
 protected:
  std::unique_ptr<BagReader> Open(const std::string& bytes) {
    std::filesystem::remove(folder_ / "run.bag");  // faster than to write it anew
    return BagReader::Open(folder_.Write("run.bag", bytes));
  }
  static std::vector<std::string> Warnings(const BagReader& bag) {
    std::vector<std::string> warnings = bag.Warnings();
    for (std::string& text : warnings) text = text.substr(text.find("run.bag"));
    return warnings;
  }

  support::TestFolder folder_;
};

// Two chunks, of which the later is stored first.
struct IndexedRos1 {
  std::string late = Ros1Chunk(kConnections + Ros1Message(0, 3'000'000'001, "c"));
  std::string early = Ros1Chunk("lz4",
                                (Ros1Message(5, 2, "b") + Ros1Message(0, 1, "a")).size(),
                                PackLz4Frame(Ros1Message(5, 2, "b") + Ros1Message(0, 1, "a")));
  std::size_t late_at = Ros1DataAt();
  std::string index = kConnections +
                      Ros1ChunkInfo(late_at, 3'000'000'001, 3'000'000'001, U32(0) + U32(1)) +
                      Ros1ChunkInfo(late_at + late.size(), 1, 2, U32(0) + U32(1) + U32(5) + U32(1));
  std::string bytes = Ros1File(late + early, index, 2, 2);
};

TEST_F(Ros1BagTest, ReadsByItsIndexInOrderOfTime) {
  const auto bag = Open(IndexedRos1().bytes);
  ASSERT_EQ(bag->Topics().size(), 2U);
  EXPECT_EQ(bag->Topics()[0].name, "/tf");
  EXPECT_EQ(bag->Topics()[0].type, "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(bag->Topics()[0].encoding, MessageEncoding::kRos1);
  EXPECT_EQ(bag->Topics()[0].messages, 1);
  EXPECT_EQ(bag->Topics()[1].type, "sensor_msgs/msg/Image");
  EXPECT_EQ(bag->Topics()[1].messages, 2);
  EXPECT_EQ(bag->Facts().format, "ROS 1 bag");
  EXPECT_EQ(bag->Facts().first_ns, 1);
  EXPECT_EQ(bag->Facts().last_ns, 3'000'000'001);
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a", "/tf 2 b", "/up 3000000001 c"));
  bag->Select({0});
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/tf 2 b"));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(Ros1BagTest, ReadsARecordingThatWasNotFinished) {
  const IndexedRos1 file;
  const auto bag = Open(Ros1ActiveFile(file.late + file.early));
  EXPECT_EQ(bag->Facts().compression, "lz4");
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a", "/tf 2 b", "/up 3000000001 c"));
  EXPECT_THAT(Warnings(*bag),
              ElementsAre("run.bag: has no index, as its recording was not finished; the whole "
                          "file was read instead"));
}

TEST_F(Ros1BagTest, ReadsBz2) {
  const std::string data(1'000'000, 'x');  // becomes some tens of bytes
  const std::string records = kConnections + Ros1Message(0, 1, data);
  const auto bag = Open(Ros1ActiveFile(Ros1Chunk("bz2", records.size(), PackBz2(records))));
  EXPECT_EQ(bag->Facts().compression, "bz2");
  EXPECT_TRUE(ReadAll(*bag) == std::vector<std::string>({"/up 1 " + data}));
  EXPECT_EQ(bag->Warnings().size(), 1U);
}

// The recorder writes the sizes of a chunk when it is full: an open one states none.
TEST_F(Ros1BagTest, ReadsAChunkThatWasNotClosed) {
  const auto bag = Open(Ros1ActiveFile(Ros1Chunk("") + kConnections + Ros1Message(0, 1, "a") +
                                       Ros1Message(5, 2, "b")));
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a", "/tf 2 b"));
}

TEST_F(Ros1BagTest, SalvagesAFileThatIsCutAnywhere) {
  const std::string loose = kConnections + Ros1Message(0, 1, "a");
  const std::string last = Ros1Message(5, 3, "c");
  const std::string chunk = Ros1Chunk(Ros1Message(0, 2, "b") + last);
  const std::string bytes = Ros1ActiveFile(loose + chunk);
  for (std::size_t size = kRos1Magic.size(); size <= bytes.size(); ++size) {
    const auto bag = Open(bytes.substr(0, size));
    std::vector<std::string> expected;
    if (size >= Ros1DataAt() + loose.size()) expected.emplace_back("/up 1 a");
    if (size >= bytes.size() - last.size()) expected.emplace_back("/up 2 b");
    if (size == bytes.size()) expected.emplace_back("/tf 3 c");
    ASSERT_EQ(ReadAll(*bag), expected) << size;
    ASSERT_EQ(bag->Warnings().size(), 1U) << size;
  }
}

TEST_F(Ros1BagTest, RebuildsAnIndexThatIsDamaged) {
  const IndexedRos1 file;
  const std::string data = file.late + file.early;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {Ros1File(data, file.index.substr(0, file.index.size() - 1), 2, 2), ""},
      {Ros1File(data, file.index, 2, 1), "its index has more or fewer records than stated"},
      {Ros1File(data, Ros1Connection(0, "/up", "sensor_msgs/Image") + file.index, 2, 2),
       "its index has more or fewer records than stated"},
      {Ros1File(data,
                kConnections + Ros1ChunkInfo(file.late_at, 1, 2, "") +
                    Ros1ChunkInfo(file.late_at, 1, 2, ""),
                2,
                2),
       "its index names chunks outside of the data, or twice"},
      {Ros1File(data, kConnections + Ros1ChunkInfo(1, 1, 2, U32(9) + U32(1)), 2, 1),
       "its index does not define connection 9"},
  };
  for (const auto& [bytes, problem] : cases) {
    const auto bag = Open(bytes);
    EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a", "/tf 2 b", "/up 3000000001 c")) << problem;
    ASSERT_EQ(bag->Warnings().size(), 1U);
    if (!problem.empty()) {
      EXPECT_EQ(Warnings(*bag)[0], "run.bag: " + problem + "; the whole file was read instead");
    }
  }
}

TEST_F(Ros1BagTest, SaysWhatItSkips) {
  const std::string good = Ros1Chunk(kConnections + Ros1Message(0, 1, "a"));
  const auto at = [&](const std::string& before) {
    return std::to_string(Ros1DataAt() + before.size());
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {Ros1Chunk("gzip", 1, "x"),
       "the chunk at byte " + at(good) +
           " is skipped: it is compressed by 'gzip', must be bz2, lz4 or none"},
      {Ros1Chunk("lz4", 0x40000000, "x"),
       "the chunk at byte " + at(good) + " is skipped: it states 1024 MB, more than 512"},
      {Ros1Chunk("lz4", 100000, "x"),
       "the chunk at byte " + at(good) +
           " is skipped: it states 100000 bytes, which 1 of lz4 cannot hold"},
      {Ros1Chunk(Ros1Message(8, 1, "z")),
       "messages of connection 8, which is not defined, are skipped"},
      {Ros1Connection(0, "/other", "sensor_msgs/Image"),
       "connection 0 is defined twice, as '/up' (sensor_msgs/msg/Image) and as '/other' "
       "(sensor_msgs/msg/Image); the first is used"},
      {Ros1Chunk("\xFF\xFF\xFF\xFF"),
       "the chunk at byte " + at(good) + " has a damaged record; the messages before it are used"},
  };
  for (const auto& [bytes, warning] : cases) {
    const auto bag = Open(Ros1ActiveFile(good + bytes));
    EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a")) << warning;
    EXPECT_THAT(Warnings(*bag), testing::Contains("run.bag: " + warning));
  }
}

TEST_F(Ros1BagTest, RefusesOtherVersions) {
  const auto file = folder_.Write("old.bag", "#ROSBAG V1.2\n");
  EXPECT_TRUE(BagReader::IsBag(file));
  EXPECT_EQ(ErrorOf(file),
            file.string() +
                ": is a ROS 1 bag of another version than 2.0; convert it with "
                "'rosbag fix' of ROS 1");
}

}  // namespace
}  // namespace ceilmap::bags
