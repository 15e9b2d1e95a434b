#include "mapping/store/postgis_tables.hpp"

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include <array>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

/// Columns of the rows of feature_tables.hpp: poses and covariances, and information matrices.
#define CEILMAP_FRAME_COLUMNS                                                 \
  "frame_index bigint NOT NULL, keyframe_id bigint NOT NULL, "                \
  "stamp_s double precision NOT NULL, yaw_rad double precision NOT NULL, "    \
  "pitch_rad double precision NOT NULL, roll_rad double precision NOT NULL, " \
  "lift double precision NOT NULL, status text NOT NULL, "                    \
  "cxx double precision NOT NULL, cxy double precision NOT NULL, "            \
  "cxyaw double precision NOT NULL, cyy double precision NOT NULL, "          \
  "cyyaw double precision NOT NULL, cyawyaw double precision NOT NULL, "      \
  "geom geometry(Point) NOT NULL"
#define CEILMAP_ROW_COLUMNS     \
  "fid bigserial PRIMARY KEY, " \
  "map_id integer NOT NULL REFERENCES ceilmap.maps ON DELETE CASCADE, "

constexpr std::array kMakeTables = {
    "CREATE SCHEMA IF NOT EXISTS ceilmap",
    "CREATE TABLE IF NOT EXISTS ceilmap.maps (id serial PRIMARY KEY, name text NOT NULL UNIQUE, "
    "unit text NOT NULL, resolution double precision NOT NULL, "
    "ceiling_height_m double precision NOT NULL, robot text NOT NULL, "
    "program_version text NOT NULL, provenance text NOT NULL, mosaic text, "
    "exported timestamptz NOT NULL DEFAULT now())",
    // Databases of earlier versions do not have these.
    "ALTER TABLE ceilmap.maps ADD COLUMN IF NOT EXISTS frame text NOT NULL DEFAULT 'map', "
    "ADD COLUMN IF NOT EXISTS srid integer NOT NULL DEFAULT 0, "
    "ADD COLUMN IF NOT EXISTS site_crs text, ADD COLUMN IF NOT EXISTS site_scale double precision, "
    "ADD COLUMN IF NOT EXISTS site_x double precision, "
    "ADD COLUMN IF NOT EXISTS site_y double precision, "
    "ADD COLUMN IF NOT EXISTS site_yaw_rad double precision",
    "COMMENT ON COLUMN ceilmap.maps.frame IS 'coordinates of the map''s rows: map (those of the "
    "map file) or site (those of the building)'",
    "COMMENT ON COLUMN ceilmap.maps.srid IS 'SRID of the building''s coordinates, and of the rows "
    "in them; 0: a local system, or one that spatial_ref_sys does not hold, see site_crs'",
    "COMMENT ON COLUMN ceilmap.maps.site_crs IS 'coordinate reference system of the building, WKT "
    "2; empty: a local one. A place p of the map lies at site_scale R(site_yaw_rad) p + (site_x, "
    "site_y); null: the map is not aligned'",
    "CREATE TABLE IF NOT EXISTS ceilmap.keyframes (" CEILMAP_ROW_COLUMNS
    "id bigint NOT NULL, " CEILMAP_FRAME_COLUMNS
    ", ambiguous integer NOT NULL, "
    "UNIQUE (map_id, id))",
    "CREATE TABLE IF NOT EXISTS ceilmap.trajectory (" CEILMAP_ROW_COLUMNS CEILMAP_FRAME_COLUMNS ")",
    "CREATE TABLE IF NOT EXISTS ceilmap.edges (" CEILMAP_ROW_COLUMNS
    "from_id bigint NOT NULL, to_id bigint NOT NULL, kind text NOT NULL, "
    "x double precision NOT NULL, y double precision NOT NULL, yaw_rad double precision NOT NULL, "
    "ixx double precision NOT NULL, ixy double precision NOT NULL, "
    "ixyaw double precision NOT NULL, iyy double precision NOT NULL, "
    "iyyaw double precision NOT NULL, iyawyaw double precision NOT NULL, "
    "geom geometry(LineString) NOT NULL)",
    "CREATE TABLE IF NOT EXISTS ceilmap.weak_spots (" CEILMAP_ROW_COLUMNS
    "kind text NOT NULL, keyframe_id bigint NOT NULL, extent double precision NOT NULL, "
    "geom geometry(Point) NOT NULL)",
    "CREATE TABLE IF NOT EXISTS ceilmap.left_out (" CEILMAP_ROW_COLUMNS
    "kind text NOT NULL, area double precision NOT NULL, geom geometry(MultiPolygon) NOT NULL)",
    // The last one: where it is, all are.
    "CREATE TABLE IF NOT EXISTS ceilmap.control_points (" CEILMAP_ROW_COLUMNS
    "name text NOT NULL, site_x double precision NOT NULL, site_y double precision NOT NULL, "
    "sigma_m double precision NOT NULL, residual_x_m double precision NOT NULL, "
    "residual_y_m double precision NOT NULL, leave_one_out_m double precision, "
    "used integer NOT NULL, geom geometry(Point) NOT NULL)",
};
#undef CEILMAP_FRAME_COLUMNS
#undef CEILMAP_ROW_COLUMNS

