#include "app/bags/mcap_writer.hpp"

#include <lz4frame.h>
#include <zstd.h>

#include <numeric>
#include <string>

#include "app/bags/mcap_records.hpp"
#include "app/bags/message_types.hpp"
#include "calib/base/error.hpp"
#include "tests/app/bags/mcap_contents.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::bags {
namespace {

using mcap::Opcode;
using test::Bytes;
using test::Chunk;
using test::ChunkOf;
using test::CrcOf;
using test::Fields;
using test::McapFile;
using test::ReadBytes;
using test::Record;
using test::RecordsIn;

const Bytes kShort = {1, 2, 3};

// Two channels of one type and one without a schema, five messages, chunks of 2000 bytes.
void WriteSome(const std::filesystem::path& file, Compression compression) {
  McapWriter writer(file, {.compression = compression, .chunk_bytes = 2000});
  const auto a = writer.Add("/a", kCompressedImageType);
  const auto b = writer.Add("/b", kCompressedImageType);
  writer.Write(a, 20, kShort);
  writer.Write(b, 10, kShort);
  writer.Write(a, 30, Bytes(1990, 7));
  const auto c = writer.Add({.topic = "/c", .message_encoding = "json"});
  writer.Write(c, 40, kShort);
  writer.Write(a, 50, kShort);
  EXPECT_EQ(writer.Messages(), 5U);
  writer.Commit();
}

TEST(McapWriter, EmptyFileIsComplete) {
  const support::TestFolder folder;
  McapWriter(folder / "empty.mcap").Commit();
  const McapFile file(folder / "empty.mcap");
  EXPECT_EQ(Bytes(file.bytes.begin(), file.bytes.begin() + 8),
            (Bytes{0x89, 0x4D, 0x43, 0x41, 0x50, 0x30, 0x0D, 0x0A}));
  EXPECT_EQ(Bytes(file.bytes.end() - 8, file.bytes.end()),
            Bytes(file.bytes.begin(), file.bytes.begin() + 8));
  EXPECT_EQ(file.Opcodes(),
            (std::vector{Opcode::kHeader,
                         Opcode::kMetadata,
                         Opcode::kDataEnd,
                         Opcode::kStatistics,
                         Opcode::kMetadataIndex,
                         Opcode::kSummaryOffset,
                         Opcode::kSummaryOffset,
                         Opcode::kFooter}));
  Fields header(file.records[0].content);
  EXPECT_EQ(header.Text(), "ros2");
  EXPECT_THAT(header.Text(), testing::StartsWith("ceilmap "));
  Fields metadata(file.records[1].content);
  EXPECT_EQ(metadata.Text(), "rosbag2");
  EXPECT_EQ(metadata.Number(4), 4U + 10 + 4 + 6);
  EXPECT_EQ(metadata.Text(), "ROS_DISTRO");
  EXPECT_EQ(metadata.Text(), "humble");
  Fields index(file.records[4].content);
  EXPECT_EQ(index.Number(8), file.records[1].at);
  EXPECT_EQ(index.Number(8), file.records[1].End() - file.records[1].at);
  EXPECT_EQ(index.Text(), "rosbag2");
}

TEST(McapWriter, RecordsAreInTheOrderOfTheFormat) {
  const support::TestFolder folder;
  WriteSome(folder / "some.mcap", Compression::kNone);
  const McapFile file(folder / "some.mcap");
  EXPECT_EQ(file.Opcodes(),
            (std::vector{Opcode::kHeader,        Opcode::kMetadata,      Opcode::kChunk,
                         Opcode::kMessageIndex,  Opcode::kMessageIndex,  Opcode::kChunk,
                         Opcode::kMessageIndex,  Opcode::kChunk,         Opcode::kMessageIndex,
                         Opcode::kMessageIndex,  Opcode::kDataEnd,       Opcode::kSchema,
                         Opcode::kChannel,       Opcode::kChannel,       Opcode::kChannel,
                         Opcode::kStatistics,    Opcode::kMetadataIndex, Opcode::kChunkIndex,
                         Opcode::kChunkIndex,    Opcode::kChunkIndex,    Opcode::kSummaryOffset,
                         Opcode::kSummaryOffset, Opcode::kSummaryOffset, Opcode::kSummaryOffset,
                         Opcode::kSummaryOffset, Opcode::kFooter}));
}

TEST(McapWriter, ChunksHoldTheMessagesAsWritten) {
  const support::TestFolder folder;
  WriteSome(folder / "some.mcap", Compression::kNone);
  const McapFile file(folder / "some.mcap");
  std::vector<std::string> found;
  for (const Record& record : file.Of(Opcode::kChunk)) {
    const Chunk chunk = ChunkOf(record);
    EXPECT_EQ(chunk.compression, "");
    EXPECT_EQ(chunk.size, chunk.data.size());
    EXPECT_EQ(chunk.crc, CrcOf(chunk.data, 0, chunk.data.size()));
    found.push_back("chunk " + std::to_string(chunk.first) + " to " + std::to_string(chunk.last));
    for (const Record& inner : RecordsIn(chunk.data, 0, chunk.data.size())) {
      Fields fields(inner.content);
      if (inner.opcode == Opcode::kSchema) {
        EXPECT_EQ(fields.Number(2), 1U);
        EXPECT_EQ(fields.Text(), kCompressedImageType);
        EXPECT_EQ(fields.Text(), "ros2msg");
        EXPECT_EQ(fields.Text(), MessageDefinition(kCompressedImageType));
        found.emplace_back("schema");
      } else if (inner.opcode == Opcode::kChannel) {
        const std::string id = std::to_string(fields.Number(2));
        const std::string schema = std::to_string(fields.Number(2));
        const std::string topic = fields.Text();
        found.push_back("channel " + id + " " + schema + " " + topic + " " + fields.Text());
      } else {
        ASSERT_EQ(inner.opcode, Opcode::kMessage);
        std::string text = "message";
        for (const int size : {2, 4, 8, 8}) text += " " + std::to_string(fields.Number(size));
        const std::size_t length = inner.content.size() - fields.At();
        found.push_back(text + ": " + std::to_string(length) + " bytes");
        EXPECT_EQ(fields.Take(length), length == 1990 ? Bytes(1990, 7) : kShort);
      }
    }
  }
  EXPECT_EQ(found,
            (std::vector<std::string>{"chunk 10 to 20",
                                      "schema",
                                      "channel 1 1 /a cdr",
                                      "channel 2 1 /b cdr",
                                      "message 1 0 20 20: 3 bytes",
                                      "message 2 0 10 10: 3 bytes",
                                      "chunk 30 to 30",
                                      "message 1 1 30 30: 1990 bytes",
                                      "channel 3 0 /c json",
                                      "chunk 40 to 50",
                                      "message 3 0 40 40: 3 bytes",
                                      "message 1 2 50 50: 3 bytes"}));
}

TEST(McapWriter, IndexesPointToTheirRecords) {
  const support::TestFolder folder;
  WriteSome(folder / "some.mcap", Compression::kNone);
  const McapFile file(folder / "some.mcap");
  const auto chunks = file.Of(Opcode::kChunk);
  const auto indexes = file.Of(Opcode::kChunkIndex);
  ASSERT_EQ(indexes.size(), chunks.size());
  std::size_t messages = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const Chunk chunk = ChunkOf(chunks[i]);
    Fields fields(indexes[i].content);
    EXPECT_EQ(fields.Number(8), chunk.first);
    EXPECT_EQ(fields.Number(8), chunk.last);
    EXPECT_EQ(fields.Number(8), chunks[i].at);
    EXPECT_EQ(fields.Number(8), chunks[i].End() - chunks[i].at);
    const Bytes offsets = fields.Take(fields.Number(4));
    std::size_t end = chunks[i].End();
    for (Fields entry(offsets); !entry.AtEnd();) {
      const std::uint64_t channel = entry.Number(2);
      const auto at = entry.Number(8);
      EXPECT_EQ(at, end);  // one after the other
      const auto record = std::find_if(file.records.begin(),
                                       file.records.end(),
                                       [&](const Record& candidate) { return candidate.at == at; });
      ASSERT_NE(record, file.records.end());
      ASSERT_EQ(record->opcode, Opcode::kMessageIndex);
      end = record->End();
      Fields index(record->content);
      EXPECT_EQ(index.Number(2), channel);
      const Bytes places = index.Take(index.Number(4));
      for (Fields place(places); !place.AtEnd(); ++messages) {
        const std::uint64_t time = place.Number(8);
        const std::uint64_t offset = place.Number(8);
        const Bytes rest(chunk.data.begin() + static_cast<std::ptrdiff_t>(offset),
                         chunk.data.end());
        Fields message(rest);
        EXPECT_EQ(message.Number(1), static_cast<std::uint64_t>(Opcode::kMessage));
        message.Number(8);
        EXPECT_EQ(message.Number(2), channel);
        message.Number(4);
        EXPECT_EQ(message.Number(8), time);
      }
    }
    EXPECT_EQ(fields.Number(8), end - chunks[i].End());
    EXPECT_EQ(fields.Text(), "");
    EXPECT_EQ(fields.Number(8), chunk.data.size());
    EXPECT_EQ(fields.Number(8), chunk.size);
    EXPECT_TRUE(fields.AtEnd());
  }
  EXPECT_EQ(messages, 5U);
}

