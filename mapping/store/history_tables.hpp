#pragma once

#include <ogrsf_frmts.h>

#include "mapping/store/map_history.hpp"

/// The tables of the map file with its history. Shared by MapRevision and MapReader. Internal,
/// because it uses GDAL.
namespace ceilmap::store::tables {

/// Adds the table with its columns; null when GDAL fails (the GdalScope has the reason).
OGRLayer* CreateSessions(GDALDataset& dataset);
OGRLayer* CreateChanges(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateLooks(GDALDataset& dataset);

/// Adds a row; false when GDAL fails.
bool Append(OGRLayer& layer, const Session& session);
bool Append(OGRLayer& layer, const Change& change);
bool Append(OGRLayer& layer, const Look& look);

/// The inverse. @throws InputError (without the file's name) for a missing column and for invalid
/// values.
Session ToSession(OGRFeature& row);
Change ToChange(OGRFeature& row);
Look ToLook(OGRFeature& row);

}  // namespace ceilmap::store::tables
