#include "mapping/store/attribute_tables.hpp"

#include <algorithm>
#include <cstring>

#include "calib/base/error.hpp"
#include "mapping/store/map_tables.hpp"
#include "mapping/store/table_rows.hpp"

namespace ceilmap::store::tables {
namespace {

constexpr char kFloats[] = "float32";  // of descriptors and heights

// Cells are stored as they are in memory: rho, sigma, row by row.
static_assert(sizeof(heights::HeightCell) == 2 * sizeof(float));
constexpr int kMaxHeightCells = 1 << 14;  // columns, rows
constexpr double kMaxPixel = 1 << 15;     // coordinates in an image
constexpr double kMaxRatio = 1e3;         // of heights, and of their inverse

}  // namespace

OGRLayer* CreateImages(GDALDataset& dataset, const char* name) {
  OGRLayer* layer = CreateTable(dataset, name, nullptr, wkbNone, "id");
  return layer != nullptr && AddField(*layer, kPng, OFTBinary) ? layer : nullptr;
}

OGRLayer* CreateDescriptors(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kDescriptors, nullptr, wkbNone, "id");
  const bool done = layer != nullptr && AddField(*layer, "columns", OFTInteger) &&
                    AddField(*layer, kFloats, OFTBinary);
  return done ? layer : nullptr;
}

OGRLayer* CreateHeights(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kHeights, nullptr, wkbNone, "id");
  const bool done = layer != nullptr && AddField(*layer, "columns", OFTInteger) &&
                    AddField(*layer, "rows", OFTInteger) && AddField(*layer, "first_u", OFTReal) &&
                    AddField(*layer, "first_v", OFTReal) && AddField(*layer, "step_u", OFTReal) &&
                    AddField(*layer, "step_v", OFTReal) &&
                    AddField(*layer, "scale_sigma", OFTReal) &&
                    AddField(*layer, kFloats, OFTBinary);
  return done ? layer : nullptr;
}

OGRLayer* CreateMetadata(GDALDataset& dataset) {
  OGRLayer* layer = CreateTable(dataset, kMetadata, nullptr, wkbNone, "fid");
  const bool done =
      layer != nullptr && AddField(*layer, kKey, OFTString) && AddField(*layer, kValue, OFTString);
  return done ? layer : nullptr;
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const std::vector<unsigned char>& png) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  SetBytes(*row, kPng, png.data(), png.size());
  return AddRow(layer, *row);
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const cv::Mat& descriptors) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  row->SetField("columns", descriptors.cols);
  const cv::Mat whole = descriptors.isContinuous() ? descriptors : descriptors.clone();
  SetBytes(*row, kFloats, whole.ptr(), whole.total() * sizeof(float));
  return AddRow(layer, *row);
}

bool Append(OGRLayer& layer, std::int64_t keyframe_id, const heights::HeightField& heights) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetFID(keyframe_id);
  row->SetField("columns", heights.grid.width);
  row->SetField("rows", heights.grid.height);
  row->SetField("first_u", heights.first_px.x());
  row->SetField("first_v", heights.first_px.y());
  row->SetField("step_u", heights.step_px.x());
  row->SetField("step_v", heights.step_px.y());
  row->SetField("scale_sigma", heights.scale_sigma);
  SetBytes(*row, kFloats, heights.cells.data(), heights.cells.size() * sizeof(heights::HeightCell));
  return AddRow(layer, *row);
}

bool Append(OGRLayer& layer, const std::string& key, const std::string& value) {
  const OGRFeatureUniquePtr row = NewRow(layer);
  row->SetField(kKey, key.c_str());
  row->SetField(kValue, value.c_str());
  return AddRow(layer, *row);
}

std::pair<std::int64_t, std::shared_ptr<const heights::HeightField>> ToHeights(OGRFeature& row) {
  const std::int64_t columns = Integer(row, "columns");
  const std::int64_t rows = Integer(row, "rows");
  const Bytes bytes = BytesOf(row, kFloats);
  if (columns < 1 || columns > kMaxHeightCells || rows < 1 || rows > kMaxHeightCells ||
      bytes.size != columns * rows * static_cast<std::int64_t>(sizeof(heights::HeightCell))) {
    ThrowDamaged(row, "heights of an impossible size");
  }
  auto field_of_heights = std::make_shared<heights::HeightField>();
  heights::HeightField& result = *field_of_heights;
  result.grid = {static_cast<int>(columns), static_cast<int>(rows)};
  result.first_px = {Real(row, "first_u"), Real(row, "first_v")};
  result.step_px = {Real(row, "step_u"), Real(row, "step_v")};
  result.scale_sigma = Real(row, "scale_sigma");
  if (result.first_px.cwiseAbs().maxCoeff() > kMaxPixel || result.step_px.minCoeff() <= 0 ||
      result.step_px.maxCoeff() > kMaxPixel || result.scale_sigma < 0) {
    ThrowDamaged(row, "heights on an impossible grid");
  }
  result.cells.resize(static_cast<std::size_t>(columns * rows));
  std::memcpy(result.cells.data(), bytes.data, static_cast<std::size_t>(bytes.size));
  for (const heights::HeightCell& cell : result.cells) {
    if (!(cell.rho >= 1 / kMaxRatio && cell.rho <= kMaxRatio && cell.sigma >= 0 &&
          cell.sigma <= kMaxRatio)) {
      ThrowDamaged(row, "heights out of range");
    }
  }
  return {row.GetFID(), std::move(field_of_heights)};
}

std::vector<unsigned char> ReadPng(OGRLayer& images, std::int64_t keyframe_id) {
  const OGRFeatureUniquePtr row(images.GetFeature(keyframe_id));
  const Bytes bytes = row ? BytesOf(*row, kPng) : Bytes();
  if (bytes.data == nullptr || bytes.size <= 0) {
    throw InputError("the map holds no image of keyframe " + std::to_string(keyframe_id));
  }
  return {bytes.data, bytes.data + bytes.size};
}

cv::Mat ReadDescriptors(OGRLayer& descriptors, std::int64_t keyframe_id) {
  constexpr int kMaxColumns = 1 << 16;
  const OGRFeatureUniquePtr row(descriptors.GetFeature(keyframe_id));
  if (!row) {
    throw InputError("the map holds no place descriptors of keyframe " +
                     std::to_string(keyframe_id));
  }
  const std::int64_t columns = Integer(*row, "columns");
  const Bytes bytes = BytesOf(*row, kFloats);
  if (columns < 1 || columns > kMaxColumns || bytes.size % (columns * sizeof(float)) != 0) {
    ThrowDamaged(*row, "place descriptors of an impossible size");
  }
  const int cols = static_cast<int>(columns);
  cv::Mat result(bytes.size / (cols * static_cast<int>(sizeof(float))), cols, CV_32FC1);
  if (bytes.size > 0) std::copy_n(bytes.data, bytes.size, result.ptr());
  if (!cv::checkRange(result)) ThrowDamaged(*row, "place descriptors that are not finite");
  return result;
}

}  // namespace ceilmap::store::tables
