#pragma once

#include <functional>
#include <string>

#include "mapping/store/export.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::store {

/// Export to a PostgreSQL database with PostGIS, for GIS programs and for queries over all maps of
/// a site. The maps share the tables of the schema `ceilmap`, which is made when it is missing:
///
/// - `maps`: a row for each map, with its unique `name`, metadata, the path of its mosaic, and its
///   alignment (`site_crs`, `site_scale`, `site_x`, `site_y`, `site_yaw_rad`) if it has one.
/// - `keyframes`, `trajectory`, `edges`, `weak_spots`, `left_out`, `control_points`: the layers of
///   the map file with the same columns (poses, covariances `cxx` ... `cyawyaw`, information
///   matrices `ixx` ... `iyawyaw`), `map_id` of `maps`, and a geometry. `keyframes.id` is the id of
///   the map file; `fid` is a number of the row for GIS programs.
///
/// Rows are those of the map file, their geometries in map units without an SRID; or, with
/// Frame::kSite, in metres of the building with the SRID of its coordinate reference system:
/// that of its EPSG code, or of an entry in `spatial_ref_sys`, which is made when it is missing.
/// The SRID is 0 for a local system without WKT, and where the user may make no entry. The rows of
/// each SRID are also views with this SRID as their type, `keyframes_25832`, ..., as GIS programs
/// expect layers. `maps.frame` and `maps.srid` state what a map has.
///
/// A map is written in one transaction: readers see the old map or the new one. Programs that write
/// at the same time wait for each other where they write a map of the same name.
struct PostgisOptions {
  std::string name;      ///< of the map in the database; not empty
  bool replace = false;  ///< a map of this name
  Frame frame = Frame::kMap;
  std::string mosaic;  ///< path of its mosaic as a GeoTIFF, for `maps.mosaic`; may be empty
  /// Called when the database was checked, before anything is written to it; may be empty. Its
  /// errors end the export.
  std::function<void()> before_writing;
};

/// @param connection  `PG:host=... dbname=... user=...`: the connection string of GDAL and libpq
/// (or `postgresql://...`). Passwords are better in ~/.pgpass or PGPASSWORD. No message contains
/// it.
/// @throws InputError when the string is none, when the database has no PostGIS, or has a map of
/// this name that must not be replaced, or the map has no alignment for Frame::kSite; RunError when
/// the server cannot be reached, or refuses.
void ExportPostgis(const MapReader& map,
                   const std::string& connection,
                   const PostgisOptions& options);

/// Whether a text is a connection string.
bool IsPostgisConnection(const std::string& text);

}  // namespace ceilmap::store
