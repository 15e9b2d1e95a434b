#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <string>
#include <utility>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/mcap_records.hpp"
#include "tests/app/bags/mcap_bytes.hpp"
#include "tests/app/bags/read_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {
namespace {

using namespace bytes;  // NOLINT: composes files
using testing::ElementsAre;
using testing::IsEmpty;

const std::string kDefinitions = McapSchema(1, "sensor_msgs/msg/Image") +
                                 McapSchema(2, "nav_msgs/msg/Odometry") + McapChannel(4, 1, "/up") +
                                 McapChannel(3, 2, "/odom");

std::uint32_t Crc(const std::string& text) {
  return mcap::Checksum({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::string PackZstd(const std::string& text) {
  std::string packed(ZSTD_compressBound(text.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 1));
  return packed;
}

std::string PackLz4(const std::string& text) {
  std::string packed(LZ4F_compressFrameBound(text.size(), nullptr), '\0');
  packed.resize(
      LZ4F_compressFrame(packed.data(), packed.size(), text.data(), text.size(), nullptr));
  return packed;
}

class McapBagTest : public testing::Test {
 protected:
  std::unique_ptr<BagReader> Open(const std::string& bytes) {
    std::filesystem::remove(folder_ / "run.mcap");  // faster than to write it anew
    return BagReader::Open(folder_.Write("run.mcap", bytes));
  }
  /// Warnings without the folder.
  static std::vector<std::string> Warnings(const BagReader& bag) {
    std::vector<std::string> warnings = bag.Warnings();
    for (std::string& text : warnings) text = text.substr(text.find("run.mcap"));
    return warnings;
  }

  support::TestFolder folder_;
};

// A file with two chunks that overlap in time, of which the later is stored first.
struct IndexedFile {
  std::string records_late = McapMessage(3, 30, "c") + McapMessage(4, 50, "e");
  std::string records_early =
      McapMessage(4, 20, "b") + McapMessage(4, 10, "a") + McapMessage(4, 40, "d");
  std::string late = McapChunk(30, 50, records_late, Crc(records_late));
  std::string early = McapChunk(10, 40, records_early, Crc(records_early));
  std::size_t late_at = kMcapMagic.size() + McapHeader().size() + kDefinitions.size();
  std::string summary = kDefinitions + McapStatistics(10, 50, {{3, 1}, {4, 4}}) +
                        McapChunkIndex(30, 50, late_at, late.size(), {3, 4}) +
                        McapChunkIndex(10, 40, late_at + late.size(), early.size(), {4});
  std::string bytes = McapFile(kDefinitions + late + early, summary);
};

TEST_F(McapBagTest, ReadsOverlappingChunksInOrderOfTime) {
  const auto bag = Open(IndexedFile().bytes);
  ASSERT_EQ(bag->Topics().size(), 2U);
  EXPECT_EQ(bag->Topics()[0].name, "/odom");
  EXPECT_EQ(bag->Topics()[0].type, "nav_msgs/msg/Odometry");
  EXPECT_EQ(bag->Topics()[0].encoding, MessageEncoding::kCdr);
  EXPECT_EQ(bag->Topics()[0].messages, 1);
  EXPECT_EQ(bag->Topics()[1].name, "/up");
  EXPECT_EQ(bag->Topics()[1].messages, 4);
  EXPECT_EQ(bag->Facts().format, "MCAP");
  EXPECT_EQ(bag->Facts().compression, "none");
  EXPECT_EQ(bag->Facts().first_ns, 10);
  EXPECT_EQ(bag->Facts().last_ns, 50);
  EXPECT_THAT(ReadAll(*bag),
              ElementsAre("/up 10 a", "/up 20 b", "/odom 30 c", "/up 40 d", "/up 50 e"));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(McapBagTest, ReadsSelectedTopicsFromTheStart) {
  const auto bag = Open(IndexedFile().bytes);
  (void)ReadAll(*bag);
  bag->Select({0});
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/odom 30 c"));
  bag->Select({});
  EXPECT_THAT(ReadAll(*bag), IsEmpty());
}

TEST_F(McapBagTest, ReadsTheSameWithoutASummary) {
  const IndexedFile file;
  const auto bag = Open(McapFile(kDefinitions + file.late + file.early, ""));
  EXPECT_EQ(bag->Topics()[1].messages, 4);
  EXPECT_THAT(ReadAll(*bag),
              ElementsAre("/up 10 a", "/up 20 b", "/odom 30 c", "/up 40 d", "/up 50 e"));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(McapBagTest, ReadsMessagesOutsideOfChunks) {
  const std::string one = McapMessage(4, 5, "x");
  const std::string other = McapMessage(3, 2, "y");
  const auto bag = Open(McapFile(kDefinitions + one + other, kDefinitions));
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/odom 2 y", "/up 5 x"));
}

TEST_F(McapBagTest, ReadsCompressedChunks) {
  const std::string one = McapMessage(4, 1, std::string(1000, 'z'));
  const std::string other = McapMessage(4, 2, std::string(1000, 'l'));
  const auto bag = Open(McapFile(kDefinitions + McapPackedChunk("zstd", one.size(), PackZstd(one)) +
                                     McapPackedChunk("lz4", other.size(), PackLz4(other)),
                                 ""));
  EXPECT_EQ(bag->Facts().compression, "lz4, zstd");
  EXPECT_THAT(ReadAll(*bag),
              ElementsAre("/up 1 " + std::string(1000, 'z'), "/up 2 " + std::string(1000, 'l')));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

// As a writer that streams compresses.
TEST_F(McapBagTest, ReadsFramesOfZstdThatDoNotStateTheirSize) {
  const std::string data(1'000'000, 'z');
  const std::string records = McapMessage(4, 1, data);
  std::string packed(ZSTD_compressBound(records.size()), '\0');
  ZSTD_CCtx* const context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  packed.resize(
      ZSTD_compress2(context, packed.data(), packed.size(), records.data(), records.size()));
  ZSTD_freeCCtx(context);
  const auto bag =
      Open(McapFile(kDefinitions + McapPackedChunk("zstd", records.size(), packed), ""));
  EXPECT_TRUE(ReadAll(*bag) == std::vector<std::string>({"/up 1 " + data}));
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(McapBagTest, SkipsAChunkWithAnotherChecksum) {
  IndexedFile file;
  file.bytes[file.bytes.find("c", file.late_at + 60)] = 'C';
  const auto bag = Open(file.bytes);
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 10 a", "/up 20 b", "/up 40 d"));
  EXPECT_THAT(Warnings(*bag),
              ElementsAre("run.mcap: the chunk at byte " + std::to_string(file.late_at) +
                          " is skipped: it has another checksum than stated"));
}

// Whatever the place of the cut: no crash, and all messages before it.
TEST_F(McapBagTest, SalvagesAFileThatIsCutAnywhere) {
  const std::string first = McapMessage(4, 1, "a");
  const std::string records = McapMessage(4, 2, "b") + McapMessage(3, 3, "c");
  const std::string data = kDefinitions + first + McapChunk(2, 3, records);
  const std::string bytes = McapFile(data, "");
  const std::size_t start = kMcapMagic.size() + McapHeader().size() + kDefinitions.size();
  const std::size_t first_end = start + first.size();
  const std::size_t chunk_end = first_end + McapChunk(2, 3, records).size();
  constexpr std::size_t kHeadBytes = 9;  // of the end of the data
  const std::size_t second_end = chunk_end - McapMessage(3, 3, "c").size();
  for (std::size_t size = kMcapMagic.size(); size < bytes.size(); ++size) {
    const auto bag = Open(bytes.substr(0, size));
    std::vector<std::string> expected;
    if (size >= first_end) expected.emplace_back("/up 1 a");
    if (size >= second_end) expected.emplace_back("/up 2 b");
    if (size >= chunk_end) expected.emplace_back("/odom 3 c");
    ASSERT_EQ(ReadAll(*bag), expected) << size;
    ASSERT_EQ(bag->Warnings().size(), size < chunk_end + kHeadBytes ? 1U : 0U) << size;
  }
}

TEST_F(McapBagTest, SaysWhereACutFileEnds) {
  const std::string bytes = kMcapMagic + McapHeader() + kDefinitions + McapMessage(4, 1, "a");
  const auto bag = Open(bytes + McapMessage(4, 2, "b").substr(0, 20));
  EXPECT_THAT(
      Warnings(*bag),
      ElementsAre("run.mcap: is cut off or damaged at byte " + std::to_string(bytes.size()) +
                  " of " + std::to_string(bytes.size() + 20) + "; the 1 messages before are used"));
}

// A chunk or a definition after a good one, and what is said of it.
struct Skipped {
  std::string name;
  std::string record;
  std::string warning;  // %: the place of the record
};

const std::vector<Skipped> kSkipped = {
    {"UnknownCompression",
     McapPackedChunk("brotli", 1, "x"),
     "the chunk at byte % is skipped: it is compressed by 'brotli', must be zstd, lz4 or none"},
    {"StatesTooMuch",
     McapPackedChunk("zstd", 0x40000000, std::string(100000, 'x')),
     "the chunk at byte % is skipped: it states 1024 MB, more than 512"},
    {"StatesMoreThanItCanHold",
     McapPackedChunk("lz4", 500'000'000, "bomb"),
     "the chunk at byte % is skipped: it states 500000000 bytes, which 4 of lz4 cannot hold"},
    {"FrameStatesAnotherSize",
     McapPackedChunk("zstd", 5, PackZstd("more than five bytes")),
     "the chunk at byte % is skipped: it states 5 bytes, but its frame 20"},
    {"IsNoFrame",
     McapPackedChunk("zstd", 100, "no frame"),
     "the chunk at byte % is damaged; what comes before the damage is used"},
    {"RecordBeyondTheEnd",
     McapChunk(1, 1, U8(5) + U64(0xFFFFFFFFFFFFFFFF)),
     "the chunk at byte % has a damaged record; the messages before it are used"},
    {"RecordsBeyondTheChunk",
     McapRecord(0x06, U64(0) + U64(0) + U64(9) + U32(0) + Text("") + U64(0xFFFFFFFFFFFFFFFF)),
     "the chunk at byte % is skipped: it has another length than its content"},
    {"HeadIsCut",
     McapRecord(0x06, U64(0)),
     "the chunk at byte % is skipped: it has a field that goes beyond its record"},
    {"UnknownChannel",
     McapMessage(77, 9, "z"),
     "messages of channel 77, which is not defined, are skipped"},
    {"ChannelTwice",
     McapChannel(4, 1, "/other"),
     "channel 4 is defined twice, as '/up' (sensor_msgs/msg/Image) and as '/other' "
     "(sensor_msgs/msg/Image); the first is used"},
    {"SchemaTwice",
     McapSchema(1, "sensor_msgs/msg/Imu"),
     "schema 1 is defined twice, as 'sensor_msgs/msg/Image' and as 'sensor_msgs/msg/Imu'; the "
     "first is used"},
    {"TopicWithoutSchema",
     McapChannel(9, 0, "/bare"),
     "topic '/bare' has no schema, so that its type is not known"},
};

class McapSkipTest : public McapBagTest, public testing::WithParamInterface<Skipped> {};

TEST_P(McapSkipTest, SaysWhatIsWrongAndGoesOn) {
  const std::string good = kDefinitions + McapMessage(4, 1, "a");
  const std::size_t at = kMcapMagic.size() + McapHeader().size() + good.size();
  const auto bag = Open(McapFile(good + GetParam().record + McapMessage(4, 2, "b"), ""));
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/up 1 a", "/up 2 b"));
  std::string warning = "run.mcap: " + GetParam().warning;
  const std::size_t place = warning.find('%');
  if (place != std::string::npos) warning.replace(place, 1, std::to_string(at));
  EXPECT_THAT(Warnings(*bag), ElementsAre(warning));
}

INSTANTIATE_TEST_SUITE_P(Damage, McapSkipTest, testing::ValuesIn(kSkipped), [](const auto& test) {
  return test.param.name;
});

// Whatever is wrong with the index, the messages are those of the file.
TEST_F(McapBagTest, RebuildsAnIndexThatIsDamaged) {
  const IndexedFile file;
  const std::string data = kDefinitions + file.late + file.early;
  const std::string late = McapChunkIndex(30, 50, file.late_at, file.late.size(), {3, 4});
  const std::vector<std::pair<std::string, std::string>> cases = {
      {kDefinitions + late + late, "its index names a chunk twice"},
      {kDefinitions + McapChunkIndex(30, 50, file.late_at, 1U << 30U, {3, 4}),
       "its index names a chunk outside of the data"},
      {kDefinitions + McapChunkIndex(30, 50, 0, file.late.size(), {3, 4}),
       "its index names a chunk outside of the data"},
      {late, "its index does not define channel 3"},
      {kDefinitions + late + McapStatistics(1, 2, {{55, 1}}),
       "its index does not define channel 55"},
      {kDefinitions + late + U8(8) + U64(1000), "has a field that goes beyond its record"},
  };
  for (const auto& [summary, problem] : cases) {
    const auto bag = Open(McapFile(data, summary));
    EXPECT_EQ(ReadAll(*bag).size(), 5U) << problem;
    EXPECT_THAT(Warnings(*bag),
                ElementsAre("run.mcap: " + problem + "; the whole file was read instead"));
  }
  // A summary that has another checksum, or lies outside of the file.
  const std::string start = kMcapMagic + McapHeader() + data + McapDataEnd();
  const auto changed = Open(start + file.summary + McapFooter(start.size(), 7) + kMcapMagic);
  EXPECT_EQ(ReadAll(*changed).size(), 5U);
  EXPECT_THAT(
      Warnings(*changed),
      ElementsAre("run.mcap: its index has another checksum than stated; the whole file was "
                  "read instead"));
  const auto outside = Open(start + McapFooter(0xFFFFFFFFFFFFFFFF) + kMcapMagic);
  EXPECT_EQ(ReadAll(*outside).size(), 5U);
  EXPECT_THAT(Warnings(*outside),
              ElementsAre("run.mcap: its footer names no place of an index; the whole file was "
                          "read instead"));
}

TEST_F(McapBagTest, AcceptsTheChecksumOfTheSummary) {
  const IndexedFile file;
  const std::string start =
      kMcapMagic + McapHeader() + kDefinitions + file.late + file.early + McapDataEnd();
  const std::string footer = McapFooter(start.size());
  const std::uint32_t crc = Crc(file.summary + footer.substr(0, footer.size() - 4));
  const auto bag = Open(start + file.summary + McapFooter(start.size(), crc) + kMcapMagic);
  EXPECT_EQ(ReadAll(*bag).size(), 5U);
  EXPECT_THAT(bag->Warnings(), IsEmpty());
}

TEST_F(McapBagTest, SkipsAChunkThatIsNotWhereTheIndexSays) {
  const IndexedFile file;
  const std::string data = kDefinitions + file.late + file.early;
  const auto bag =
      Open(McapFile(data,
                    kDefinitions + McapChunkIndex(10, 40, file.late_at - 20, 15, {4}) +
                        McapChunkIndex(30, 50, file.late_at, file.late.size(), {3, 4})));
  EXPECT_THAT(ReadAll(*bag), ElementsAre("/odom 30 c", "/up 50 e"));
  EXPECT_THAT(Warnings(*bag),
              ElementsAre("run.mcap: the chunk at byte " + std::to_string(file.late_at - 20) +
                          " is skipped: it is no chunk"));
}

// Chunks of 30 MB that all overlap: they do not fit into the memory that the reader takes, and are
// read again.
TEST_F(McapBagTest, MergesMoreChunksThanFitIntoMemory) {
  constexpr std::size_t kPadding = std::size_t{30} << 20U;
  constexpr int kChunks = 8;
  std::string data = kDefinitions;
  const std::size_t start = kMcapMagic.size() + McapHeader().size();
  std::string summary = kDefinitions;
  std::vector<std::string> expected;
  for (int i = 0; i < kChunks; ++i) {
    std::string records = McapMessage(4, 1 + i, "first") + McapMessage(4, 101 + i, "second") +
                          McapRecord(0x7F, std::string(kPadding, 'p'));
    const std::string chunk = McapPackedChunk("zstd", records.size(), PackZstd(records));
    summary += McapChunkIndex(1 + i, 101 + i, start + data.size(), chunk.size(), {4});
    data += chunk;
    expected.push_back("/up " + std::to_string(1 + i) + " first");
  }
  for (int i = 0; i < kChunks; ++i)
    expected.push_back("/up " + std::to_string(101 + i) + " second");
  const auto bag = Open(McapFile(data, summary));
  EXPECT_EQ(ReadAll(*bag), expected);
}

TEST_F(McapBagTest, TranslatesTheTypesOfRos1) {
  const auto bag =
      Open(McapFile(McapSchema(1, "tf/tfMessage", "ros1msg") + McapChannel(1, 1, "/tf", "ros1") +
                        McapSchema(2, "Pose") + McapChannel(2, 2, "/pose", "json"),
                    ""));
  ASSERT_EQ(bag->Topics().size(), 2U);
  EXPECT_EQ(bag->Topics()[0].type, "Pose");
  EXPECT_EQ(bag->Topics()[0].encoding, MessageEncoding::kOther);
  EXPECT_EQ(bag->Topics()[1].type, "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(bag->Topics()[1].encoding, MessageEncoding::kRos1);
}

TEST_F(McapBagTest, RefusesWhatIsNoBag) {
  const std::string end =
      ": is no bag; must be MCAP, rosbag2 (.db3 or its folder with metadata.yaml) or ROS 1";
  const auto text = folder_.Write("a.txt", "text");
  EXPECT_FALSE(BagReader::IsBag(text));
  EXPECT_EQ(ErrorOf(text), text.string() + end);
  EXPECT_EQ(ErrorOf(folder_.Path()), folder_.Path().string() + end);
  EXPECT_EQ(ErrorOf(folder_ / "none"), (folder_ / "none").string() + ": no such file");
}

}  // namespace
}  // namespace ceilmap::bags
