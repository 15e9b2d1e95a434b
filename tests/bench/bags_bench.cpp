// Bags: the speed and the memory of reading, and checksums of all images for comparison with other
// readers.
//   ceilmap_bags_bench write BAG GB     a recording of 1.9 MP images, 200 IMU messages a second and
//                                       odometry; .mcap (in chunks), .bag (ROS 1) or .db3 (rosbag2)
//   ceilmap_bags_bench read BAG         MB/s of three passes, the peak of the memory
//   ceilmap_bags_bench checksums BAG    a line for each image: topic, time, CRC-32 of the pixels as
//                                       grey and as BGR

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/image_decoding.hpp"
#include "app/bags/mcap_records.hpp"
#include "app/bags/message_error.hpp"
#include "app/bags/messages.hpp"
#include "tests/app/bags/mcap_bytes.hpp"
#include "tests/app/bags/ros1_bytes.hpp"
#include "tests/bench/median.hpp"
#include "tests/support/sqlite_file.hpp"

namespace ceilmap::bags {
namespace {

using support::kRosbag2Schema;
using support::SqliteFile;

constexpr std::uint64_t kNsPerS = 1'000'000'000;
constexpr std::uint32_t kWidth = 1600;
constexpr std::uint32_t kHeight = 1200;

/// A message of the simulated recording.
struct Written {
  std::uint16_t topic = 0;  // 1 image, 2 IMU
  std::uint64_t time_ns = 0;
  std::string data;
};

/// Thirty images a second with other pixels each, and seven other messages between two.
class Recording {
 public:
  explicit Recording(bytes::MessageBytes::Form form)
      : form_(form), pixels_(kWidth * kHeight, 'p') {}

  Written Next() {
    constexpr std::uint64_t kPeriodNs = kNsPerS / 240;
    const std::uint64_t time_ns = 1'700'000'000 * kNsPerS + count_ * kPeriodNs;
    bytes::MessageBytes message(form_);
    message.PutHeader(static_cast<std::int32_t>(time_ns / kNsPerS),
                      static_cast<std::uint32_t>(time_ns % kNsPerS),
                      "camera");
    const bool image = count_ % 8 == 0;
    if (image) {
      for (std::size_t i = 0; i < pixels_.size(); i += 64)
        pixels_[i] = static_cast<char>(count_ + i);
      message.Put(kHeight).Put(kWidth).PutText("mono8").Put(std::uint8_t{0}).Put(kWidth);
      message.PutBytes(pixels_);
    } else {
      message.PutDoubles(std::vector<double>(37, 0.5));
    }
    ++count_;
    return {static_cast<std::uint16_t>(image ? 1 : 2), time_ns, message.Bytes()};
  }

