#include "calib/camera_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "calib/base/yaml_text.hpp"

namespace ceilmap::calib {
namespace {

constexpr std::string_view kCameraInfoFile = "a ROS camera_info file";
constexpr int kMaxImagePx = 16384;
constexpr std::string_view kFocalFix = "take it from the camera's calibration, in pixels";

/// `{rows: R, cols: C, data: [...]}` in row order.
std::vector<double> ReadMatrix(const YamlValue& matrix, int rows, int cols) {
  matrix.AllowOnly({"rows", "cols", "data"});
  matrix.At("rows", "rows: " + std::to_string(rows)).WholeNumber(rows, rows);
  matrix.At("cols", "cols: " + std::to_string(cols)).WholeNumber(cols, cols);
  return matrix.At("data", "its numbers, row by row")
      .Numbers(static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols));
}

void ReadCameraMatrix(const YamlValue& info, Lens& camera) {
  const YamlValue matrix = info.At(
      "camera_matrix", "camera_matrix: {rows: 3, cols: 3, data: [fx, 0, cx, 0, fy, cy, 0, 0, 1]}");
  const std::vector<double> k = ReadMatrix(matrix, 3, 3);
  const YamlValue data = matrix.At("data", "");
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    data.Fail("[fx, 0, cx, 0, fy, cy, 0, 0, 1]", "calibrate the camera without skew");
  }
  if (!(k[0] > 0)) data.Fail("a matrix with fx > 0 (its first number)", kFocalFix);
  if (!(k[4] > 0)) data.Fail("a matrix with fy > 0 (its fifth number)", kFocalFix);
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2];
  camera.cy = k[5];
}

/// A lens model of ROS, or a camera without distortion: no key about it, or model "none" or "" with
/// zero coefficients or without coefficients.
void ReadDistortion(const YamlValue& info, Lens& camera) {
  if (!info.Find("distortion_model") && !info.Find("distortion_coefficients")) return;
  const YamlValue model = info.At("distortion_model", "distortion_model: plumb_bob");
  const std::string name = model.Text();
  const bool none = name.empty() || name == "none";
  const auto found = FindLensModel(name);
  if (!none && !found) {
    model.Fail("plumb_bob, rational_polynomial, equidistant or none",
               "calibrate the camera again with one of these models");
  }
  if (none && !info.Find("distortion_coefficients")) return;
  camera.model = found.value_or(LensModel::kPlumbBob);
  const std::vector<std::string> names = CoefficientNames(camera.model);
  const auto count = static_cast<int>(names.size());
  const YamlValue matrix =
      info.At("distortion_coefficients",
              fmt::format("distortion_coefficients: {{rows: 1, cols: {}, data: [{}]}}",
                          count,
                          fmt::join(names, ", ")));
  if (none) {
    matrix.AllowOnly({"rows", "cols", "data"});
    const YamlValue data = matrix.At("data", "data: [0, 0, 0, 0, 0]");
    const std::vector<double> zeros = data.Numbers(data.ListSize());
    if (std::all_of(zeros.begin(), zeros.end(), [](double k) { return k == 0; })) return;
    data.Fail("all zero for a camera without distortion", "or write distortion_model: plumb_bob");
  }
  const std::vector<double> d = ReadMatrix(matrix, 1, count);
  std::copy(d.begin(), d.end(), camera.distortion.begin());
}

std::string FormatMatrix(const char* key, int rows, const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n",
                     key,
                     rows,
                     data.size() / static_cast<std::size_t>(rows),
                     fmt::join(data, ", "));
}

}  // namespace

std::string FormatCameraInfo(const CameraInfo& info) {
  const Lens& lens = info.lens;
  const auto& [rx, ry, rcx, rcy] = info.rectified;
  std::string text;
  for (const std::string& remark : info.remarks) text += "# " + remark + "\n";
  text += fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n",
                      lens.width_px,
                      lens.height_px,
                      QuotedText(info.name));
  text += FormatMatrix("camera_matrix", 3, {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1});
  text += fmt::format("distortion_model: {}\n", RosName(lens.model));
  text += FormatMatrix("distortion_coefficients", 1, lens.Coefficients());
  text += FormatMatrix("rectification_matrix", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  text += FormatMatrix("projection_matrix", 3, {rx, 0, rcx, 0, 0, ry, rcy, 0, 0, 0, 1, 0});
  return text;
}

Lens ParseImageSize(const YamlValue& info) {
  Lens camera;
  camera.width_px =
      info.At("image_width", "the image's width in pixels").WholeNumber(1, kMaxImagePx);
  camera.height_px =
      info.At("image_height", "the image's height in pixels").WholeNumber(1, kMaxImagePx);
  if (const auto name = info.Find("camera_name")) name->Text();
  return camera;
}

Lens ParseCameraInfo(const YamlValue& info) {
  Lens camera = ParseImageSize(info);
  ReadCameraMatrix(info, camera);
  ReadDistortion(info, camera);
  if (const auto r = info.Find("rectification_matrix")) ReadMatrix(*r, 3, 3);
  if (const auto p = info.Find("projection_matrix")) ReadMatrix(*p, 3, 4);
  return camera;
}

Lens ParseCameraInfo(const std::string& text, const std::filesystem::path& file) {
  const YamlValue info = YamlValue::Parse(text, file, kCameraInfoFile);
  info.AllowOnly({"image_width",
                  "image_height",
                  "camera_name",
                  "camera_matrix",
                  "distortion_model",
                  "distortion_coefficients",
                  "rectification_matrix",
                  "projection_matrix"});
  return ParseCameraInfo(info);
}

Lens ReadCameraInfo(const std::filesystem::path& file) {
  return ParseCameraInfo(ReadSettingsText(file, kCameraInfoFile), file);
}

}  // namespace ceilmap::calib
