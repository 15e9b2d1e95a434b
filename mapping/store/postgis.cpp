#include "mapping/store/postgis.hpp"

#include <ogrsf_frmts.h>

#include <array>
#include <charconv>
#include <string>
#include <unordered_map>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/gdal_support.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/table_rows.hpp"

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
};
#undef CEILMAP_FRAME_COLUMNS
#undef CEILMAP_ROW_COLUMNS

/// Numbers of PostgreSQL's advisory locks: this program's, and that of its tables. Names of maps
/// have a hash as the second number.
constexpr char kTablesLock[] = "SELECT pg_advisory_xact_lock(1667591021, 0)::text";
constexpr char kNameLock[] = "SELECT pg_advisory_xact_lock(1667591022, hashtext(";

std::string Quoted(const std::string& text) {
  std::string quoted = "E'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    if (c == '\0') continue;  // which PostgreSQL has not
    quoted += c;
  }
  return quoted + "'";
}

/// A connection with one transaction at a time.
class PostgisDatabase {
 public:
  explicit PostgisDatabase(const std::string& connection);

  void Begin() { Check(dataset_->StartTransaction() == OGRERR_NONE); }
  void Commit() { Check(dataset_->CommitTransaction() == OGRERR_NONE); }
  void Run(const std::string& sql);
  /// The first column of the only row; empty without a row.
  std::string Ask(const std::string& sql);
  void Check(bool succeeded) const;

 private:
  static std::string ForGdal(const std::string& connection);

  GdalScope gdal_;  // messages of all calls
  GDALDatasetUniquePtr dataset_;
};

