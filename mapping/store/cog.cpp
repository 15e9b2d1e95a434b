#include <memory>
#include <system_error>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/export.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {
namespace {

/// A file that is removed with the object.
class TemporaryTiff {
 public:
  explicit TemporaryTiff(const AtomicFile& beside)
      : path_(beside.PartialPath().string() + ".tif") {}
  ~TemporaryTiff() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryTiff(const TemporaryTiff&) = delete;
  TemporaryTiff& operator=(const TemporaryTiff&) = delete;
  [[nodiscard]] const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
};

CPLStringList CogOptions() {
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", "YES");
  options.SetNameValue("BLOCKSIZE", "256");
  options.SetNameValue("OVERVIEWS", "AUTO");  // those of the source, or new ones
  options.SetNameValue("OVERVIEW_RESAMPLING", "AVERAGE");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  return options;
}

}  // namespace

void ExportCog(const MapReader& map, const std::filesystem::path& file) {
  AtomicFile partial(file);
  // GDAL writes such files only as copies, because their parts are in order of their size.
  const TemporaryTiff whole(partial);
  ExportGeoTiff(map, whole.Path());
  {
    const GdalScope gdal;
    const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");
    const auto check = [&](const void* made) {
      if (made != nullptr && !gdal.Failed()) return;
      throw RunError("cannot write " + file.string() + ": " +
                     (gdal.Message().empty() ? "unknown GDAL error" : gdal.Message()));
    };
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
    if (driver == nullptr) {
      throw RunError("this GDAL writes no Cloud Optimized GeoTIFF ; GDAL 3.1 or later does");
    }
    const GDALDatasetUniquePtr source(
        GDALDataset::Open(whole.Path().c_str(), GDAL_OF_RASTER, nullptr, nullptr, nullptr));
    check(source.get());
    GDALDatasetUniquePtr copy(driver->CreateCopy(
        partial.PartialPath().c_str(), source.get(), FALSE, CogOptions().List(), nullptr, nullptr));
    check(copy.get());
    copy.reset();
    check(source.get());  // closing writes too
  }
  partial.Commit();
}

}  // namespace ceilmap::store
