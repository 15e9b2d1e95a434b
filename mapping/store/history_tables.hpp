#pragma once

#include <ogrsf_frmts.h>

#include "mapping/store/map_history.hpp"

/// The tables of the map file with its history. Shared by MapRevision and MapReader. Internal,
/// because it uses GDAL.
namespace ceilmap::store::tables {

/// Adds the tables of the history with their rows; false when GDAL fails (the GdalScope has the
/// reason).
bool AddHistory(GDALDataset& dataset, OGRSpatialReference& srs, const MapHistory& history);

/// The inverse. @throws InputError (without the file's name) for a missing column and for invalid
/// values.
Session ToSession(OGRFeature& row);
Change ToChange(OGRFeature& row);
/// @param mosaic  size in pixels: a look outside of it is invalid.
Look ToLook(OGRFeature& row, const cv::Size& mosaic);

}  // namespace ceilmap::store::tables