TEST(McapWriter, StatisticsCount) {
  const support::TestFolder folder;
  WriteSome(folder / "some.mcap", Compression::kZstd);
  const auto records = McapFile(folder / "some.mcap").Of(Opcode::kStatistics);
  ASSERT_EQ(records.size(), 1U);
  Fields fields(records[0].content);
  EXPECT_EQ(fields.Number(8), 5U);   // messages
  EXPECT_EQ(fields.Number(2), 1U);   // schemas
  EXPECT_EQ(fields.Number(4), 3U);   // channels
  EXPECT_EQ(fields.Number(4), 0U);   // attachments
  EXPECT_EQ(fields.Number(4), 1U);   // metadata
  EXPECT_EQ(fields.Number(4), 3U);   // chunks
  EXPECT_EQ(fields.Number(8), 10U);  // first time
  EXPECT_EQ(fields.Number(8), 50U);
  EXPECT_EQ(fields.Number(4), 30U);
  for (const std::uint64_t count : {3U, 1U, 1U}) {
    fields.Number(2);
    EXPECT_EQ(fields.Number(8), count);
  }
}

TEST(McapWriter, SummaryOffsetsAndChecksumsAreRight) {
  const support::TestFolder folder;
  WriteSome(folder / "some.mcap", Compression::kLz4);
  const McapFile file(folder / "some.mcap");
  const Record end = file.Of(Opcode::kDataEnd).at(0);
  EXPECT_EQ(Fields(end.content).Number(4), CrcOf(file.bytes, 0, end.at));

  const Record footer = file.records.back();
  Fields fields(footer.content);
  EXPECT_EQ(fields.Number(8), end.End());
  const auto offsets = file.Of(Opcode::kSummaryOffset);
  EXPECT_EQ(fields.Number(8), offsets.at(0).at);
  EXPECT_EQ(fields.Number(4), CrcOf(file.bytes, end.End(), footer.at + 9 + 16));

  std::size_t at = end.End();
  for (const Record& offset : offsets) {
    Fields group(offset.content);
    const auto opcode = static_cast<Opcode>(group.Number(1));
    EXPECT_EQ(group.Number(8), at);
    const std::size_t group_end = at + group.Number(8);
    for (const Record& record : RecordsIn(file.bytes, at, group_end)) {
      EXPECT_EQ(record.opcode, opcode);
    }
    at = group_end;
  }
  EXPECT_EQ(at, offsets[0].at);
}

