#pragma once

#include <ogrsf_frmts.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "mapping/store/map_history.hpp"

/// Columns, rows and values of the map file's tables. What is read is checked: a map may be
/// damaged, or made by somebody else. Internal, because it uses GDAL.
namespace ceilmap::store::tables {

/// Columns of a symmetric 3 x 3 matrix over (x, y, yaw): its upper triangle, row by row.
using MatrixColumns = std::array<const char*, 6>;

/// A table, still without columns; null when GDAL fails. @param geometry  wkbNone: rows without
/// one. @param id_column  name of the column of the row's number.
OGRLayer* CreateTable(GDALDataset& dataset,
                      const char* name,
                      OGRSpatialReference* srs,
                      OGRwkbGeometryType geometry,
                      const char* id_column);
/// False when GDAL fails.
bool AddField(OGRLayer& layer, const char* name, OGRFieldType type);
bool AddMatrixFields(OGRLayer& layer, const MatrixColumns& names);

/// A row that is not yet part of the table, without values.
OGRFeatureUniquePtr NewRow(OGRLayer& layer);
/// Adds a row; false when GDAL fails.
bool AddRow(OGRLayer& layer, OGRFeature& row);
void SetMatrix(OGRFeature& row, const MatrixColumns& names, const Eigen::Matrix3d& matrix);
/// Bytes of a column of type OFTBinary.
void SetBytes(OGRFeature& row, const char* name, const void* bytes, std::size_t size);

/// @throws InputError (without the file's name): the table, the row, and what is wrong.
[[noreturn]] void ThrowDamaged(OGRFeature& row, const std::string& what);
/// Index of a column that has a value. These four throw as ThrowDamaged where there is none.
int Column(OGRFeature& row, const char* name);
/// A finite number.
double Real(OGRFeature& row, const char* name);
std::int64_t Integer(OGRFeature& row, const char* name);
std::string Text(OGRFeature& row, const char* name);
Eigen::Matrix3d Matrix(OGRFeature& row, const MatrixColumns& names);
/// @throws as ThrowDamaged for a position that no map has.
void CheckCoordinates(OGRFeature& row, double x, double y);

/// Sets the geometry of a row of a layer of multipolygons.
void SetPolygons(OGRFeature& row, const Polygons& polygons);
Polygons PolygonsOf(OGRFeature& row);

/// The bytes of a column of type OFTBinary, valid as long as the row; null where there are none.
struct Bytes {
  const unsigned char* data = nullptr;
  int size = 0;
};
Bytes BytesOf(OGRFeature& row, const char* name);

}  // namespace ceilmap::store::tables
