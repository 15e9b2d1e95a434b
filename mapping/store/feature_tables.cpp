#include "mapping/store/feature_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "mapping/store/map_tables.hpp"
#include "mapping/store/table_rows.hpp"

namespace ceilmap::store::tables {
namespace {

constexpr MatrixColumns kCovariance = {"cxx", "cxy", "cxyaw", "cyy", "cyyaw", "cyawyaw"};
constexpr MatrixColumns kInformation = {"ixx", "ixy", "ixyaw", "iyy", "iyyaw", "iyawyaw"};

// For a robot with a measured tilt; maps of earlier versions do not have these columns.
constexpr char kPitch[] = "pitch_rad";
constexpr char kRoll[] = "roll_rad";
constexpr char kLift[] = "lift";

// In the order of graph::Edge::Kind.
constexpr std::array<const char*, 3> kEdgeKinds = {"odometry", "loop_closure", "wheels"};

bool AddFrameFields(OGRLayer& layer) {
  return AddField(layer, "frame_index", OFTInteger64) &&
         AddField(layer, "keyframe_id", OFTInteger64) && AddField(layer, "stamp_s", OFTReal) &&
         AddField(layer, "yaw_rad", OFTReal) && AddField(layer, kPitch, OFTReal) &&
         AddField(layer, kRoll, OFTReal) && AddField(layer, kLift, OFTReal) &&
         AddField(layer, "status", OFTString) && AddMatrixFields(layer, kCovariance);
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

graph::TrackingStatus Status(OGRFeature& row) {
  const std::string text = Text(row, "status");
  for (const graph::TrackingStatus status : {graph::TrackingStatus::kTracking,
                                             graph::TrackingStatus::kRelocalized,
                                             graph::TrackingStatus::kPredicted,
                                             graph::TrackingStatus::kAmbiguous,
                                             graph::TrackingStatus::kLost}) {
    if (text == graph::ToString(status)) return status;
  }
  ThrowDamaged(row, "unknown status");
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

template <typename... Values>
bool AppendFilled(OGRLayer& layer, const Values&... values) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  Fill(*row, values...);
  return AddRow(layer, *row);
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

void Fill(OGRFeature& row, const graph::Keyframe& keyframe) {
  row.SetFID(keyframe.id);
  SetFrame(row, keyframe.pose);
  row.SetField("ambiguous", keyframe.ambiguous ? 1 : 0);
}

void Fill(OGRFeature& row, const graph::FramePose& frame) {
  SetFrame(row, frame);
}

void Fill(OGRFeature& row,
          const graph::Edge& edge,
          const Pose2& T_map_from,
          const Pose2& T_map_to) {
  row.SetField("from_id", static_cast<GIntBig>(edge.from));
  row.SetField("to_id", static_cast<GIntBig>(edge.to));
  row.SetField("kind", kEdgeKinds.at(static_cast<std::size_t>(edge.kind)));
  row.SetField("x", edge.T_from_to.x);
  row.SetField("y", edge.T_from_to.y);
  row.SetField("yaw_rad", edge.T_from_to.yaw);
  SetMatrix(row, kInformation, edge.information);
  OGRLineString line;
  line.addPoint(T_map_from.x, T_map_from.y);
  line.addPoint(T_map_to.x, T_map_to.y);
  row.SetGeometry(&line);
}

void Fill(OGRFeature& row, const graph::WeakSpot& spot) {
  row.SetField("kind", graph::ToString(spot.kind));
  row.SetField("keyframe_id", static_cast<GIntBig>(spot.keyframe_id));
  row.SetField("extent", spot.extent);
  const OGRPoint point(spot.x, spot.y);
  row.SetGeometry(&point);
}

void Fill(OGRFeature& row, const LeftOut& places) {
  row.SetField("kind", ToString(places.kind));
  row.SetField("area", places.area);
  SetPolygons(row, places.polygons);
}

bool Append(OGRLayer& layer, const graph::Keyframe& keyframe) {
  return AppendFilled(layer, keyframe);
}

bool Append(OGRLayer& layer, const graph::FramePose& frame) {
  return AppendFilled(layer, frame);
}

bool Append(OGRLayer& layer,
            const graph::Edge& edge,
            const Pose2& T_map_from,
            const Pose2& T_map_to) {
  return AppendFilled(layer, edge, T_map_from, T_map_to);
}

bool Append(OGRLayer& layer, const graph::WeakSpot& spot) {
  return AppendFilled(layer, spot);
}

bool Append(OGRLayer& layer, const LeftOut& places) {
  return AppendFilled(layer, places);
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
  const std::string kind = Text(row, "kind");
  const auto* const known = std::find(kEdgeKinds.begin(), kEdgeKinds.end(), kind);
  if (known == kEdgeKinds.end()) ThrowDamaged(row, "unknown kind");
  edge.kind = static_cast<graph::Edge::Kind>(known - kEdgeKinds.begin());
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
  const std::string text = Text(row, "kind");
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
  const std::string text = Text(row, "kind");
  const auto kinds = {LeftOut::Kind::kBelowCeiling, LeftOut::Kind::kMoves};
  const auto* kind = std::find_if(kinds.begin(), kinds.end(), [&](LeftOut::Kind candidate) {
    return text == ToString(candidate);
  });
  if (kind == kinds.end()) ThrowDamaged(row, "unknown kind");
  places.kind = *kind;
  places.polygons = PolygonsOf(row);
  return places;
}

}  // namespace ceilmap::store::tables
