#pragma once

#include <ogrsf_frmts.h>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

/// The tables of the map file whose rows are places: "features" of a GeoPackage. Shared by
/// MapWriter and MapReader. Internal, because it uses GDAL.
namespace ceilmap::store::tables {

/// Adds the layer with its columns; null when GDAL fails (the GdalScope has the reason).
OGRLayer* CreateKeyframes(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateTrajectory(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateEdges(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateWeakSpots(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateLeftOut(GDALDataset& dataset, OGRSpatialReference& srs);

/// Sets the values of a row, in a map or in a database with the same columns.
void Fill(OGRFeature& row, const graph::Keyframe& keyframe);
void Fill(OGRFeature& row, const graph::FramePose& frame);
void Fill(OGRFeature& row, const graph::Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);
void Fill(OGRFeature& row, const graph::WeakSpot& spot);
void Fill(OGRFeature& row, const LeftOut& places);

/// Adds a row; false when GDAL fails. An edge is a line between its two keyframes.
bool Append(OGRLayer& layer, const graph::Keyframe& keyframe);
bool Append(OGRLayer& layer, const graph::FramePose& frame);
bool Append(OGRLayer& layer,
            const graph::Edge& edge,
            const Pose2& T_map_from,
            const Pose2& T_map_to);
bool Append(OGRLayer& layer, const graph::WeakSpot& spot);
bool Append(OGRLayer& layer, const LeftOut& places);

/// The inverse. @throws InputError (without the file's name) for a missing column and for invalid
/// values.
graph::Keyframe ToKeyframe(OGRFeature& row);
graph::FramePose ToFramePose(OGRFeature& row);
graph::Edge ToEdge(OGRFeature& row);
graph::WeakSpot ToWeakSpot(OGRFeature& row);
LeftOut ToLeftOut(OGRFeature& row);

}  // namespace ceilmap::store::tables
