#include "mapping/store/postgis_database.hpp"

#include <ogrsf_frmts.h>

#include <array>

#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"

namespace ceilmap::store {
namespace {

/// Numbers of PostgreSQL's advisory locks: this program's, and that of its tables. Names of maps
/// have a hash as the second number.
constexpr char kTablesLock[] = "SELECT pg_advisory_xact_lock(1667591021, 0)::text";
constexpr char kNameLock[] = "SELECT pg_advisory_xact_lock(1667591022, hashtext(";

std::string ForGdal(const std::string& connection) {
  return connection.starts_with("PG:") ? connection : "PG:" + connection;
}

}  // namespace

std::string Quoted(const std::string& text) {
  std::string quoted = "E'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    if (c == '\0') continue;  // which PostgreSQL has not
    quoted += c;
  }
  return quoted + "'";
}

PostgisDatabase::PostgisDatabase(const std::string& connection) {
  const std::array<const char*, 2> drivers = {"PostgreSQL", nullptr};
  if (GetGDALDriverManager()->GetDriverByName(drivers[0]) == nullptr) {
    throw RunError("this GDAL was built without PostgreSQL");
  }
  // Without a list of all tables: only the named ones are opened.
  const std::array<const char*, 2> options = {"LIST_ALL_TABLES=NO", nullptr};
  dataset_.reset(GDALDataset::Open(ForGdal(connection).c_str(),
                                   GDAL_OF_VECTOR | GDAL_OF_UPDATE,
                                   drivers.data(),
                                   options.data(),
                                   nullptr));
  if (dataset_) return;
  const std::string& message = gdal_.Message();
  // libpq quotes the text that it does not understand, which may be a part of a password.
  if (message.empty() || message.find("connection info string") != std::string::npos ||
      message.find("connection option") != std::string::npos ||
      message.find("URI") != std::string::npos) {
    throw InputError(
        "the connection string cannot be understood; give 'PG:host=HOST dbname=NAME user=USER', "
        "with the password in ~/.pgpass or PGPASSWORD");
  }
  throw RunError("the database cannot be reached: " + WithoutSecrets(message));
}

void PostgisDatabase::Check(bool succeeded) const {
  if (succeeded && !gdal_.Failed()) return;
  throw RunError("the database refuses the map: " +
                 (gdal_.Message().empty() ? "unknown error" : WithoutSecrets(gdal_.Message())));
}

void PostgisDatabase::Run(const std::string& sql) {
  OGRLayer* result = dataset_->ExecuteSQL(sql.c_str(), nullptr, nullptr);
  if (result != nullptr) dataset_->ReleaseResultSet(result);
  Check(true);
}

std::string PostgisDatabase::Ask(const std::string& sql) {
  OGRLayer* result = dataset_->ExecuteSQL(sql.c_str(), nullptr, nullptr);
  std::string answer;
  if (result != nullptr) {
    if (const OGRFeatureUniquePtr row{result->GetNextFeature()}) answer = row->GetFieldAsString(0);
    dataset_->ReleaseResultSet(result);
  }
  Check(true);
  return answer;
}

void PostgisDatabase::LockTables() {
  Ask(kTablesLock);
}

void PostgisDatabase::LockName(const std::string& name) {
  Ask(kNameLock + Quoted(name) + "))::text");
}

}  // namespace ceilmap::store
