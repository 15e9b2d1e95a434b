#pragma once

#include <ogrsf_frmts.h>

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mapping/heights/height_field.hpp"

/// The tables of the map file whose rows have no place: "attributes" of a GeoPackage. Images,
/// descriptors and heights of keyframes, by the keyframe's id, and texts by a key. Shared by
/// MapWriter and MapReader. Internal, because it uses GDAL.
namespace ceilmap::store::tables {

/// Adds the table with its columns; null when GDAL fails (the GdalScope has the reason).
/// @param name  kImages or kMask.
OGRLayer* CreateImages(GDALDataset& dataset, const char* name);
OGRLayer* CreateDescriptors(GDALDataset& dataset);
OGRLayer* CreateHeights(GDALDataset& dataset);
OGRLayer* CreateMetadata(GDALDataset& dataset);

/// Adds a row; false when GDAL fails.
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const std::vector<unsigned char>& png);
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const cv::Mat& descriptors);
bool Append(OGRLayer& layer, std::int64_t keyframe_id, const heights::HeightField& heights);
bool Append(OGRLayer& layer, const std::string& key, const std::string& value);

/// A keyframe's id and its heights. @throws InputError (without the file's name) for a missing
/// column and for invalid values.
std::pair<std::int64_t, std::shared_ptr<const heights::HeightField>> ToHeights(OGRFeature& row);
/// The stored bytes of a keyframe's image. @throws InputError when there are none.
std::vector<unsigned char> ReadPng(OGRLayer& images, std::int64_t keyframe_id);
/// CV_32FC1. @throws InputError when there are none or their size is invalid.
cv::Mat ReadDescriptors(OGRLayer& descriptors, std::int64_t keyframe_id);

}  // namespace ceilmap::store::tables
