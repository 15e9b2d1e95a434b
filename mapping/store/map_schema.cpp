#include "mapping/store/map_schema.hpp"

#include <sqlite3.h>

#include <memory>
#include <string>
#include <string_view>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {
namespace {

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

/// The type of each name by SQLite's interpretation, which is authoritative.
constexpr const char* kWorkedOut =
    "SELECT l.name, l.type, coalesce(m.sql, '') FROM pragma_table_list AS l "
    "LEFT JOIN main.sqlite_master AS m ON m.name = l.name "
    "WHERE l.schema = 'main' AND l.type IN ('view', 'virtual') "
    "UNION ALL SELECT l.name, 'column', '' FROM pragma_table_list AS l, "
    "pragma_table_xinfo(l.name) AS x WHERE l.schema = 'main' AND l.type = 'table' AND x.hidden > 1";

[[noreturn]] void ThrowDamaged(sqlite3* database) {
  throw InputError(std::string("cannot be read as a GeoPackage (") +
                   InOneLine(sqlite3_errmsg(database), kMaxMessageBytes) + ")");
}

Database Open(const std::filesystem::path& file, const char* vfs) {
  sqlite3* handle = nullptr;
  const int result = sqlite3_open_v2(file.c_str(), &handle, SQLITE_OPEN_READONLY, vfs);
  Database database(handle, &sqlite3_close);
  if (result != SQLITE_OK) ThrowDamaged(handle);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  // A normal schema needs a few thousand steps; a file that needs more than this limit is refused.
  constexpr int kMaxSteps = 20'000'000;
  sqlite3_progress_handler(
      handle, kMaxSteps, [](void*) { return 1; }, nullptr);
  return database;
}

std::string Text(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? "" : text;
}

/// As created by GDAL.
bool IsSpatialIndex(const std::string& name, const std::string& sql) {
  return name.starts_with("rtree_") && name.find('"') == std::string::npos &&
         sql == "CREATE VIRTUAL TABLE \"" + name + "\" USING rtree(id, minx, maxx, miny, maxy)";
}

}  // namespace

void CheckSchema(const std::filesystem::path& file, const char* vfs) {
  const Database database = Open(file, vfs);
  sqlite3_stmt* prepared = nullptr;
  const int made = sqlite3_prepare_v2(database.get(), kWorkedOut, -1, &prepared, nullptr);
  const Statement rows(prepared, &sqlite3_finalize);
  if (made != SQLITE_OK) ThrowDamaged(database.get());
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
    const std::string name = Text(rows.get(), 0);
    const std::string type = Text(rows.get(), 1);
    if (type == "virtual" && IsSpatialIndex(name, Text(rows.get(), 2))) continue;
    const std::string what = type == "view"      ? "a view"
                             : type == "virtual" ? "a virtual table"
                                                 : "a table with columns that are worked out";
    throw InputError("has " + what + ", '" + InOneLine(name, kMaxMessageBytes) +
                     "', which no map has; do not use it if it comes from elsewhere");
  }
  if (result != SQLITE_DONE) ThrowDamaged(database.get());
}

}  // namespace ceilmap::store
