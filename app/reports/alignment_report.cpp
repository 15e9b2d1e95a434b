#include "app/reports/alignment_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/crs.hpp"

namespace ceilmap::reports {
namespace {

std::string Millimetres(double metres) {
  return fmt::format("{:.1f}", 1e3 * metres);
}

}  // namespace

ReportTable PointsTable(const survey::SiteFrame& site) {
  ReportTable table;
  table.title = "control points";
  table.columns = {
      "point", "map x", "map y", "site x", "site y", "dx mm", "dy mm", "left out mm", ""};
  for (const survey::AlignedPoint& point : site.points) {
    table.rows.push_back({InOneLine(point.point.name, 40),
                          fmt::format("{:.3f}", point.point.p_map.x()),
                          fmt::format("{:.3f}", point.point.p_map.y()),
                          fmt::format("{:.3f}", point.point.p_site.x()),
                          fmt::format("{:.3f}", point.point.p_site.y()),
                          Millimetres(point.residual_m.x()),
                          Millimetres(point.residual_m.y()),
                          point.leave_one_out_m ? Millimetres(*point.leave_one_out_m) : "-",
                          point.used ? "" : "not used"});
  }
  return table;
}

void AddSite(const survey::SiteFrame& site, terminal::Table& table) {
  const Pose2& T = site.S_site_map.motion;
  table.AddRow({"site", store::NameOfCrs(site.crs_wkt)});
  table.AddRow({"map origin in site",
                fmt::format("{:.4f}, {:.4f} m, {:.4f} deg", T.x, T.y, T.yaw * kDegPerRad)});
  if (site.S_site_map.scale != 1) {
    table.AddRow({"site scale", fmt::format("{:.6f} m per unit", site.S_site_map.scale)});
  }
  table.AddRow({"site accuracy",
                fmt::format("{:.1f} mm, {:.4f} deg at x {:.1f}, y {:.1f}",
                            1e3 * site.sigma_position_m,
                            site.sigma_yaw_rad * kDegPerRad,
                            site.centre_map.x(),
                            site.centre_map.y())});
}

nlohmann::ordered_json ToJson(const survey::SiteFrame& site) {
  const Pose2& T = site.S_site_map.motion;
  nlohmann::ordered_json json = {
      {"crs_wkt", site.crs_wkt},
      {"S_site_map",
       {{"scale", site.S_site_map.scale},
        {"x_m", T.x},
        {"y_m", T.y},
        {"yaw_deg", T.yaw * kDegPerRad}}},
      {"centre_map", {{"x", site.centre_map.x()}, {"y", site.centre_map.y()}}},
      {"sigma_position_m", site.sigma_position_m},
      {"sigma_yaw_deg", site.sigma_yaw_rad * kDegPerRad},
      {"sigma_scale", site.sigma_scale},
      {"points", nlohmann::ordered_json::array()}};
  for (const survey::AlignedPoint& point : site.points) {
    json["points"].push_back(
        {{"name", point.point.name},
         {"x", point.point.p_map.x()},
         {"y", point.point.p_map.y()},
         {"site_x", point.point.p_site.x()},
         {"site_y", point.point.p_site.y()},
         {"sigma_m", point.point.sigma_m},
         {"residual_x_m", point.residual_m.x()},
         {"residual_y_m", point.residual_m.y()},
         {"leave_one_out_m",
          point.leave_one_out_m ? nlohmann::ordered_json(*point.leave_one_out_m) : nullptr},
         {"used", point.used}});
  }
  return json;
}

std::vector<std::string> WarningsOf(const survey::Alignment& alignment, const std::string& unit) {
  constexpr double kNotableRatio = 3;
  constexpr double kNotableScale = 0.002;
  std::vector<std::string> warnings;
  for (const survey::AlignedPoint& point : alignment.site.points) {
    if (point.used) continue;
    warnings.push_back(fmt::format(
        "point '{}' contradicts the others by {:.3g} m and is not used; check its coordinates",
        InOneLine(point.point.name, 40),
        point.residual_m.norm()));
  }
  if (alignment.sigma_ratio > kNotableRatio) {
    warnings.push_back(fmt::format(
        "the residuals are {:.1f} times as large as the points' standard deviations: the map is "
        "bent, or points are inaccurate{}",
        alignment.sigma_ratio,
        alignment.used == 3 ? "; with three points it cannot be found which one" : ""));
  }
  const double scale = alignment.site.S_site_map.scale;
  if (unit == "m" &&
      std::abs(scale - 1) > std::max(kNotableScale, 3 * alignment.site.sigma_scale)) {
    warnings.push_back(
        fmt::format("the map is {:.2f} % too {}: check the ceiling height and the focal length of "
                    "its rig",
                    100 * std::abs(1 - scale),
                    scale > 1 ? "small" : "large"));
  }
  if (!alignment.checked) {
    warnings.push_back(
        fmt::format("{} points agree: a wrong one could not be found; four or more are better",
                    alignment.used));
  }
  return warnings;
}

}  // namespace ceilmap::reports
