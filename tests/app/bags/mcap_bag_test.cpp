#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <string>
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

}  // namespace
}  // namespace ceilmap::bags
