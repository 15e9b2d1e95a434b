#pragma once

#include <ogrsf_frmts.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

/// The tables of the map file and the conversion of their rows. Shared by MapWriter and MapReader
/// so that each column is named once. Internal, because it uses GDAL.
namespace ceilmap::store::tables {

inline constexpr char kMosaic[] = "mosaic";
inline constexpr char kKeyframes[] = "keyframes";
inline constexpr char kTrajectory[] = "trajectory";
inline constexpr char kEdges[] = "edges";
inline constexpr char kWeakSpots[] = "weak_spots";
inline constexpr char kLeftOut[] = "left_out";  ///< absent in maps of earlier versions
inline constexpr char kImages[] = "keyframe_pictures";
inline constexpr char kDescriptors[] = "place_descriptors";
inline constexpr char kHeights[] = "keyframe_heights";  ///< absent in maps of earlier versions
inline constexpr char kMask[] = "view_mask";            ///< one row, as kImages; none: no mask
inline constexpr char kMetadata[] = "ceilmap_metadata";
inline constexpr char kPng[] = "png";  ///< column of kImages
inline constexpr char kKey[] = "key";  ///< columns of kMetadata
inline constexpr char kValue[] = "value";
inline constexpr int kTilePx = 256;

/// Adds the layer with its columns; null when GDAL fails (the GdalScope has the reason).
OGRLayer* CreateKeyframes(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateTrajectory(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateEdges(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateWeakSpots(GDALDataset& dataset, OGRSpatialReference& srs);
OGRLayer* CreateLeftOut(GDALDataset& dataset, OGRSpatialReference& srs);
/// @param name  kImages or kMask.
OGRLayer* CreateImages(GDALDataset& dataset, const char* name);
OGRLayer* CreateDescriptors(GDALDataset& dataset);
OGRLayer* CreateHeights(GDALDataset& dataset);
OGRLayer* CreateMetadata(GDALDataset& dataset);

/// Adds a row; false when GDAL fails. An edge is a line between its two keyframes.
bool Append(OGRLayer& layer, const graph::Keyframe& keyframe);
bool Append(OGRLayer& layer, const graph::FramePose& frame);
bool Append(OGRLayer& layer,
            const graph::Edge& edge,
            const Pose2& T_map_from,
            const Pose2& T_map_to);
bool Append(OGRLayer& layer, const graph::WeakSpot& spot);
bool Append(OGRLayer& layer, const LeftOut& places);
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const std::vector<unsigned char>& png);
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const cv::Mat& descriptors);
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const heights::HeightField& heights);
bool Append(OGRLayer& layer, const std::string& key, const std::string& value);

/// The inverse. @throws InputError (without the file's name) for a missing column and for invalid
/// values.
graph::Keyframe ToKeyframe(OGRFeature& row);
graph::FramePose ToFramePose(OGRFeature& row);
graph::Edge ToEdge(OGRFeature& row);
graph::WeakSpot ToWeakSpot(OGRFeature& row);
LeftOut ToLeftOut(OGRFeature& row);
/// A keyframe's id and its heights.
std::pair<std::int64_t, std::shared_ptr<const heights::HeightField>> ToHeights(OGRFeature& row);
/// The stored bytes of a keyframe's image. @throws InputError when there are none.
std::vector<unsigned char> ReadPng(OGRLayer& images, std::int64_t keyframe_id);
/// CV_32FC1. @throws InputError when there are none or their size is invalid.
cv::Mat ReadDescriptors(OGRLayer& descriptors, std::int64_t keyframe_id);

}  // namespace ceilmap::store::tables
