#include "app/files/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "calib/base/error.hpp"

namespace ceilmap::files {

std::string ReadTextFile(const std::filesystem::path& file, std::size_t max_bytes) {
  std::error_code ignored;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file, ignored)) {
    throw InputError(fmt::format("{}: no such file, or not readable", file.string()));
  }
  std::string text;
  const std::uintmax_t size = std::filesystem::file_size(file, ignored);
  if (!ignored && size <= max_bytes) text.reserve(size);
  std::array<char, 65536> block{};
  do {
    stream.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  } while (stream && text.size() <= max_bytes);
  if (text.size() > max_bytes) {
    throw InputError(fmt::format(
        "{}: larger than {} MiB, the most that a text file may have; split the recording",
        file.string(),
        max_bytes >> 20U));
  }
  if (stream.bad()) throw InputError(fmt::format("{}: cannot be read", file.string()));
  return text;
}

bool Lines::Next(std::string_view& line) {
  if (rest_.empty()) return false;
  ++number_;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (line.size() > kMaxLineBytes) {
    throw InputError(fmt::format(
        "{}:{}: is longer than {} KiB; give a text file", name_, number_, kMaxLineBytes >> 10U));
  }
  return true;
}

}  // namespace ceilmap::files