TEST(McapWriter, CompressedChunksHoldTheSameRecords) {
  const support::TestFolder folder;
  WriteSome(folder / "none.mcap", Compression::kNone);
  WriteSome(folder / "zstd.mcap", Compression::kZstd);
  WriteSome(folder / "lz4.mcap", Compression::kLz4);
  const auto plain = McapFile(folder / "none.mcap").Of(Opcode::kChunk);
  const auto zstd = McapFile(folder / "zstd.mcap").Of(Opcode::kChunk);
  const auto lz4 = McapFile(folder / "lz4.mcap").Of(Opcode::kChunk);
  ASSERT_EQ(zstd.size(), plain.size());
  ASSERT_EQ(lz4.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const Bytes expected = ChunkOf(plain[i]).data;
    const Chunk by_zstd = ChunkOf(zstd[i]);
    EXPECT_EQ(by_zstd.compression, "zstd");
    EXPECT_EQ(ZSTD_getFrameContentSize(by_zstd.data.data(), by_zstd.data.size()), expected.size());
    Bytes content(expected.size());
    EXPECT_EQ(
        ZSTD_decompress(content.data(), content.size(), by_zstd.data.data(), by_zstd.data.size()),
        expected.size());
    EXPECT_EQ(content, expected);

    const Chunk by_lz4 = ChunkOf(lz4[i]);
    EXPECT_EQ(by_lz4.compression, "lz4");
    LZ4F_dctx* context = nullptr;
    LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
    Bytes out(expected.size());
    std::size_t out_size = out.size();
    std::size_t in_size = by_lz4.data.size();
    EXPECT_EQ(
        LZ4F_decompress(context, out.data(), &out_size, by_lz4.data.data(), &in_size, nullptr), 0U);
    LZ4F_freeDecompressionContext(context);
    EXPECT_EQ(out_size, expected.size());
    EXPECT_EQ(out, expected);
  }
}

