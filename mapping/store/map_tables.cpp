#include "mapping/store/map_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::store::tables {
namespace {

/// The upper triangle of a symmetric 3 x 3 matrix over (x, y, yaw), row by row.
constexpr std::array<std::array<int, 2>, 6> kTriangle = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
constexpr std::array<const char*, 6> kCovariance = {
    "cxx", "cxy", "cxyaw", "cyy", "cyyaw", "cyawyaw"};
constexpr std::array<const char*, 6> kInformation = {
    "ixx", "ixy", "ixyaw", "iyy", "iyyaw", "iyawyaw"};

// For a robot with a measured tilt; maps of earlier versions do not have these columns.
constexpr char kPitch[] = "pitch_rad";
constexpr char kRoll[] = "roll_rad";
constexpr char kLift[] = "lift";

constexpr char kFloats[] = "float32";  // of descriptors and heights

constexpr double kMaxCoordinate = 1e9;

// Cells are stored as they are in memory: rho, sigma, row by row.
static_assert(sizeof(heights::HeightCell) == 2 * sizeof(float));
constexpr int kMaxHeightCells = 1 << 14;  // columns, rows
constexpr double kMaxPixel = 1 << 15;     // coordinates in an image
constexpr double kMaxRatio = 1e3;         // of heights, and of their inverse

using FeaturePtr = OGRFeatureUniquePtr;

FeaturePtr NewRow(OGRLayer& layer) {
  return FeaturePtr(OGRFeature::CreateFeature(layer.GetLayerDefn()));
}

bool AddField(OGRLayer& layer, const char* name, OGRFieldType type) {
  OGRFieldDefn field(name, type);
  return layer.CreateField(&field) == OGRERR_NONE;
}

bool AddMatrixFields(OGRLayer& layer, const std::array<const char*, 6>& names) {
  for (const char* name : names) {
    if (!AddField(layer, name, OFTReal)) return false;
  }
  return true;
}

bool AddFrameFields(OGRLayer& layer) {
  return AddField(layer, "frame_index", OFTInteger64) &&
         AddField(layer, "keyframe_id", OFTInteger64) && AddField(layer, "stamp_s", OFTReal) &&
         AddField(layer, "yaw_rad", OFTReal) && AddField(layer, kPitch, OFTReal) &&
         AddField(layer, kRoll, OFTReal) && AddField(layer, kLift, OFTReal) &&
         AddField(layer, "status", OFTString) && AddMatrixFields(layer, kCovariance);
}

OGRLayer* CreateTable(GDALDataset& dataset,
                      const char* name,
                      OGRSpatialReference* srs,
                      OGRwkbGeometryType geometry,
                      const char* id_column) {
  CPLStringList options;
  options.SetNameValue("FID", id_column);
  if (geometry == wkbNone) {
    options.SetNameValue("ASPATIAL_VARIANT", "GPKG_ATTRIBUTES");
  } else {
    options.SetNameValue("GEOMETRY_NAME", "geom");
  }
  return dataset.CreateLayer(name, srs, geometry, options.List());
}

void SetMatrix(OGRFeature& row,
               const std::array<const char*, 6>& names,
               const Eigen::Matrix3d& matrix) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    row.SetField(names[i], matrix(kTriangle[i][0], kTriangle[i][1]));
  }
}

void SetFrame(OGRFeature& row, const graph::FramePose& frame) {
  row.SetField("frame_index", static_cast<GIntBig>(frame.frame_index));
  row.SetField("keyframe_id", static_cast<GIntBig>(frame.keyframe_id));
  row.SetField("stamp_s", frame.stamp_s);
  row.SetField("yaw_rad", frame.T_map_base.yaw);
  row.SetField(kPitch, frame.tilt.pitch_rad);
  row.SetField(kRoll, frame.tilt.roll_rad);
  row.SetField(kLift, frame.tilt.lift_m);
  row.SetField("status", graph::ToString(frame.status));
  SetMatrix(row, kCovariance, frame.covariance);
  const OGRPoint point(frame.T_map_base.x, frame.T_map_base.y);
  row.SetGeometry(&point);
}

[[noreturn]] void ThrowDamaged(OGRFeature& row, const std::string& what) {
  throw InputError(std::string("table ") + row.GetDefnRef()->GetName() + ", row " +
                   std::to_string(row.GetFID()) + ": " + what + "; the file is damaged");
}