 private:
  bytes::MessageBytes::Form form_;
  std::string pixels_;
  std::uint64_t count_ = 0;
};

void WriteMcap(const std::filesystem::path& path, std::uint64_t size) {
  const std::string definitions =
      bytes::McapSchema(1, "sensor_msgs/msg/Image") + bytes::McapSchema(2, "sensor_msgs/msg/Imu") +
      bytes::McapChannel(1, 1, "/up/image_raw") + bytes::McapChannel(2, 2, "/imu");
  std::ofstream stream(path, std::ios::binary);
  std::string summary = definitions;
  std::uint64_t at = 0;
  const auto put = [&](const std::string& record) {
    stream << record;
    at += record.size();
  };
  put(bytes::kMcapMagic + bytes::McapHeader() + definitions);
  Recording recording(bytes::MessageBytes::Form::kCdrLittle);
  constexpr std::size_t kChunkBytes = std::size_t{4} << 20U;
  while (at < size) {
    std::string records;
    std::vector<std::uint64_t> times;
    while (records.size() < kChunkBytes) {
      const Written message = recording.Next();
      records += bytes::McapMessage(message.topic, message.time_ns, message.data);
      times.push_back(message.time_ns);
    }
    const auto crc =
        mcap::Checksum({reinterpret_cast<const std::uint8_t*>(records.data()), records.size()});
    const std::string chunk = bytes::McapChunk(times.front(), times.back(), records, crc);
    summary += bytes::McapChunkIndex(times.front(), times.back(), at, chunk.size(), {1, 2});
    put(chunk);
  }
  put(bytes::McapDataEnd());
  const std::uint64_t summary_at = at;
  put(summary + bytes::McapFooter(summary_at) + bytes::kMcapMagic);
}

void WriteRos1(const std::filesystem::path& path, std::uint64_t size) {
  const std::string connections = bytes::Ros1Connection(1, "/up/image_raw", "sensor_msgs/Image") +
                                  bytes::Ros1Connection(2, "/imu", "sensor_msgs/Imu");
  std::ofstream stream(path, std::ios::binary);
  std::uint64_t at = bytes::Ros1DataAt();
  stream << bytes::Ros1ActiveFile("");
  Recording recording(bytes::MessageBytes::Form::kRos1);
  constexpr std::size_t kChunkBytes = std::size_t{768} << 10U;
  std::string index = connections;
  std::uint32_t chunks = 0;
  while (at < size) {
    std::string records = chunks == 0 ? connections : "";
    std::vector<std::uint64_t> times;
    while (records.size() < kChunkBytes) {
      const Written message = recording.Next();
      records += bytes::Ros1Message(message.topic, message.time_ns, message.data);
      times.push_back(message.time_ns);
    }
    const std::string counts = bytes::U32(1) + bytes::U32(1) + bytes::U32(2) + bytes::U32(7);
    index += bytes::Ros1ChunkInfo(at, times.front(), times.back(), counts);
    const std::string chunk = bytes::Ros1Chunk(records);
    stream << chunk;
    at += chunk.size();
    ++chunks;
  }
  stream << index;
  stream.seekp(0);
  stream << bytes::kRos1Magic << bytes::Ros1BagHeader(at, 2, chunks);
}

void WriteRosbag2(const std::filesystem::path& path, std::uint64_t size) {
  SqliteFile file(path,
                  kRosbag2Schema +
                      "INSERT INTO topics VALUES(1, '/up/image_raw', 'sensor_msgs/msg/Image', "
                      "'cdr', ''), (2, '/imu', 'sensor_msgs/msg/Imu', 'cdr', ''); BEGIN;");
  Recording recording(bytes::MessageBytes::Form::kCdrLittle);
  for (std::uint64_t written = 0; written < size;) {
    const Written message = recording.Next();
    file.Add(message.topic, static_cast<std::int64_t>(message.time_ns), message.data);
    written += message.data.size();
  }
  file.Run("COMMIT");
}

int Write(const std::filesystem::path& path, double gb) {
  constexpr double kBytesPerGb = 1e9;
  const auto size = static_cast<std::uint64_t>(gb * kBytesPerGb);
  if (path.extension() == ".bag") {
    WriteRos1(path, size);
  } else if (path.extension() == ".db3") {
    WriteRosbag2(path, size);
  } else {
    WriteMcap(path, size);
  }
  return EXIT_SUCCESS;
}

int Read(const std::filesystem::path& path) {
  constexpr double kMb = 1e6;
  constexpr int kPasses = 3;
  std::vector<double> speeds;
  std::uint64_t messages = 0;
  std::uint64_t total = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    const auto bag = BagReader::Open(path);
    messages = 0;
    total = 0;
    RawMessage message;
    while (bag->Next(message)) {
      ++messages;
      total += message.data.size();
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    speeds.push_back(static_cast<double>(total) / kMb / seconds.count());
    for (const std::string& warning : bag->Warnings()) fmt::print(stderr, "{}\n", warning);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  constexpr double kKbPerMb = 1024;
  fmt::print("{:.2f} GB, {} messages: {:.0f} MB/s (median of {}), at most {:.0f} MB of memory\n",
             static_cast<double>(total) / kMb / 1e3,
             messages,
             bench::Median(speeds),
             kPasses,
             static_cast<double>(usage.ru_maxrss) / kKbPerMb);
  return EXIT_SUCCESS;
}

std::uint32_t ChecksumOf(const cv::Mat& image) {
  return mcap::Checksum({image.data, image.total() * image.elemSize()});
}

template <typename Message>
std::string Checksums(const Message& message) {
  cv::Mat grey;
  cv::Mat colour;
  DecodePixels(message, false, grey);
  DecodePixels(message, true, colour);
  return fmt::format("{:08x} {:08x}", ChecksumOf(grey), ChecksumOf(colour));
}

int PrintChecksums(const std::filesystem::path& path) {
  const auto bag = BagReader::Open(path);
  RawMessage raw;
  while (bag->Next(raw)) {
    const Topic& topic = bag->Topics().at(raw.topic);
    std::string checksums;
    if (topic.type == "sensor_msgs/msg/Image") {
      checksums = Checksums(DecodeImage(raw.data, topic.encoding));
    } else if (topic.type == "sensor_msgs/msg/CompressedImage") {
      checksums = Checksums(DecodeCompressedImage(raw.data, topic.encoding));
    } else {
      continue;
    }
    fmt::print("{} {} {} {}\n",
               topic.name,
               raw.log_time_ns,
               DecodeHeader(raw.data, topic.encoding).stamp_ns,
               checksums);
  }
  for (const std::string& warning : bag->Warnings()) fmt::print(stderr, "{}\n", warning);
  return EXIT_SUCCESS;
}

int Run(const std::vector<std::string>& words) {
  if (words.size() == 3 && words[0] == "write") return Write(words[1], std::stod(words[2]));
  if (words.size() == 2 && words[0] == "read") return Read(words[1]);
  if (words.size() == 2 && words[0] == "checksums") return PrintChecksums(words[1]);
  fmt::print(stderr, "usage: ceilmap_bags_bench write BAG GB | read BAG | checksums BAG\n");
  return EXIT_FAILURE;
}

}  // namespace
}  // namespace ceilmap::bags

int main(int argc, char** argv) {
  try {
    return ceilmap::bags::Run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "ceilmap_bags_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
