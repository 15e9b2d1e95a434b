#include "mapping/store/map_metadata.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "calib/base/error.hpp"

namespace ceilmap::store {
namespace {

constexpr int kMaxViewSide = 1 << 15;
constexpr int kMaxViewPixels = 1 << 27;
constexpr int kMaxMosaicSide = 1 << 24;
constexpr std::int64_t kMaxMosaicPixels = std::int64_t{1} << 36U;  // 2.6 km square at 1 cm
constexpr double kMaxCoordinate = 1e9;
constexpr std::size_t kMaxTextBytes = 1 << 24;

std::string ToText(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

const std::string& Text(const std::map<std::string, std::string>& rows, const char* key) {
  const auto row = rows.find(key);
  if (row == rows.end()) {
    throw InputError(std::string("ceilmap_metadata has no '") + key + "'; the file is damaged");
  }
  if (row->second.size() > kMaxTextBytes) {
    throw InputError(std::string("ceilmap_metadata: '") + key +
                     "' is too long; the file is damaged");
  }
  return row->second;
}

template <typename Number>
Number Value(const std::map<std::string, std::string>& rows, const char* key) {
  const std::string& text = Text(rows, key);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError(std::string("ceilmap_metadata: '") + key +
                     "' is no number; the file is damaged");
  }
  return value;
}

double ValueOr(const std::map<std::string, std::string>& rows, const char* key, double otherwise) {
  return rows.count(key) > 0 ? Value<double>(rows, key) : otherwise;
}

/// Nothing for a map that is not aligned with its building.
std::optional<survey::SiteFrame> SiteFromRows(const std::map<std::string, std::string>& rows) {
  if (!rows.contains("site_scale")) return std::nullopt;
  survey::SiteFrame site;
  site.crs_wkt = Text(rows, "site_crs_wkt");
  site.S_site_map.scale = Value<double>(rows, "site_scale");
  site.S_site_map.motion = {Value<double>(rows, "site_x_m"),
                            Value<double>(rows, "site_y_m"),
                            Value<double>(rows, "site_yaw_rad")};
  site.centre_map = {Value<double>(rows, "site_centre_x"), Value<double>(rows, "site_centre_y")};
  site.sigma_position_m = Value<double>(rows, "site_sigma_position_m");
  site.sigma_yaw_rad = Value<double>(rows, "site_sigma_yaw_rad");
  site.sigma_scale = Value<double>(rows, "site_sigma_scale");
  return site;
}

/// Nothing for a map.
std::optional<MosaicPart> PartFromRows(const std::map<std::string, std::string>& rows) {
  if (!rows.contains("part")) return std::nullopt;
  MosaicPart part;
  part.part = Value<int>(rows, "part");
  part.parts = Value<int>(rows, "parts");
  part.graph = Value<std::uint64_t>(rows, "part_graph");
  part.whole.min_x = Value<double>(rows, "part_whole_min_x");
  part.whole.max_y = Value<double>(rows, "part_whole_max_y");
  part.whole.resolution = Value<double>(rows, "part_whole_resolution");
  part.whole.width_px = Value<int>(rows, "part_whole_width_px");
  part.whole.height_px = Value<int>(rows, "part_whole_height_px");
  return part;
}

bool IsPositive(double value) {
  return std::isfinite(value) && value > 0;
}
bool IsCoordinate(double value) {
  return std::abs(value) <= kMaxCoordinate;
}
bool IsSigma(double value) {
  return std::isfinite(value) && value >= 0;
}

std::string Problem(const survey::SiteFrame& site) {
  const Pose2& T = site.S_site_map.motion;
  if (!IsPositive(site.S_site_map.scale)) return "site_scale must be > 0";
  if (!IsCoordinate(T.x) || !IsCoordinate(T.y) || !IsCoordinate(T.yaw) ||
      !IsCoordinate(site.centre_map.x()) || !IsCoordinate(site.centre_map.y())) {
    return "the coordinates of the site must be finite";
  }
  if (!IsSigma(site.sigma_position_m) || !IsSigma(site.sigma_yaw_rad) ||
      !IsSigma(site.sigma_scale)) {
    return "the standard deviations of the site must be >= 0";
  }
  return {};
}

}  // namespace

std::map<std::string, std::string> ToRows(const survey::SiteFrame& site) {
  const Pose2& T = site.S_site_map.motion;
  return {{"site_crs_wkt", site.crs_wkt},
          {"site_scale", ToText(site.S_site_map.scale)},
          {"site_x_m", ToText(T.x)},
          {"site_y_m", ToText(T.y)},
          {"site_yaw_rad", ToText(T.yaw)},
          {"site_centre_x", ToText(site.centre_map.x())},
          {"site_centre_y", ToText(site.centre_map.y())},
          {"site_sigma_position_m", ToText(site.sigma_position_m)},
          {"site_sigma_yaw_rad", ToText(site.sigma_yaw_rad)},
          {"site_sigma_scale", ToText(site.sigma_scale)}};
}

std::map<std::string, std::string> ToRows(const MosaicPart& part) {
  return {{"part", std::to_string(part.part)},
          {"parts", std::to_string(part.parts)},
          {"part_graph", std::to_string(part.graph)},
          {"part_whole_min_x", ToText(part.whole.min_x)},
          {"part_whole_max_y", ToText(part.whole.max_y)},
          {"part_whole_resolution", ToText(part.whole.resolution)},
          {"part_whole_width_px", std::to_string(part.whole.width_px)},
          {"part_whole_height_px", std::to_string(part.whole.height_px)}};
}

std::map<std::string, std::string> ToRows(const MapMetadata& m) {
  std::map<std::string, std::string> rows = {
      {"format_version", std::to_string(m.format_version)},
      {"unit", m.unit},
      {"resolution", ToText(m.resolution)},
      {"ceiling_height_m", ToText(m.ceiling_height_m)},
      {"rig_yaml", m.rig_yaml},
      {"robot", m.robot},
      {"view_width_px", std::to_string(m.view_size.width)},
      {"view_height_px", std::to_string(m.view_size.height)},
      {"view_units_per_px", ToText(m.view_units_per_px)},
      {"T_base_view_x", ToText(m.T_base_view.x)},
      {"T_base_view_y", ToText(m.T_base_view.y)},
      {"T_base_view_yaw_rad", ToText(m.T_base_view.yaw)},
      {"view_focal_px", ToText(m.view_focal_px)},
      {"view_principal_x_px", ToText(m.view_principal_px.x())},
      {"view_principal_y_px", ToText(m.view_principal_px.y())},
      {"program_version", m.program_version},
      {kProvenanceKey, m.provenance}};
  if (m.site) rows.merge(ToRows(*m.site));
  if (m.part) rows.merge(ToRows(*m.part));
  return rows;
}

std::map<std::string, std::string> ToRows(const graph::MapQuality& q) {
  return {{"loops_compared", std::to_string(q.loops.compared)},
          {"loops_accepted", std::to_string(q.loops.accepted)},
          {"loops_no_match", std::to_string(q.loops.no_match)},
          {"loops_ambiguous", std::to_string(q.loops.ambiguous)},
          {"loops_off_prediction", std::to_string(q.loops.off_prediction)},
          {"loops_unconfirmed", std::to_string(q.loops.unconfirmed)},
          {"loops_outliers", std::to_string(q.loops.outliers)},
          {"chi2_per_dof", ToText(q.chi2_per_dof)},
          {"max_edge_sigmas", ToText(q.max_edge_sigmas)},
          {"odometry_rms", ToText(q.odometry_rms)},
          {"loop_rms", ToText(q.loop_rms)}};
}

graph::MapQuality QualityFromRows(const std::map<std::string, std::string>& rows) {
  graph::MapQuality q;
  q.loops.compared = Value<std::int64_t>(rows, "loops_compared");
  q.loops.accepted = Value<std::int64_t>(rows, "loops_accepted");
  q.loops.no_match = Value<std::int64_t>(rows, "loops_no_match");
  q.loops.ambiguous = Value<std::int64_t>(rows, "loops_ambiguous");
  q.loops.off_prediction = Value<std::int64_t>(rows, "loops_off_prediction");
  q.loops.unconfirmed = Value<std::int64_t>(rows, "loops_unconfirmed");
  q.loops.outliers = Value<std::int64_t>(rows, "loops_outliers");
  q.chi2_per_dof = Value<double>(rows, "chi2_per_dof");
  q.max_edge_sigmas = Value<double>(rows, "max_edge_sigmas");
  q.odometry_rms = Value<double>(rows, "odometry_rms");
  q.loop_rms = Value<double>(rows, "loop_rms");
  return q;
}

MapMetadata FromRows(const std::map<std::string, std::string>& rows) {
  MapMetadata m;
  m.format_version = Value<int>(rows, "format_version");
  if (m.format_version != kMapFormatVersion) {
    throw InputError("map format version " + std::to_string(m.format_version) +
                     ", this program reads version " + std::to_string(kMapFormatVersion) +
                     "; make the map again or use the program that wrote it");
  }
  m.unit = Text(rows, "unit");
  m.resolution = Value<double>(rows, "resolution");
  m.ceiling_height_m = Value<double>(rows, "ceiling_height_m");
  m.rig_yaml = Text(rows, "rig_yaml");
  m.robot = Text(rows, "robot");
  m.view_size.width = Value<int>(rows, "view_width_px");
  m.view_size.height = Value<int>(rows, "view_height_px");
  m.view_units_per_px = Value<double>(rows, "view_units_per_px");
  m.T_base_view.x = Value<double>(rows, "T_base_view_x");
  m.T_base_view.y = Value<double>(rows, "T_base_view_y");
  m.T_base_view.yaw = Value<double>(rows, "T_base_view_yaw_rad");
  // Absent in maps that were made before ceilings had heights.
  m.view_focal_px = ValueOr(rows, "view_focal_px", 0);
  m.view_principal_px = {ValueOr(rows, "view_principal_x_px", 0),
                         ValueOr(rows, "view_principal_y_px", 0)};
  m.program_version = Text(rows, "program_version");
  m.provenance = Text(rows, kProvenanceKey);
  m.site = SiteFromRows(rows);
  m.part = PartFromRows(rows);
  if (const std::string problem = Problem(m); !problem.empty()) {
    throw InputError("ceilmap_metadata: " + problem + "; the file is damaged");
  }
  return m;
}

std::string Problem(const MapMetadata& m) {
  if (m.unit != "m" && m.unit != "px") return "unit must be 'm' or 'px'";
  if (!IsPositive(m.resolution)) return "resolution must be > 0";
  if (!std::isfinite(m.ceiling_height_m) || m.ceiling_height_m < 0) {
    return "ceiling_height_m must be >= 0";
  }
  const cv::Size size = m.view_size;
  if (size.width <= 0 || size.height <= 0 || size.width > kMaxViewSide ||
      size.height > kMaxViewSide || std::int64_t{size.width} * size.height > kMaxViewPixels) {
    return "view size " + std::to_string(size.width) + " x " + std::to_string(size.height) +
           " is not that of an image";
  }
  if (!IsPositive(m.view_units_per_px)) return "view_units_per_px must be > 0";
  if (!m.view_mask.empty() && (m.view_mask.type() != CV_8UC1 || m.view_mask.size() != size)) {
    return "the view's mask must be of the view's size";
  }
  const Pose2& T = m.T_base_view;
  if (!IsCoordinate(T.x) || !IsCoordinate(T.y) || !IsCoordinate(T.yaw)) {
    return "T_base_view must be finite";
  }
  if (!std::isfinite(m.view_focal_px) || m.view_focal_px < 0) return "view_focal_px must be >= 0";
  if (!IsCoordinate(m.view_principal_px.x()) || !IsCoordinate(m.view_principal_px.y())) {
    return "view_principal_px must be finite";
  }
  if (m.part) {
    if (m.part->part < 1 || m.part->part > m.part->parts) return "part must be in 1..parts";
    if (std::string problem = Problem(m.part->whole); !problem.empty()) return problem;
  }
  return m.site ? Problem(*m.site) : "";
}

const char* ToString(LeftOut::Kind kind) {
  return kind == LeftOut::Kind::kMoves ? "moves" : "below_ceiling";
}

std::optional<double> HeightAboveFloor(const MapMetadata& metadata, double rho) {
  const double reference_m = metadata.view_focal_px * metadata.view_units_per_px;
  if (metadata.unit != "m" || reference_m <= 0 || metadata.ceiling_height_m <= 0 || rho <= 0) {
    return std::nullopt;
  }
  return metadata.ceiling_height_m + reference_m * (1 / rho - 1);
}

Eigen::Vector2d PixelToMap(const MosaicGrid& grid, const Eigen::Vector2d& col_row) {
  return {grid.min_x + (col_row.x() + 0.5) * grid.resolution,
          grid.max_y - (col_row.y() + 0.5) * grid.resolution};
}

std::string Problem(const MosaicGrid& grid) {
  if (grid.width_px < 0 || grid.height_px < 0 || grid.width_px > kMaxMosaicSide ||
      grid.height_px > kMaxMosaicSide) {
    return "a mosaic of " + std::to_string(grid.width_px) + " x " + std::to_string(grid.height_px) +
           " pixels cannot be stored (at most " + std::to_string(kMaxMosaicSide) + " on a side)";
  }
  if (std::int64_t{grid.width_px} * grid.height_px > kMaxMosaicPixels) {
    return "a mosaic of " + std::to_string(grid.width_px) + " x " + std::to_string(grid.height_px) +
           " pixels cannot be stored (at most " + std::to_string(kMaxMosaicPixels) + " in all)";
  }
  if (!IsPositive(grid.resolution) || !IsCoordinate(grid.min_x) || !IsCoordinate(grid.max_y)) {
    return "the mosaic's position or resolution is no usable number";
  }
  return {};
}

}  // namespace ceilmap::store
