#include "mapping/store/table_rows.hpp"

#include <cmath>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::store::tables {
namespace {

/// Rows and columns of the values of MatrixColumns.
constexpr std::array<std::array<int, 2>, 6> kTriangle = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

}  // namespace

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

bool AddField(OGRLayer& layer, const char* name, OGRFieldType type) {
  OGRFieldDefn field(name, type);
  return layer.CreateField(&field) == OGRERR_NONE;
}

bool AddMatrixFields(OGRLayer& layer, const MatrixColumns& names) {
  for (const char* name : names) {
    if (!AddField(layer, name, OFTReal)) return false;
  }
  return true;
}

OGRFeatureUniquePtr NewRow(OGRLayer& layer) {
  return OGRFeatureUniquePtr(OGRFeature::CreateFeature(layer.GetLayerDefn()));
}

bool AddRow(OGRLayer& layer, OGRFeature& row) {
  return layer.CreateFeature(&row) == OGRERR_NONE;
}

void SetMatrix(OGRFeature& row, const MatrixColumns& names, const Eigen::Matrix3d& matrix) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    row.SetField(names[i], matrix(kTriangle[i][0], kTriangle[i][1]));
  }
}

void SetBytes(OGRFeature& row, const char* name, const void* bytes, std::size_t size) {
  row.SetField(row.GetFieldIndex(name), static_cast<int>(size), bytes);
}

void ThrowDamaged(OGRFeature& row, const std::string& what) {
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

std::string Text(OGRFeature& row, const char* name) {
  return row.GetFieldAsString(Column(row, name));
}

Eigen::Matrix3d Matrix(OGRFeature& row, const MatrixColumns& names) {
  Eigen::Matrix3d matrix;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [r, c] = kTriangle[i];
    matrix(r, c) = matrix(c, r) = Real(row, names[i]);
    if (r == c && matrix(r, c) < 0) ThrowDamaged(row, std::string("negative ") + names[i]);
  }
  return matrix;
}

Bytes BytesOf(OGRFeature& row, const char* name) {
  Bytes bytes;
  const int column = row.GetFieldIndex(name);
  if (column >= 0) bytes.data = row.GetFieldAsBinary(column, &bytes.size);
  return bytes;
}

void CheckCoordinates(OGRFeature& row, double x, double y) {
  constexpr double kMaxCoordinate = 1e9;
  if (!(std::abs(x) <= kMaxCoordinate && std::abs(y) <= kMaxCoordinate)) {
    ThrowDamaged(row, "position out of range");
  }
}

void SetPolygons(OGRFeature& row, const Polygons& polygons) {
  OGRMultiPolygon shape;
  for (const auto& rings : polygons) {
    OGRPolygon polygon;
    for (const auto& points : rings) {
      OGRLinearRing ring;
      for (const cv::Point2d& point : points) ring.addPoint(point.x, point.y);
      ring.closeRings();
      polygon.addRing(&ring);
    }
    shape.addGeometry(&polygon);
  }
  row.SetGeometry(&shape);
}

Polygons PolygonsOf(OGRFeature& row) {
  const OGRGeometry* geometry = row.GetGeometryRef();
  if (geometry == nullptr || wkbFlatten(geometry->getGeometryType()) != wkbMultiPolygon) {
    ThrowDamaged(row, "no polygons");
  }
  Polygons polygons;
  for (const OGRPolygon* polygon : *geometry->toMultiPolygon()) {
    if (polygon->IsEmpty()) continue;
    polygons.emplace_back();
    for (const OGRLinearRing* ring : *polygon) {
      std::vector<cv::Point2d> points;
      for (int i = 0; i + 1 < ring->getNumPoints(); ++i) {
        CheckCoordinates(row, ring->getX(i), ring->getY(i));
        points.emplace_back(ring->getX(i), ring->getY(i));
      }
      polygons.back().push_back(std::move(points));
    }
  }
  return polygons;
}

}  // namespace ceilmap::store::tables
