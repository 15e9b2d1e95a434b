#pragma once

#include <ogrsf_frmts.h>

#include "mapping/survey/site_frame.hpp"

/// The table of the map file with the control points of its alignment. Shared by MapWriter,
/// MapReader and MapRevision. Internal, because it uses GDAL.
namespace ceilmap::store::tables {

/// Adds the layer with its columns; null when GDAL fails (the GdalScope has the reason).
OGRLayer* CreateControlPoints(GDALDataset& dataset, OGRSpatialReference& srs);

/// Sets the values of a row, in a map or in a database with the same columns; the geometry is
/// p_map.
void Fill(OGRFeature& row, const survey::AlignedPoint& point);

/// Adds a row; false when GDAL fails.
bool Append(OGRLayer& layer, const survey::AlignedPoint& point);

/// The inverse. @throws InputError (without the file's name) for a missing column and for invalid
/// values.
survey::AlignedPoint ToAlignedPoint(OGRFeature& row);

}  // namespace ceilmap::store::tables
