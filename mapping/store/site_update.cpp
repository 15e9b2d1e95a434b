#include "mapping/store/site_update.hpp"

#include <array>
#include <system_error>
#include <vector>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/store/attribute_tables.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_metadata.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/site_tables.hpp"

namespace ceilmap::store {
namespace {

namespace fs = std::filesystem;

void CheckUpdate(const GdalScope& gdal, bool succeeded, const fs::path& file) {
  if (succeeded && !gdal.Failed()) return;
  throw RunError("cannot write " + file.string() + ": " +
                 (gdal.Message().empty() ? "unknown GDAL error" : gdal.Message()));
}

/// Removes the rows that the new ones replace.
bool RemoveRows(OGRLayer& metadata) {
  std::vector<GIntBig> old;
  for (const auto& row : metadata) {
    const int key = row->GetFieldIndex(tables::kKey);
    const std::string name = key >= 0 ? row->GetFieldAsString(key) : "";
    if (name.starts_with(kSitePrefix) || name == kProvenanceKey) old.push_back(row->GetFID());
  }
  for (const GIntBig id : old) {
    if (metadata.DeleteFeature(id) != OGRERR_NONE) return false;
  }
  return true;
}

bool RemoveLayer(GDALDataset& dataset, const char* name) {
  for (int i = 0; i < dataset.GetLayerCount(); ++i) {
    if (std::string(name) == dataset.GetLayer(i)->GetName()) {
      return dataset.DeleteLayer(i) == OGRERR_NONE;
    }
  }
  return true;
}

void Update(const fs::path& file,
            const fs::path& shown,
            const MapMetadata& metadata,
            const survey::SiteFrame& site) {
  const GdalScope gdal;
  const GdalOption synchronous("OGR_SQLITE_SYNCHRONOUS", "OFF");  // AtomicFile syncs the file
  const GdalOption journal("OGR_SQLITE_JOURNAL", "MEMORY");
  const std::array<const char*, 2> drivers = {"GPKG", nullptr};
  GDALDatasetUniquePtr dataset(GDALDataset::Open(
      file.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE, drivers.data(), nullptr, nullptr));
  CheckUpdate(gdal, dataset && dataset->StartTransaction() == OGRERR_NONE, shown);
  OGRLayer* rows = dataset->GetLayerByName(tables::kMetadata);
  CheckUpdate(gdal, rows != nullptr && RemoveRows(*rows), shown);
  for (const auto& [key, value] : ToRows(site)) {
    CheckUpdate(gdal, tables::Append(*rows, key, value), shown);
  }
  CheckUpdate(gdal, tables::Append(*rows, kProvenanceKey, metadata.provenance), shown);
  CheckUpdate(gdal, RemoveLayer(*dataset, tables::kControlPoints), shown);
  OGRSpatialReference srs = LocalSrs(metadata.unit);
  OGRLayer* points = tables::CreateControlPoints(*dataset, srs);
  CheckUpdate(gdal, points != nullptr, shown);
  for (const survey::AlignedPoint& point : site.points) {
    CheckUpdate(gdal, tables::Append(*points, point), shown);
  }
  CheckUpdate(gdal, dataset->CommitTransaction() == OGRERR_NONE, shown);
  dataset.reset();
  CheckUpdate(gdal, true, shown);
}

}  // namespace

void WriteSiteFrame(const fs::path& map,
                    const fs::path& output,
                    const survey::SiteFrame& site,
                    const std::string& provenance) {
  if (output.extension() != ".gpkg") {
    throw InputError(output.string() + ": a map file's name must end in .gpkg");
  }
  if (IsRemoteName(map.string())) {
    throw InputError(WithoutSecrets(map.string()) + ": is on a server; download it to align it");
  }
  AtomicFile target(output, {"-wal", "-shm", "-journal"});
  MapMetadata metadata;
  {
    const MapReader reader(map);
    metadata = reader.Metadata();
    std::error_code error;
    fs::copy_file(map, target.PartialPath(), fs::copy_options::overwrite_existing, error);
    if (error) throw RunError("cannot write " + output.string() + ": " + error.message());
    reader.CheckCurrent();
  }
  metadata.provenance += "\n" + provenance;
  metadata.site = site;
  if (const std::string problem = Problem(metadata); !problem.empty()) throw InputError(problem);
  Update(target.PartialPath(), output, metadata, site);
  target.Commit();
}

}  // namespace ceilmap::store