TEST(McapWriter, ChunksStayBelowTheirSizeUnlessAMessageIsLarger) {
  const support::TestFolder folder;
  McapWriter writer(folder / "t.mcap", {.compression = Compression::kNone, .chunk_bytes = 4096});
  const auto channel = writer.Add({.topic = "/c"});
  for (int i = 0; i < 500; ++i) writer.Write(channel, i, Bytes((i * 37) % 400, 1));
  writer.Write(channel, 500, Bytes(100'000, 2));
  writer.Write(channel, 501, kShort);
  writer.Commit();
  const auto chunks = McapFile(folder / "t.mcap").Of(Opcode::kChunk);
  ASSERT_GT(chunks.size(), 20U);
  for (std::size_t i = 0; i + 3 < chunks.size(); ++i) {
    EXPECT_LE(ChunkOf(chunks[i]).size, 4096U) << i;
    EXPECT_GT(ChunkOf(chunks[i]).size, 4096U - 500) << i;
  }
  EXPECT_LE(ChunkOf(chunks[chunks.size() - 3]).size, 4096U) << "closed for the large message";
  const Chunk large = ChunkOf(chunks[chunks.size() - 2]);
  EXPECT_EQ(large.size, 100'000U + 9 + 22);
  EXPECT_EQ(large.first, 500U);
}

TEST(McapWriter, FileIsAbsentUntilCommit) {
  const support::TestFolder folder;
  {
    McapWriter writer(folder / "t.mcap");
    writer.Write(writer.Add({.topic = "/c"}), 0, kShort);
    writer.Close();
    EXPECT_FALSE(std::filesystem::exists(folder / "t.mcap"));
  }
  EXPECT_EQ(support::NamesIn(folder.Path()), std::vector<std::string>{});
}

TEST(McapWriter, NegativeTimesAreRefused) {
  const support::TestFolder folder;
  McapWriter writer(folder / "t.mcap");
  const auto channel = writer.Add({.topic = "/c"});
  try {
    writer.Write(channel, -1'500'000'000, kShort);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(),
              (folder / "t.mcap").string() +
                  ": a time is negative (-1.500000 s), which a bag cannot hold");
  }
}

}  // namespace
}  // namespace ceilmap::bags