struct TableShape {
  const char* name;
  const char* geometry;
};
constexpr std::array<TableShape, 6> kShapes = {{{"keyframes", "Point"},
                                                {"trajectory", "Point"},
                                                {"edges", "LineString"},
                                                {"weak_spots", "Point"},
                                                {"left_out", "MultiPolygon"},
                                                {"control_points", "Point"}}};

bool Exists(PostgisDatabase& database, const std::string& relation) {
  return !database
              .Ask("SELECT 1 WHERE to_regclass(" + Quoted("ceilmap." + relation) + ") IS NOT NULL")
              .empty();
}

int FirstSrid(PostgisDatabase& database, const std::string& condition) {
  const std::string srid =
      database.Ask("SELECT min(srid)::text FROM spatial_ref_sys WHERE " + condition);
  return srid.empty() ? 0 : std::stoi(srid);
}

/// A coordinate reference system as spatial_ref_sys holds it; empty texts where it cannot.
struct StoredCrs {
  std::string authority;
  std::string code;
  std::string wkt;  // WKT 1
};

StoredCrs ToStored(const std::string& wkt) {
  const GdalScope gdal;  // its messages are none of the database
  OGRSpatialReference srs;
  StoredCrs crs;
  if (srs.importFromWkt(wkt.c_str()) != OGRERR_NONE) return crs;
  const char* authority = srs.GetAuthorityName(nullptr);
  const char* code = srs.GetAuthorityCode(nullptr);
  if (authority != nullptr && code != nullptr) {
    crs.authority = authority;
    crs.code = code;
  }
  char* text = nullptr;
  if (srs.exportToWkt(&text) == OGRERR_NONE && text != nullptr) crs.wkt = text;
  CPLFree(text);
  return crs;
}

/// An entry of ours, made when it is missing.
int SridOfText(PostgisDatabase& database, const std::string& wkt) {
  constexpr std::size_t kMaxBytes = 2048;  // of the column
  if (wkt.empty() || wkt.size() > kMaxBytes) return 0;
  const std::string same = "srtext = " + Quoted(wkt);
  if (const int known = FirstSrid(database, same); known != 0) return known;
  if (database.Ask("SELECT 1 WHERE has_table_privilege('spatial_ref_sys', 'INSERT')").empty()) {
    return 0;
  }
  database.Begin();
  database.LockTables();
  int srid = FirstSrid(database, same);
  if (srid == 0) {
    // Above those of EPSG and ESRI, below 998999, the largest that PostGIS allows to users.
    srid = std::stoi(
        database.Ask("INSERT INTO spatial_ref_sys (srid, auth_name, auth_srid, srtext) SELECT n, "
                     "'ceilmap', n, " +
                     Quoted(wkt) +
                     " FROM (SELECT greatest(coalesce(max(srid), 0), 920000) + 1 AS n FROM "
                     "spatial_ref_sys WHERE srid < 998999) AS free RETURNING srid::text"));
  }
  database.Commit();
  return srid;
}

}  // namespace

void MakePostgisTables(PostgisDatabase& database) {
  if (database.Ask("SELECT 1 FROM pg_extension WHERE extname = 'postgis'").empty()) {
    throw InputError(
        "the database has no PostGIS; run 'CREATE EXTENSION postgis' in it, as its owner");
  }
  if (Exists(database, "control_points")) return;
  database.Begin();
  database.LockTables();
  for (const char* sql : kMakeTables) database.Run(sql);
  database.Commit();
}

int SridOf(PostgisDatabase& database, const std::string& wkt) {
  if (wkt.empty()) return 0;
  const StoredCrs crs = ToStored(wkt);
  if (!crs.code.empty()) {
    const int known = FirstSrid(
        database,
        "auth_name = " + Quoted(crs.authority) + " AND auth_srid::text = " + Quoted(crs.code));
    if (known != 0) return known;
  }
  return SridOfText(database, crs.wkt);
}

void MakePostgisViews(PostgisDatabase& database, int srid) {
  const std::string number = std::to_string(srid);
  if (Exists(database, "control_points_" + number)) return;
  if (database.Ask("SELECT 1 WHERE has_schema_privilege('ceilmap', 'CREATE')").empty()) return;
  database.Begin();
  database.LockTables();
  for (const TableShape& table : kShapes) {
    const std::string name = table.name;
    const std::string columns = database.Ask(
        "SELECT string_agg(quote_ident(column_name), ', ' ORDER BY ordinal_position) FROM "
        "information_schema.columns WHERE table_schema = 'ceilmap' AND table_name = '" +
        name + "' AND column_name <> 'geom'");
    database.Run(fmt::format(
        "CREATE OR REPLACE VIEW ceilmap.{0}_{1} AS SELECT {2}, geom::geometry({3}, {1}) "
        "AS geom FROM ceilmap.{0} WHERE ST_SRID(geom) = {1}",
        name,
        number,
        columns,
        table.geometry));
  }
  database.Commit();
}

}  // namespace ceilmap::store