int Column(OGRFeature& row, const char* name) {
  const int column = row.GetFieldIndex(name);
  if (column < 0 || !row.IsFieldSetAndNotNull(column)) {
    ThrowDamaged(row, std::string("no value in column '") + name + "'");
  }
  return column;
}

double Real(OGRFeature& row, const char* name) {
  const double value = row.GetFieldAsDouble(Column(row, name));
  if (!std::isfinite(value)) ThrowDamaged(row, std::string("column '") + name + "' is not finite");
  return value;
}

std::int64_t Integer(OGRFeature& row, const char* name) {
  return row.GetFieldAsInteger64(Column(row, name));
}

Eigen::Matrix3d Matrix(OGRFeature& row, const std::array<const char*, 6>& names) {
  Eigen::Matrix3d matrix;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [r, c] = kTriangle[i];
    matrix(r, c) = matrix(c, r) = Real(row, names[i]);
  }
  return matrix;
}

graph::TrackingStatus Status(OGRFeature& row) {
  const std::string text = row.GetFieldAsString(Column(row, "status"));
  for (const graph::TrackingStatus status : {graph::TrackingStatus::kTracking,
                                             graph::TrackingStatus::kRelocalized,
                                             graph::TrackingStatus::kAmbiguous,
                                             graph::TrackingStatus::kLost}) {
    if (text == graph::ToString(status)) return status;
  }
  ThrowDamaged(row, "unknown status");
}

void CheckCoordinates(OGRFeature& row, double x, double y) {
  if (!(std::abs(x) <= kMaxCoordinate && std::abs(y) <= kMaxCoordinate)) {
    ThrowDamaged(row, "position out of range");
  }
}

Eigen::Vector2d Point(OGRFeature& row) {
  const OGRGeometry* geometry = row.GetGeometryRef();
  if (geometry == nullptr || wkbFlatten(geometry->getGeometryType()) != wkbPoint ||
      geometry->IsEmpty()) {
    ThrowDamaged(row, "no point");
  }
  const OGRPoint& point = *geometry->toPoint();
  CheckCoordinates(row, point.getX(), point.getY());
  return {point.getX(), point.getY()};
}

}  // namespace

OGRLayer* CreateKeyframes(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kKeyframes, &srs, wkbPoint, "id");
  const bool done =
      layer != nullptr && AddFrameFields(*layer) && AddField(*layer, "ambiguous", OFTInteger);
  return done ? layer : nullptr;
}

OGRLayer* CreateTrajectory(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kTrajectory, &srs, wkbPoint, "fid");
  return layer != nullptr && AddFrameFields(*layer) ? layer : nullptr;
}

OGRLayer* CreateEdges(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kEdges, &srs, wkbLineString, "fid");
  const bool done = layer != nullptr && AddField(*layer, "from_id", OFTInteger64) &&
                    AddField(*layer, "to_id", OFTInteger64) &&
                    AddField(*layer, "kind", OFTString) && AddField(*layer, "x", OFTReal) &&
                    AddField(*layer, "y", OFTReal) && AddField(*layer, "yaw_rad", OFTReal) &&
                    AddMatrixFields(*layer, kInformation);
  return done ? layer : nullptr;
}

OGRLayer* CreateWeakSpots(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kWeakSpots, &srs, wkbPoint, "fid");
  const bool done = layer != nullptr && AddField(*layer, "kind", OFTString) &&
                    AddField(*layer, "keyframe_id", OFTInteger64) &&
                    AddField(*layer, "extent", OFTReal);
  return done ? layer : nullptr;
}

OGRLayer* CreateLeftOut(GDALDataset& dataset, OGRSpatialReference& srs) {
  OGRLayer* layer = CreateTable(dataset, kLeftOut, &srs, wkbMultiPolygon, "fid");
  const bool done =
      layer != nullptr && AddField(*layer, "kind", OFTString) && AddField(*layer, "area", OFTReal);
  return done ? layer : nullptr;
}

OGRLayer* CreateImages(GDALDataset& dataset, const char* name) {
  OGRLayer* layer = CreateTable(dataset, name, nullptr, wkbNone, "id");
  return layer != nullptr && AddField(*layer, kPng, OFTBinary) ? layer : nullptr;
}

