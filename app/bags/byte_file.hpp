#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace ceilmap::bags {

/// Bytes that are not initialized and whose memory is kept when they become fewer.
class Buffer {
 public:
  /// The content is lost.
  void Resize(std::size_t size);
  /// The content remains. @param size  at least Size().
  void Grow(std::size_t size);
  [[nodiscard]] std::size_t Size() const { return size_; }
  [[nodiscard]] std::size_t Capacity() const { return capacity_; }
  [[nodiscard]] std::uint8_t* Data() { return bytes_.get(); }
  [[nodiscard]] std::span<std::uint8_t> Bytes() { return {bytes_.get(), size_}; }
  [[nodiscard]] std::span<const std::uint8_t> Bytes() const { return {bytes_.get(), size_}; }
  /// Keeps the first bytes. @param size  at most Size().
  void Shorten(std::size_t size) { size_ = size; }

 private:
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// A file that is read by position.
class ByteFile {
 public:
  /// @throws InputError when it is missing, a folder, no regular file, or cannot be opened.
  /// @param name  for messages.
  ByteFile(const std::filesystem::path& path, std::string name);
  ~ByteFile();
  ByteFile(const ByteFile&) = delete;
  ByteFile& operator=(const ByteFile&) = delete;

  [[nodiscard]] const std::string& Name() const { return name_; }
  [[nodiscard]] std::uint64_t Size() const { return size_; }
  /// Fills `bytes` from `at` on. @throws InputError when the file cannot be read or became shorter.
  void Read(std::uint64_t at, std::span<std::uint8_t> bytes) const;

 private:
  std::string name_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Reads of a few bytes at increasing positions, through a buffer.
class FileWindow {
 public:
  /// @param ahead  bytes that are read at least.
  explicit FileWindow(const ByteFile& file, std::size_t ahead = std::size_t{64} << 10U)
      : file_(file), ahead_(ahead) {}

  /// The bytes from `at` on: `size`, or fewer at the end of the file. Valid until the next call.
  std::span<const std::uint8_t> View(std::uint64_t at, std::size_t size);

 private:
  const ByteFile& file_;
  std::size_t ahead_;
  Buffer buffer_;
  std::uint64_t at_ = 0;
};

}  // namespace ceilmap::bags
