#pragma once

#include <gdal_priv.h>

#include <string>

#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {

/// A PostgreSQL database with one transaction at a time. Internal, because it uses GDAL.
class PostgisDatabase {
 public:
  /// @throws InputError when the connection string cannot be understood, RunError when the server
  /// cannot be reached. No message contains the string.
  explicit PostgisDatabase(const std::string& connection);

  /// These throw RunError when the server refuses.
  void Begin() { Check(dataset_->StartTransaction() == OGRERR_NONE); }
  void Commit() { Check(dataset_->CommitTransaction() == OGRERR_NONE); }
  void Run(const std::string& sql);
  /// The first column of the only row; empty without a row.
  std::string Ask(const std::string& sql);
  void Check(bool succeeded) const;

  /// Within a transaction: waits for others that make tables, views or reference systems.
  void LockTables();
  /// Within a transaction: waits for others that write a map of this name.
  void LockName(const std::string& name);

 private:
  GdalScope gdal_;  // messages of all calls
  GDALDatasetUniquePtr dataset_;
};

/// A text as a constant of SQL.
std::string Quoted(const std::string& text);

}  // namespace ceilmap::store
