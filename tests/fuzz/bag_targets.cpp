#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>

#include "app/bags/bag_reader.hpp"
#include "app/bags/image_decoding.hpp"
#include "app/bags/message_error.hpp"
#include "app/bags/messages.hpp"
#include "app/bags/result_messages.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::uint8_t>;

/// A file of this process in memory, as bags are read by position.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& ending) {
    const fs::path memory = "/dev/shm";
    const fs::path folder = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    path_ = folder / ("ceilmap-fuzz-" + std::to_string(getpid()) + ending);
  }
  ~MemoryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const fs::path& Write(std::string_view bytes) const {
    std::ofstream stream(path_, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_;
  }

 private:
  fs::path path_;
};

/// Each field of a message, so that reading beyond its bytes is noticed.
template <typename Decode>
void Decoded(const Decode& decode, Bytes data, bags::MessageEncoding encoding) {
  try {
    (void)decode(data, encoding);
  } catch (const bags::MessageError& error) {
    RequireOneLine(error.what());
  }
}

template <typename Message>
void CheckPixels(const Message& message) {
  cv::Mat image;
  for (const bool colour : {false, true}) {
    try {
      bags::DecodePixels(message, colour, image);
      Require(image.type() == (colour ? CV_8UC3 : CV_8UC1) && !image.empty(), "pixels");
      (void)cv::sum(image);
    } catch (const bags::MessageError& error) {
      RequireOneLine(error.what());
    }
  }
}

void DecodeAll(Bytes data, bags::MessageEncoding encoding) {
  const auto image = [](Bytes bytes, bags::MessageEncoding of) {
    const bags::ImageMessage message = bags::DecodeImage(bytes, of);
    CheckPixels(message);
    return message;
  };
  const auto compressed = [](Bytes bytes, bags::MessageEncoding of) {
    const bags::CompressedImageMessage message = bags::DecodeCompressedImage(bytes, of);
    CheckPixels(message);
    return message;
  };
  Decoded(image, data, encoding);
  Decoded(compressed, data, encoding);
  Decoded(bags::DecodeCameraInfo, data, encoding);
  Decoded(bags::DecodeOdometry, data, encoding);
  Decoded(bags::DecodeImu, data, encoding);
  Decoded(bags::DecodeTransforms, data, encoding);
  Decoded(bags::DecodePose, data, encoding);
  Decoded(bags::DecodeDiagnostics, data, encoding);
  Decoded(bags::DecodeHeader, data, encoding);
}

/// All messages, and those of the first topic alone: in both passes each is whole and its topic
/// known.
void ReadBag(const fs::path& file) {
  if (!bags::BagReader::IsBag(file)) return;
  (void)Accepted([&] {
    const auto bag = bags::BagReader::Open(file);
    (void)bag->Facts();
    std::uint64_t sum = 0;
    std::size_t messages = 0;
    for (int pass = 0; pass < 2; ++pass) {
      bags::RawMessage message;
      while (bag->Next(message)) {
        Require(message.topic < bag->Topics().size(), "a topic that does not exist");
        Require(pass == 0 || message.topic == 0, "a topic that was not selected");
        for (const std::uint8_t byte : message.data) sum += byte;
        ++messages;
      }
      if (!bag->Topics().empty()) bag->Select({0});
    }
    for (const std::string& warning : bag->Warnings()) RequireOneLine(warning);
    return sum + messages;
  });
}

}  // namespace

void ReadAsMcap(std::string_view bytes) {
  static const MemoryFile file(".mcap");
  ReadBag(file.Write(bytes));
}

void ReadAsRos1Bag(std::string_view bytes) {
  static const MemoryFile file(".bag");
  ReadBag(file.Write(bytes));
}

void ReadAsRosbag2(std::string_view bytes) {
  static const MemoryFile file(".db3");
  ReadBag(file.Write(bytes));
}

void ReadAsMessage(std::string_view bytes) {
  const Bytes data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  DecodeAll(data, bags::MessageEncoding::kCdr);
  DecodeAll(data, bags::MessageEncoding::kRos1);
}

}  // namespace ceilmap::fuzz