std::string PostgisDatabase::ForGdal(const std::string& connection) {
  return connection.starts_with("PG:") ? connection : "PG:" + connection;
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

/// Shortest text that gives the same value when it is read. OGR would write 15 digits.
std::string ExactText(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string ValueOf(const OGRFeature& row, int column) {
  switch (row.GetFieldDefnRef(column)->GetType()) {
    case OFTReal:
      return ExactText(row.GetFieldAsDouble(column));
    case OFTInteger:
    case OFTInteger64:
      return std::to_string(row.GetFieldAsInteger64(column));
    default:
      return Quoted(row.GetFieldAsString(column));
  }
}

std::string GeometryOf(const OGRFeature& row) {
  const OGRGeometry& geometry = *row.GetGeometryRef();
  std::vector<unsigned char> bytes(geometry.WkbSize());
  geometry.exportToWkb(wkbNDR, bytes.data());
  std::string text = "'";
  constexpr char kDigits[] = "0123456789abcdef";
  for (const unsigned char byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text + "'";
}

/// Inserts rows, many with each statement. A table in memory has the columns of the map file's, so
/// that rows are filled as there.
class RowWriter {
 public:
  using Create = OGRLayer* (*)(GDALDataset&, OGRSpatialReference&);

  RowWriter(PostgisDatabase& database, int map_id, Create create)
      : database_(database), map_id_(std::to_string(map_id)) {
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("Memory");
    if (driver != nullptr) memory_.reset(driver->Create("", 0, 0, 0, GDT_Unknown, nullptr));
    OGRSpatialReference srs;
    if (memory_) columns_ = create(*memory_, srs);
    database_.Check(columns_ != nullptr);
    table_ = columns_->GetName();
    OGRFeatureDefn& definition = *columns_->GetLayerDefn();
    insert_ = "INSERT INTO ceilmap." + table_ + " (map_id, geom";
    if (HasId()) insert_ += ", id";
    for (int i = 0; i < definition.GetFieldCount(); ++i) {
      insert_ += std::string(", ") + definition.GetFieldDefn(i)->GetNameRef();
    }
    insert_ += ") VALUES ";
  }

  template <typename... Values>
  void Add(const Values&... values) {
    constexpr std::size_t kMaxBytes = 1 << 18;
    const OGRFeatureUniquePtr row = tables::NewRow(*columns_);
    tables::Fill(*row, values...);
    rows_ += (rows_.empty() ? "(" : ", (") + map_id_ + ", " + GeometryOf(*row);
    if (HasId()) rows_ += ", " + std::to_string(row->GetFID());
    for (int i = 0; i < row->GetFieldCount(); ++i) rows_ += ", " + ValueOf(*row, i);
    rows_ += ")";
    if (rows_.size() > kMaxBytes) Flush();
  }
  void Flush() {
    if (!rows_.empty()) database_.Run(insert_ + rows_);
    rows_.clear();
  }

 private:
  /// Whether the id of a row has a meaning.
  [[nodiscard]] bool HasId() const { return table_ == tables::kKeyframes; }

  PostgisDatabase& database_;
  std::string map_id_;
  GDALDatasetUniquePtr memory_;
  OGRLayer* columns_ = nullptr;
  std::string table_;
  std::string insert_;
  std::string rows_;
};

template <typename Rows>
void AddAll(PostgisDatabase& database, int id, RowWriter::Create create, const Rows& rows) {
  RowWriter writer(database, id, create);
  for (const auto& row : rows) writer.Add(row);
  writer.Flush();
}

void AddEdges(PostgisDatabase& database, int id, const graph::MapGraph& graph) {
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    poses[keyframe.id] = keyframe.pose.T_map_base;
  }
  RowWriter writer(database, id, tables::CreateEdges);
  for (const graph::Edge& edge : graph.edges) {
    writer.Add(edge, poses.at(edge.from), poses.at(edge.to));
  }
  writer.Flush();
}

void MakeTables(PostgisDatabase& database) {
  if (database.Ask("SELECT 1 FROM pg_extension WHERE extname = 'postgis'").empty()) {
    throw InputError(
        "the database has no PostGIS; run 'CREATE EXTENSION postgis' in it, as its owner");
  }
  // A user who may only write rows needs no right to make tables.
  if (!database.Ask("SELECT 1 WHERE to_regclass('ceilmap.left_out') IS NOT NULL").empty()) return;
  database.Begin();
  database.Ask(kTablesLock);
  for (const char* sql : kMakeTables) database.Run(sql);
  database.Commit();
}

void CheckIsFree(PostgisDatabase& database, const PostgisOptions& options) {
  if (options.replace ||
      database.Ask("SELECT id FROM ceilmap.maps WHERE name = " + Quoted(options.name)).empty()) {
    return;
  }
  throw InputError("the database has a map '" + Shown(options.name) +
                   "' already; give --force to replace it, or --name for another name");
}

int AddMap(PostgisDatabase& database, const MapMetadata& metadata, const PostgisOptions& options) {
  database.Run("DELETE FROM ceilmap.maps WHERE name = " + Quoted(options.name));
  const std::string id = database.Ask(
      "INSERT INTO ceilmap.maps (name, unit, resolution, ceiling_height_m, robot, program_version, "
      "provenance, mosaic) VALUES (" +
      Quoted(options.name) + ", " + Quoted(metadata.unit) + ", " + ExactText(metadata.resolution) +
      ", " + ExactText(metadata.ceiling_height_m) + ", " + Quoted(metadata.robot) + ", " +
      Quoted(metadata.program_version) + ", " + Quoted(metadata.provenance) + ", " +
      (options.mosaic.empty() ? "NULL" : Quoted(options.mosaic)) + ") RETURNING id");
  return std::stoi(id);
}

}  // namespace

bool IsPostgisConnection(const std::string& text) {
  return text.starts_with("PG:") || text.starts_with("postgresql://") ||
         text.starts_with("postgres://");
}

void ExportPostgis(const MapReader& map,
                   const std::string& connection,
                   const PostgisOptions& options) {
  if (!IsPostgisConnection(connection)) {
    throw InputError(
        "a database is named by 'PG:host=HOST dbname=NAME user=USER' or 'postgresql://...'");
  }
  const graph::MapGraph graph = map.ReadGraph();
  const std::vector<LeftOut> left_out = map.ReadLeftOut();
  PostgisDatabase database(connection);
  MakeTables(database);
  CheckIsFree(database, options);
  if (options.before_writing) options.before_writing();
  // Without Commit the server takes all back when the connection ends.
  database.Begin();
  database.Ask(kNameLock + Quoted(options.name) + "))::text");
  CheckIsFree(database, options);
  const int id = AddMap(database, map.Metadata(), options);
  AddAll(database, id, tables::CreateKeyframes, graph.keyframes);
  AddAll(database, id, tables::CreateTrajectory, graph.trajectory);
  AddEdges(database, id, graph);
  AddAll(database, id, tables::CreateWeakSpots, graph.weak_spots);
  AddAll(database, id, tables::CreateLeftOut, left_out);
  database.Commit();
}

}  // namespace ceilmap::store
