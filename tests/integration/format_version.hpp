#pragma once

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace ceilmap::integration {

/// Sets another format version in a map.
inline void SetFormatVersion(const std::filesystem::path& map, int version) {
  GDALAllRegister();
  const GDALDatasetUniquePtr file(
      GDALDataset::Open(map.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE, nullptr, nullptr, nullptr));
  if (!file) throw std::runtime_error("cannot be opened: " + map.string());
  const std::string sql = "UPDATE ceilmap_metadata SET value = '" + std::to_string(version) +
                          "' WHERE key = 'format_version'";
  file->ReleaseResultSet(file->ExecuteSQL(sql.c_str(), nullptr, nullptr));
}

}  // namespace ceilmap::integration
