#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>

/// Records of an MCAP file (https://mcap.dev/spec, version 0). A file is
///   magic, Header, data section, DataEnd, summary section, summary offset section, Footer, magic
/// and a record is its opcode (1 byte), the length of its content (8 bytes), and its content. All
/// numbers are little-endian; texts and maps begin with their length in bytes (4 bytes).
namespace ceilmap::bags::mcap {

inline constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

inline constexpr std::size_t kRecordHeadBytes = 9;    ///< opcode and length
inline constexpr std::size_t kMessageHeadBytes = 22;  ///< content of a Message before its data
inline constexpr std::size_t kFooterContentBytes = 20;
/// Before the summary's checksum: the last field of the Footer.
inline constexpr std::size_t kFooterChecksumBytes = 4;

/// Texts and spans are parts of the record.
struct Schema {
  std::uint16_t id = 0;
  std::string_view name;
  std::string_view encoding;
};
struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  std::string_view topic;
  std::string_view message_encoding;
};
struct MessageHead {
  std::uint16_t channel_id = 0;
  std::uint64_t log_time = 0;
};
struct ChunkHead {
  std::uint64_t first_time = 0;
  std::uint64_t last_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  ///< 0: none
  std::string_view compression;
  std::uint64_t records_size = 0;  ///< as stored
};
struct ChunkIndex {
  std::uint64_t first_time = 0;
  std::uint64_t last_time = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;                      ///< of the record with its head
  std::map<std::uint16_t, std::uint64_t> index;  ///< channels in it: offsets of MessageIndex
  std::string_view compression;
};
struct Statistics {
  std::uint64_t messages = 0;
  std::uint64_t first_time = 0;
  std::uint64_t last_time = 0;
  std::map<std::uint16_t, std::uint64_t> channels;  ///< number of messages
};
struct Footer {
  std::uint64_t summary_start = 0;  ///< 0: none
  std::uint32_t summary_crc = 0;    ///< 0: none; of the summary up to this field
};

/// @param content  of a record. @throws DamagedBytes when it ends early.
Schema ParseSchema(std::span<const std::uint8_t> content);
Channel ParseChannel(std::span<const std::uint8_t> content);
MessageHead ParseMessageHead(std::span<const std::uint8_t> content);
/// @param content  at least up to the records.
/// @param head_bytes  the length of what stands before the records.
ChunkHead ParseChunkHead(std::span<const std::uint8_t> content, std::size_t& head_bytes);
ChunkIndex ParseChunkIndex(std::span<const std::uint8_t> content);
Statistics ParseStatistics(std::span<const std::uint8_t> content);
Footer ParseFooter(std::span<const std::uint8_t> content);

/// CRC-32 (ISO 3309) of an MCAP file's checksums.
/// @param before  the checksum of the bytes before these.
std::uint32_t Checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

}  // namespace ceilmap::bags::mcap
