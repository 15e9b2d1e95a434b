#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>

/// The file of a map as a file, before GDAL opens it. Internal.
namespace ceilmap::store {

/// The file of a name, and its state; all zero if there is none. Two are equal if nobody replaced
/// or wrote the file in between.
using FileState = std::array<std::int64_t, 5>;
FileState StateOf(const std::filesystem::path& path);

/// Checks the first bytes of an SQLite database (file format, section 1.3). SQLite itself detects a
/// truncated file only when it reads a missing page; an early check prevents a run that fails
/// half-way.
/// @throws InputError (without the file's name) when the file cannot be read, is no database, or is
/// truncated.
void CheckSqliteHeader(const std::filesystem::path& path);
/// The same of a file of `file_bytes` bytes that begins with `header`.
/// @param header_bytes  100, or fewer where the file is shorter.
void CheckSqliteHeader(const unsigned char* header,
                       std::size_t header_bytes,
                       std::uint64_t file_bytes);

}  // namespace ceilmap::store
