#include "mapping/store/database_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <system_error>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

}  // namespace

FileState StateOf(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return {};
  return {static_cast<std::int64_t>(status.st_dev),
          static_cast<std::int64_t>(status.st_ino),
          status.st_size,
          status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
}

void CheckSqliteHeader(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError("no such file");
  if (!fs::is_regular_file(status)) throw InputError("is no file");
  std::array<unsigned char, 100> header{};
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError("cannot be opened for reading; check its permissions");
  stream.read(reinterpret_cast<char*>(header.data()), header.size());
  const std::uintmax_t file_bytes = fs::file_size(path, error);
  CheckSqliteHeader(
      header.data(), static_cast<std::size_t>(stream.gcount()), error ? 0 : file_bytes);
}

void CheckSqliteHeader(const unsigned char* header,
                       std::size_t header_bytes,
                       std::uint64_t file_bytes) {
  constexpr std::array<char, 16> kMagic = {
      'S', 'Q', 'L', 'i', 't', 'e', ' ', 'f', 'o', 'r', 'm', 'a', 't', ' ', '3', '\0'};
  if (header_bytes < 100 || !std::equal(kMagic.begin(), kMagic.end(), header)) {
    throw InputError("is no GeoPackage; give a map made by 'ceilmap map'");
  }
  const auto big_endian = [&header](std::size_t at, std::size_t bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | header[at + i];
    return value;
  };
  const std::uint64_t stored_size = big_endian(16, 2);
  const std::uint64_t page_bytes = stored_size == 1 ? 65536 : stored_size;
  const bool has_page_count = big_endian(24, 4) == big_endian(92, 4);
  if (file_bytes == 0 || (has_page_count && file_bytes < page_bytes * big_endian(28, 4))) {
    throw InputError("is truncated; copy it again or make the map again");
  }
}

}  // namespace ceilmap::store
