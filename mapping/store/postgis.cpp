#include "mapping/store/postgis.hpp"

#include <ogrsf_frmts.h>

#include <array>
#include <charconv>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/feature_tables.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/postgis_database.hpp"
#include "mapping/store/postgis_tables.hpp"
#include "mapping/store/site_layers.hpp"
#include "mapping/store/site_tables.hpp"
#include "mapping/store/table_rows.hpp"

namespace ceilmap::store {
namespace {

/// Shortest text that gives the same value when it is read. OGR would write 15 digits.
std::string ExactText(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string ValueOf(const OGRFeature& row, int column) {
  if (!row.IsFieldSetAndNotNull(column)) return "NULL";
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

std::string GeometryOf(const OGRFeature& row, int srid) {
  const OGRGeometry& geometry = *row.GetGeometryRef();
  std::vector<unsigned char> bytes(geometry.WkbSize());
  geometry.exportToWkb(wkbNDR, bytes.data());
  std::string text = "'";
  constexpr char kDigits[] = "0123456789abcdef";
  for (const unsigned char byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  text += "'";
  return srid == 0 ? text : "ST_SetSRID(" + text + "::geometry, " + std::to_string(srid) + ")";
}

/// A map in the database.
struct MapRow {
  int id = 0;
  int srid = 0;  ///< of the geometries
};

/// Inserts rows, many with each statement. A table in memory has the columns of the map file's, so
/// that rows are filled as there.
class RowWriter {
 public:
  using Create = OGRLayer* (*)(GDALDataset&, OGRSpatialReference&);

  RowWriter(PostgisDatabase& database, const MapRow& map, Create create)
      : database_(database), map_id_(std::to_string(map.id)), srid_(map.srid) {
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
    rows_ += (rows_.empty() ? "(" : ", (") + map_id_ + ", " + GeometryOf(*row, srid_);
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
  int srid_ = 0;
  GDALDatasetUniquePtr memory_;
  OGRLayer* columns_ = nullptr;
  std::string table_;
  std::string insert_;
  std::string rows_;
};

template <typename Rows>
void AddAll(PostgisDatabase& database,
            const MapRow& map,
            RowWriter::Create create,
            const Rows& rows) {
  RowWriter writer(database, map, create);
  for (const auto& row : rows) writer.Add(row);
  writer.Flush();
}

void AddEdges(PostgisDatabase& database, const MapRow& map, const graph::MapGraph& graph) {
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    poses[keyframe.id] = keyframe.pose.T_map_base;
  }
  RowWriter writer(database, map, tables::CreateEdges);
  for (const graph::Edge& edge : graph.edges) {
    writer.Add(edge, poses.at(edge.from), poses.at(edge.to));
  }
  writer.Flush();
}

void CheckIsFree(PostgisDatabase& database, const PostgisOptions& options) {
  if (options.replace ||
      database.Ask("SELECT id FROM ceilmap.maps WHERE name = " + Quoted(options.name)).empty()) {
    return;
  }
  throw InputError("the database has a map '" + Shown(options.name) +
                   "' already; give --force to replace it, or --name for another name");
}

/// Columns and values of an INSERT.
struct Insertion {
  std::string columns;
  std::string values;

  void Add(const std::string& column, const std::string& value) {
    columns += (columns.empty() ? "" : ", ") + column;
    values += (values.empty() ? "" : ", ") + value;
  }
};

int AddMap(PostgisDatabase& database,
           const MapMetadata& metadata,
           const PostgisOptions& options,
           int srid) {
  Insertion map;
  map.Add("name", Quoted(options.name));
  map.Add("unit", Quoted(options.frame == Frame::kSite ? "m" : metadata.unit));
  map.Add("resolution", ExactText(metadata.resolution));
  map.Add("ceiling_height_m", ExactText(metadata.ceiling_height_m));
  map.Add("robot", Quoted(metadata.robot));
  map.Add("program_version", Quoted(metadata.program_version));
  map.Add("provenance", Quoted(metadata.provenance));
  map.Add("mosaic", options.mosaic.empty() ? "NULL" : Quoted(options.mosaic));
  map.Add("frame", Quoted(options.frame == Frame::kSite ? "site" : "map"));
  map.Add("srid", std::to_string(srid));
  if (metadata.site) {
    const Similarity2& S_site_map = metadata.site->S_site_map;
    map.Add("site_crs", Quoted(metadata.site->crs_wkt));
    map.Add("site_scale", ExactText(S_site_map.scale));
    map.Add("site_x", ExactText(S_site_map.motion.x));
    map.Add("site_y", ExactText(S_site_map.motion.y));
    map.Add("site_yaw_rad", ExactText(S_site_map.motion.yaw));
  }
  database.Run("DELETE FROM ceilmap.maps WHERE name = " + Quoted(options.name));
  return std::stoi(database.Ask("INSERT INTO ceilmap.maps (" + map.columns + ") VALUES (" +
                                map.values + ") RETURNING id"));
}

/// The rows of a map, in the coordinates of the export.
struct MapRows {
  graph::MapGraph graph;
  std::vector<LeftOut> left_out;
  std::vector<survey::AlignedPoint> control_points;
};

MapRows ReadRows(const MapReader& map, Frame frame) {
  MapRows rows{map.ReadGraph(), map.ReadLeftOut(), {}};
  if (map.Metadata().site) rows.control_points = map.Metadata().site->points;
  const survey::SiteFrame* site = SiteOf(map, frame);
  if (site == nullptr) return rows;
  rows.graph = InSite(*site, std::move(rows.graph));
  for (LeftOut& places : rows.left_out) places = InSite(*site, std::move(places));
  // Their geometry: where they were surveyed.
  for (survey::AlignedPoint& point : rows.control_points) point.point.p_map = point.point.p_site;
  return rows;
}

void AddRows(PostgisDatabase& database, const MapRow& map, const MapRows& rows) {
  AddAll(database, map, tables::CreateKeyframes, rows.graph.keyframes);
  AddAll(database, map, tables::CreateTrajectory, rows.graph.trajectory);
  AddEdges(database, map, rows.graph);
  AddAll(database, map, tables::CreateWeakSpots, rows.graph.weak_spots);
  AddAll(database, map, tables::CreateLeftOut, rows.left_out);
  AddAll(database, map, tables::CreateControlPoints, rows.control_points);
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
  const MapRows rows = ReadRows(map, options.frame);
  PostgisDatabase database(connection);
  MakePostgisTables(database);
  CheckIsFree(database, options);
  const auto& site = map.Metadata().site;
  const int srid = site ? SridOf(database, site->crs_wkt) : 0;
  const bool in_site = options.frame == Frame::kSite;
  if (in_site && srid != 0) MakePostgisViews(database, srid);
  if (options.before_writing) options.before_writing();
  // Without Commit the server takes all back when the connection ends.
  database.Begin();
  database.LockName(options.name);
  CheckIsFree(database, options);
  const int id = AddMap(database, map.Metadata(), options, srid);
  AddRows(database, {id, in_site ? srid : 0}, rows);
  database.Commit();
}

}  // namespace ceilmap::store
