#include "mapping/store/crs.hpp"

#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {

std::string ParseCrs(const std::string& text) {
  const GdalScope gdal;
  const std::string shown = InOneLine(text, 80);
  OGRSpatialReference srs;
  CPLStringList limits;
  limits.SetNameValue("ALLOW_NETWORK_ACCESS", "NO");
  limits.SetNameValue("ALLOW_FILE_ACCESS", "NO");
  if (srs.SetFromUserInput(text.c_str(), limits.List()) != OGRERR_NONE) {
    throw InputError(shown +
                     ": is no known coordinate reference system; give for example EPSG:25832");
  }
  if (!srs.IsProjected() && !srs.IsLocal()) {
    throw InputError(shown +
                     ": is not projected, so its coordinates are no metres in a plane; give that "
                     "of the building's plan, for example a UTM zone (EPSG:25832)");
  }
  const char* unit = nullptr;
  const double metres = srs.GetLinearUnits(&unit);
  if (std::abs(metres - 1) > 1e-9) {
    throw InputError(shown + ": its unit is '" + (unit == nullptr ? "" : unit) +
                     "'; give a system in metres, and the points in it");
  }
  char* wkt = nullptr;
  CPLStringList format;
  format.SetNameValue("FORMAT", "WKT2_2019");
  const OGRErr error = srs.exportToWkt(&wkt, format.List());
  std::string result = wkt == nullptr ? "" : wkt;
  CPLFree(wkt);
  if (error != OGRERR_NONE || result.empty()) {
    throw InputError(shown + ": cannot be written as WKT (" + gdal.Message() + ")");
  }
  return result;
}

std::string NameOfCrs(const std::string& wkt) {
  if (wkt.empty()) return "local";
  const GdalScope gdal;
  OGRSpatialReference srs;
  if (srs.importFromWkt(wkt.c_str()) != OGRERR_NONE || srs.GetName() == nullptr) return "unknown";
  return InOneLine(srs.GetName(), 80);
}

}  // namespace ceilmap::store
