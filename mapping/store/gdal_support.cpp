#include "mapping/store/gdal_support.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>

#include <algorithm>
#include <mutex>

#include "calib/base/one_line.hpp"
#include "calib/base/result_date.hpp"

namespace ceilmap::store {
namespace {

void RegisterDriversOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    GDALAllRegister();
    // The date of change of the layers in a GeoPackage.
    if (const auto date = FixedResultDate()) CPLSetConfigOption("OGR_CURRENT_DATE", date->c_str());
  });
}

}  // namespace

GdalScope::GdalScope() {
  CPLPushErrorHandlerEx(&GdalScope::Handle, this);  // of this thread only
  RegisterDriversOnce();
}

GdalScope::~GdalScope() {
  CPLPopErrorHandler();
}

void GdalScope::Handle(CPLErr level, CPLErrorNum /*number*/, const char* text) {
  if (level != CE_Failure && level != CE_Fatal) return;
  auto& scope = *static_cast<GdalScope*>(CPLGetErrorHandlerUserData());
  if (scope.failed_) return;
  scope.failed_ = true;
  scope.message_ = InOneLine(text, kMaxMessageBytes);
}

GdalOption::GdalOption(const char* key, const char* value) : key_(key) {
  if (const char* old = CPLGetThreadLocalConfigOption(key, nullptr)) {
    old_ = old;
    had_old_ = true;
  }
  CPLSetThreadLocalConfigOption(key, value);
}

GdalOption::~GdalOption() {
  CPLSetThreadLocalConfigOption(key_.c_str(), had_old_ ? old_.c_str() : nullptr);
}

OGRSpatialReference LocalSrs(const std::string& unit) {
  OGRSpatialReference srs;
  if (unit == "px") {
    srs.SetFromUserInput(
        R"(LOCAL_CS["ceilmap map in pixels",UNIT["pixel",1],AXIS["X",EAST],AXIS["Y",NORTH]])");
  } else {
    srs.SetFromUserInput(
        R"(LOCAL_CS["ceilmap map in metres",UNIT["metre",1],AXIS["X",EAST],AXIS["Y",NORTH]])");
  }
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

}  // namespace ceilmap::store
