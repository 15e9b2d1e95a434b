#pragma once

#include <filesystem>

namespace ceilmap::store {

/// A database may hold more than rows: views, and tables or columns that are worked out when they
/// are read, without end if their author likes. No map has any but the spatial indices (R-trees) of
/// its layers. To be called before anything else reads the file. Internal.
/// @throws InputError (without the file's name) when there is more, or when the file is no
///   database.
void CheckSchema(const std::filesystem::path& file);

}  // namespace ceilmap::store
