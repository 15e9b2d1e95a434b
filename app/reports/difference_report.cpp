#include "app/reports/difference_report.hpp"

#include <fmt/format.h>

#include <iterator>

#include "app/page/mosaic_picture.hpp"
#include "app/reports/history_report.hpp"
#include "app/reports/page_parts.hpp"

namespace ceilmap::reports {
namespace {

std::string WktOf(const store::Polygons& polygons) {
  std::string wkt = "MULTIPOLYGON(";
  auto out = std::back_inserter(wkt);
  const char* next_polygon = "";
  for (const auto& rings : polygons) {
    fmt::format_to(out, "{}(", next_polygon);
    const char* next_ring = "";
    for (const auto& ring : rings) {
      fmt::format_to(out, "{}(", next_ring);
      for (const cv::Point2d& p : ring) fmt::format_to(out, "{:.4f} {:.4f},", p.x, p.y);
      fmt::format_to(out, "{:.4f} {:.4f})", ring.front().x, ring.front().y);  // rings are closed
      next_ring = ",";
    }
    wkt += ')';
    next_polygon = ",";
  }
  wkt += ')';
  return wkt;
}

}  // namespace

terminal::Table FactsOf(const ComparedMaps& compared) {
  const change::MapDifference& difference = compared.difference;
  const std::string unit = compared.before.map->Metadata().unit;
  terminal::Table table;
  table.AddRow({"placed by",
                compared.placed.same_frame
                    ? "the keyframes that both maps have"
                    : fmt::format("{} measurements between the maps", compared.placed.edges)});
  table.AddRow({"compared", fmt::format("{:.1f} {}^2", difference.compared_area, unit)});
  if (difference.other_light)
    table.AddRow({"light", "most lamps are not as the first map shows them"});
  table.AddRow(
      {"changed",
       fmt::format(
           "{} places, {:.2f} {}^2", difference.changes.size(), difference.changed_area, unit)});
  return table;
}

ReportTable DifferenceTable(const change::MapDifference& difference, const std::string& unit) {
  ReportTable table;
  table.title = "changes";
  table.columns = {"change", "kind", "x", "y", unit + "^2"};
  for (const store::Change& change : difference.changes) {
    const cv::Point2d middle = MiddleOf(change);
    table.rows.push_back({fmt::format("{}", change.id),
                          store::ToString(change.kind),
                          fmt::format("{:.2f}", middle.x),
                          fmt::format("{:.2f}", middle.y),
                          fmt::format("{:.2f}", change.area)});
  }
  return table;
}

nlohmann::ordered_json ToJson(const ComparedMaps& compared) {
  const change::MapDifference& difference = compared.difference;
  const Pose2& T = compared.placed.T_a_b;
  return {{"same_frame", compared.placed.same_frame},
          {"T_before_after", {{"x", T.x}, {"y", T.y}, {"yaw_rad", T.yaw}}},
          {"compared_area", difference.compared_area},
          {"changed_area", difference.changed_area},
          {"other_light", difference.other_light},
          {"changes", difference.changes.size()}};
}

std::string DifferenceCsv(const change::MapDifference& difference) {
  std::string csv = "id,kind,x,y,area,difference,wkt\n";
  for (const store::Change& change : difference.changes) {
    const cv::Point2d middle = MiddleOf(change);
    fmt::format_to(std::back_inserter(csv),
                   "{},{},{:.3f},{:.3f},{:.4f},{:.3f},\"{}\"\n",
                   change.id,
                   store::ToString(change.kind),
                   middle.x,
                   middle.y,
                   change.area,
                   change.difference,
                   WktOf(change.polygons));
  }
  return csv;
}

page::PageData DifferencePage(const ComparedMaps& compared) {
  page::PageData data;
  data.title = fmt::format("{} and {}", compared.before.name, compared.after.name);
  data.note =
      "Left of the divider the ceiling as the first map shows it, right of it as the second does.";
  data.unit = compared.before.map->Metadata().unit;
  data.S_page_map.motion = compared.placed.T_a_b;
  data.picture = page::MakeMosaicPicture(*compared.after.map);
  data.before = page::MakeMosaicPicture(*compared.before.map);
  for (const store::Change& change : compared.difference.changes) {
    page::PageArea area;
    area.text = fmt::format(
        "{}: {}, {:.2f} {}^2", change.id, store::ToString(change.kind), change.area, data.unit);
    for (const auto& rings : change.polygons) {
      for (const auto& ring : rings) {
        auto& points = area.rings.emplace_back();
        for (const cv::Point2d& p : ring) points.push_back({p.x, p.y});
      }
    }
    data.areas.push_back(std::move(area));
  }
  AddTables({DifferenceTable(compared.difference, data.unit)}, data);
  return data;
}

}  // namespace ceilmap::reports
