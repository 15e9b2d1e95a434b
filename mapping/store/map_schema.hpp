#pragma once

#include <filesystem>

namespace ceilmap::store {

/// Refuses a database that contains views, or tables or columns that are computed when they are
/// read, which could take unlimited time. Maps have none except the spatial indices (R-trees) of
/// their layers. Call it before anything else is read. Internal.
/// @param vfs  SQLite's name of the file system that has the file; null: the local one.
/// @throws InputError (without the file's name) when there are any, or when the file is no
/// database.
void CheckSchema(const std::filesystem::path& file, const char* vfs = nullptr);

}  // namespace ceilmap::store
