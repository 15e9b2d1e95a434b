#pragma once

#include <array>

/// Names of the tables of the map file, shared by MapWriter and MapReader. feature_tables.hpp and
/// attribute_tables.hpp convert their rows. Internal.
namespace ceilmap::store::tables {

inline constexpr char kMosaic[] = "mosaic";
inline constexpr char kKeyframes[] = "keyframes";
inline constexpr char kTrajectory[] = "trajectory";
inline constexpr char kEdges[] = "edges";
inline constexpr char kWeakSpots[] = "weak_spots";
inline constexpr char kLeftOut[] = "left_out";              ///< absent in maps of earlier versions
inline constexpr char kControlPoints[] = "control_points";  ///< only in maps that are aligned
inline constexpr char kSessions[] = "sessions";             ///< only in maps that were updated
inline constexpr char kChanges[] = "changes";               ///< the same
inline constexpr char kLooks[] = "looks";                   ///< only where another light was seen
inline constexpr char kImages[] = "keyframe_pictures";
inline constexpr char kDescriptors[] = "place_descriptors";
inline constexpr char kHeights[] = "keyframe_heights";  ///< absent in maps of earlier versions
inline constexpr char kMask[] = "view_mask";            ///< one row, as kImages; none: no mask
inline constexpr char kMetadata[] = "ceilmap_metadata";
/// Tables whose rows belong to keyframes, by their ids.
inline constexpr std::array kOfKeyframes = {kImages, kDescriptors, kHeights};
inline constexpr char kPng[] = "png";  ///< column of kImages
inline constexpr char kKey[] = "key";  ///< columns of kMetadata
inline constexpr char kValue[] = "value";
inline constexpr int kTilePx = 256;

}  // namespace ceilmap::store::tables
