#pragma once

#include <filesystem>

namespace ceilmap::store {

/// Rewrites a table of a database so that its rows follow each other in the file, in the order of
/// their ids; the space where they were is reused. The database must not be open elsewhere, and is
/// not protected against a crash meanwhile (as the partial file of a MapWriter). Internal.
/// @throws RunError (without the file's name) when the disk cannot be written.
void GatherTable(const std::filesystem::path& database, const char* table);

/// Rewrites a database without the space of what was removed; the same holds.
void ShrinkDatabase(const std::filesystem::path& database);

}  // namespace ceilmap::store
