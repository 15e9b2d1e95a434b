#pragma once

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <string>

namespace ceilmap::store {

/// Common wrapper for all uses of GDAL in this folder. Internal: no public header includes it.

/// Maximum length of a library's text in a message.
inline constexpr std::size_t kMaxMessageBytes = 400;

/// While the object exists, messages of GDAL on this thread are stored instead of printed, because
/// libraries must not print. Registers GDAL's drivers at the first use in the process. Scopes may
/// be nested.
class GdalScope {
 public:
  GdalScope();
  ~GdalScope();
  GdalScope(const GdalScope&) = delete;
  GdalScope& operator=(const GdalScope&) = delete;

  /// True after GDAL reported an error (warnings do not count). Several GDAL calls, such as closing
  /// a file, report a failure only in this way.
  [[nodiscard]] bool Failed() const { return failed_; }
  /// The first error on one line, because later ones are mostly its consequences. Empty without an
  /// error.
  [[nodiscard]] const std::string& Message() const { return message_; }

 private:
  static void Handle(CPLErr level, CPLErrorNum number, const char* text);

  bool failed_ = false;
  std::string message_;
};

/// Sets a GDAL configuration option for this thread while the object exists.
class GdalOption {
 public:
  GdalOption(const char* key, const char* value);
  ~GdalOption();
  GdalOption(const GdalOption&) = delete;
  GdalOption& operator=(const GdalOption&) = delete;

 private:
  std::string key_;
  std::string old_;
  bool had_old_ = false;
};

/// A partial file needs no protection, because it becomes valid only when it is renamed. So SQLite
/// neither syncs nor keeps a journal on disk. Must exist while the file is opened.
struct FastSqlite {
  GdalOption synchronous{"OGR_SQLITE_SYNCHRONOUS", "OFF"};
  GdalOption journal{"OGR_SQLITE_JOURNAL", "MEMORY"};
};

/// The map's coordinate system: a local engineering one, x right and y up, in metres ("m") or
/// pixels ("px"). Not tied to the Earth.
OGRSpatialReference LocalSrs(const std::string& unit);

}  // namespace ceilmap::store