OGRLayer* CreateDescriptors(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kDescriptors, nullptr, wkbNone, "id");
  const bool done = layer != nullptr && AddField(*layer, "columns", OFTInteger) &&
                    AddField(*layer, kFloats, OFTBinary);
  return done ? layer : nullptr;
}

OGRLayer* CreateHeights(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kHeights, nullptr, wkbNone, "id");
  const bool done = layer != nullptr && AddField(*layer, "columns", OFTInteger) &&
                    AddField(*layer, "rows", OFTInteger) && AddField(*layer, "first_u", OFTReal) &&
                    AddField(*layer, "first_v", OFTReal) && AddField(*layer, "step_u", OFTReal) &&
                    AddField(*layer, "step_v", OFTReal) &&
                    AddField(*layer, "scale_sigma", OFTReal) &&
                    AddField(*layer, kFloats, OFTBinary);
  return done ? layer : nullptr;
}

OGRLayer* CreateMetadata(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kMetadata, nullptr, wkbNone, "fid");
  const bool done =
      layer != nullptr && AddField(*layer, kKey, OFTString) && AddField(*layer, kValue, OFTString);
  return done ? layer : nullptr;
}

bool Append(OGRLayer& layer, const graph::Keyframe& keyframe) {
  const FeaturePtr row = NewRow(layer);
  row->SetFID(keyframe.id);
  SetFrame(*row, keyframe.pose);
  row->SetField("ambiguous", keyframe.ambiguous ? 1 : 0);
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, const graph::FramePose& frame) {
  const FeaturePtr row = NewRow(layer);
  SetFrame(*row, frame);
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer,
            const graph::Edge& edge,
            const Pose2& T_map_from,
            const Pose2& T_map_to) {
  const FeaturePtr row = NewRow(layer);
  row->SetField("from_id", static_cast<GIntBig>(edge.from));
  row->SetField("to_id", static_cast<GIntBig>(edge.to));
  row->SetField("kind", edge.kind == graph::Edge::Kind::kLoopClosure ? "loop_closure" : "odometry");
  row->SetField("x", edge.T_from_to.x);
  row->SetField("y", edge.T_from_to.y);
  row->SetField("yaw_rad", edge.T_from_to.yaw);
  SetMatrix(*row, kInformation, edge.information);
  OGRLineString line;
  line.addPoint(T_map_from.x, T_map_from.y);
  line.addPoint(T_map_to.x, T_map_to.y);
  row->SetGeometry(&line);
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, const graph::WeakSpot& spot) {
  const FeaturePtr row = NewRow(layer);
  row->SetField("kind", graph::ToString(spot.kind));
  row->SetField("keyframe_id", static_cast<GIntBig>(spot.keyframe_id));
  row->SetField("extent", spot.extent);
  const OGRPoint point(spot.x, spot.y);
  row->SetGeometry(&point);
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, const LeftOut& places) {
  const FeaturePtr row = NewRow(layer);
  row->SetField("kind", ToString(places.kind));
  row->SetField("area", places.area);
  OGRMultiPolygon shape;
  for (const auto& rings : places.polygons) {
    OGRPolygon polygon;
    for (const auto& points : rings) {
      OGRLinearRing ring;
      for (const cv::Point2d& point : points) ring.addPoint(point.x, point.y);
      ring.closeRings();
      polygon.addRing(&ring);
    }
    shape.addGeometry(&polygon);
  }
  row->SetGeometry(&shape);
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const std::vector<unsigned char>& png) {
  const FeaturePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  row->SetField(row->GetFieldIndex(kPng), static_cast<int>(png.size()), png.data());
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const cv::Mat& descriptors) {
  const FeaturePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  row->SetField("columns", descriptors.cols);
  const cv::Mat whole = descriptors.isContinuous() ? descriptors : descriptors.clone();
  row->SetField(
      row->GetFieldIndex(kFloats), static_cast<int>(whole.total() * sizeof(float)), whole.ptr());
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const heights::HeightField& heights) {
  const FeaturePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  row->SetField("columns", heights.grid.width);
  row->SetField("rows", heights.grid.height);
  row->SetField("first_u", heights.first_px.x());
  row->SetField("first_v", heights.first_px.y());
  row->SetField("step_u", heights.step_px.x());
  row->SetField("step_v", heights.step_px.y());
  row->SetField("scale_sigma", heights.scale_sigma);
  row->SetField(row->GetFieldIndex(kFloats),
                static_cast<int>(heights.cells.size() * sizeof(heights::HeightCell)),
                heights.cells.data());
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

bool Append(OGRLayer& layer, const std::string& key, const std::string& value) {
  const FeaturePtr row = NewRow(layer);
  row->SetField(kKey, key.c_str());
  row->SetField(kValue, value.c_str());
  return layer.CreateFeature(row.get()) == OGRERR_NONE;
}

graph::FramePose ToFramePose(OGRFeature& row) {
  const Eigen::Vector2d point = Point(row);
  graph::FramePose frame;
  frame.frame_index = Integer(row, "frame_index");
  frame.keyframe_id = Integer(row, "keyframe_id");
  frame.stamp_s = Real(row, "stamp_s");
  frame.status = Status(row);
  frame.T_map_base = {point.x(), point.y(), Real(row, "yaw_rad")};
  if (row.GetFieldIndex(kPitch) >= 0) {
    frame.tilt.pitch_rad = Real(row, kPitch);
    frame.tilt.roll_rad = Real(row, kRoll);
    frame.tilt.lift_m = Real(row, kLift);
  }
  frame.covariance = Matrix(row, kCovariance);
  return frame;
}

graph::Keyframe ToKeyframe(OGRFeature& row) {
  graph::Keyframe keyframe;
  keyframe.id = row.GetFID();
  if (keyframe.id < 0) ThrowDamaged(row, "negative id");
  keyframe.pose = ToFramePose(row);
  keyframe.ambiguous = Integer(row, "ambiguous") != 0;
  return keyframe;
}

graph::Edge ToEdge(OGRFeature& row) {
  graph::Edge edge;
  edge.from = Integer(row, "from_id");
  edge.to = Integer(row, "to_id");
  const std::string kind = row.GetFieldAsString(Column(row, "kind"));
  if (kind != "odometry" && kind != "loop_closure") ThrowDamaged(row, "unknown kind");
  edge.kind = kind == "odometry" ? graph::Edge::Kind::kOdometry : graph::Edge::Kind::kLoopClosure;
  edge.T_from_to = {Real(row, "x"), Real(row, "y"), Real(row, "yaw_rad")};
  CheckCoordinates(row, edge.T_from_to.x, edge.T_from_to.y);
  edge.information = Matrix(row, kInformation);
  return edge;
}

graph::WeakSpot ToWeakSpot(OGRFeature& row) {
  graph::WeakSpot spot;
  const Eigen::Vector2d point = Point(row);
  spot.x = point.x();
  spot.y = point.y();
  spot.keyframe_id = Integer(row, "keyframe_id");
  spot.extent = Real(row, "extent");
  const std::string text = row.GetFieldAsString(Column(row, "kind"));
  for (const graph::WeakSpot::Kind kind : {graph::WeakSpot::Kind::kAmbiguous,
                                           graph::WeakSpot::Kind::kLost,
                                           graph::WeakSpot::Kind::kUnclosed}) {
    if (text == graph::ToString(kind)) {
      spot.kind = kind;
      return spot;
    }
  }
  ThrowDamaged(row, "unknown kind");
}

LeftOut ToLeftOut(OGRFeature& row) {
  LeftOut places;
  places.area = Real(row, "area");
  if (!(places.area >= 0)) ThrowDamaged(row, "a negative area");
  const std::string text = row.GetFieldAsString(Column(row, "kind"));
  const auto kinds = {LeftOut::Kind::kBelowCeiling, LeftOut::Kind::kMoves};
  const auto* kind = std::find_if(kinds.begin(), kinds.end(), [&](LeftOut::Kind candidate) {
    return text == ToString(candidate);
  });
  if (kind == kinds.end()) ThrowDamaged(row, "unknown kind");
  places.kind = *kind;
  const OGRGeometry* geometry = row.GetGeometryRef();
  if (geometry == nullptr || wkbFlatten(geometry->getGeometryType()) != wkbMultiPolygon) {
    ThrowDamaged(row, "no polygons");
  }
  for (const OGRPolygon* polygon : *geometry->toMultiPolygon()) {
    places.polygons.emplace_back();
    for (const OGRLinearRing* ring : *polygon) {
      std::vector<cv::Point2d> points;
      for (int i = 0; i + 1 < ring->getNumPoints(); ++i) {
        CheckCoordinates(row, ring->getX(i), ring->getY(i));
        points.emplace_back(ring->getX(i), ring->getY(i));
      }
      places.polygons.back().push_back(std::move(points));
    }
  }
  return places;
}

std::pair<std::int64_t, std::shared_ptr<const heights::HeightField>> ToHeights(OGRFeature& row) {
  const std::int64_t columns = Integer(row, "columns");
  const std::int64_t rows = Integer(row, "rows");
  int bytes = 0;
  const int field = row.GetFieldIndex(kFloats);
  const GByte* data = field >= 0 ? row.GetFieldAsBinary(field, &bytes) : nullptr;
  if (columns < 1 || columns > kMaxHeightCells || rows < 1 || rows > kMaxHeightCells ||
      bytes != columns * rows * static_cast<std::int64_t>(sizeof(heights::HeightCell))) {
    ThrowDamaged(row, "heights of an impossible size");
  }
  auto field_of_heights = std::make_shared<heights::HeightField>();
  heights::HeightField& result = *field_of_heights;
  result.grid = {static_cast<int>(columns), static_cast<int>(rows)};
  result.first_px = {Real(row, "first_u"), Real(row, "first_v")};
  result.step_px = {Real(row, "step_u"), Real(row, "step_v")};
  result.scale_sigma = Real(row, "scale_sigma");
  if (result.first_px.cwiseAbs().maxCoeff() > kMaxPixel || result.step_px.minCoeff() <= 0 ||
      result.step_px.maxCoeff() > kMaxPixel || result.scale_sigma < 0) {
    ThrowDamaged(row, "heights on an impossible grid");
  }
  result.cells.resize(static_cast<std::size_t>(columns * rows));
  std::memcpy(result.cells.data(), data, static_cast<std::size_t>(bytes));
  for (const heights::HeightCell& cell : result.cells) {
    if (!(cell.rho >= 1 / kMaxRatio && cell.rho <= kMaxRatio && cell.sigma >= 0 &&
          cell.sigma <= kMaxRatio)) {
      ThrowDamaged(row, "heights out of range");
    }
  }
  return {row.GetFID(), std::move(field_of_heights)};
}

std::vector<unsigned char> ReadPng(OGRLayer& images, std::int64_t keyframe_id) {
  const FeaturePtr row(images.GetFeature(keyframe_id));
  const int column = row ? row->GetFieldIndex(kPng) : -1;
  int size = 0;
  const GByte* bytes = column >= 0 ? row->GetFieldAsBinary(column, &size) : nullptr;
  if (bytes == nullptr || size <= 0) {
    throw InputError("the map holds no image of keyframe " + std::to_string(keyframe_id));
  }
  return {bytes, bytes + size};
}

cv::Mat ReadDescriptors(OGRLayer& descriptors, std::int64_t keyframe_id) {
  constexpr int kMaxColumns = 1 << 16;
  const FeaturePtr row(descriptors.GetFeature(keyframe_id));
  if (!row) {
    throw InputError("the map holds no place descriptors of keyframe " +
                     std::to_string(keyframe_id));
  }
  const std::int64_t columns = Integer(*row, "columns");
  int bytes = 0;
  const int field = row->GetFieldIndex(kFloats);
  const GByte* data = field >= 0 ? row->GetFieldAsBinary(field, &bytes) : nullptr;
  if (columns < 1 || columns > kMaxColumns || bytes % (columns * sizeof(float)) != 0) {
    ThrowDamaged(*row, "place descriptors of an impossible size");
  }
  const int cols = static_cast<int>(columns);
  cv::Mat result(bytes / (cols * static_cast<int>(sizeof(float))), cols, CV_32FC1);
  if (bytes > 0) std::copy_n(data, bytes, result.ptr());
  if (!cv::checkRange(result)) ThrowDamaged(*row, "place descriptors that are not finite");
  return result;
}

}  // namespace ceilmap::store::tables
