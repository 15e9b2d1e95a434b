#include "app/reports/history_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "calib/base/one_line.hpp"

namespace ceilmap::reports {
namespace {

nlohmann::ordered_json ToJson(const store::Session& session) {
  return {{"id", session.id},
          {"date", session.date},
          {"source", session.source},
          {"robot", session.robot},
          {"program_version", session.program_version},
          {"frames", session.frames},
          {"placed", session.placed},
          {"other_light", session.other_light},
          {"seen_area", session.seen_area},
          {"changed_area", session.changed_area}};
}

}  // namespace

cv::Point2d MiddleOf(const store::Change& change) {
  cv::Point2d low(1e300, 1e300);
  cv::Point2d high(-1e300, -1e300);
  for (const auto& rings : change.polygons) {
    for (const cv::Point2d& p : rings.front()) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  return change.polygons.empty() ? cv::Point2d() : (low + high) / 2;
}

nlohmann::ordered_json ToJson(const store::Change& change) {
  nlohmann::ordered_json polygons = nlohmann::ordered_json::array();
  for (const auto& rings : change.polygons) {
    nlohmann::ordered_json polygon = nlohmann::ordered_json::array();
    for (const auto& ring : rings) {
      nlohmann::ordered_json points = nlohmann::ordered_json::array();
      for (const cv::Point2d& p : ring) points.push_back(std::array{p.x, p.y});
      polygon.push_back(std::move(points));
    }
    polygons.push_back(std::move(polygon));
  }
  return {{"id", change.id},
          {"kind", store::ToString(change.kind)},
          {"state", store::ToString(change.state)},
          {"first_session", change.first_session},
          {"last_session", change.last_session},
          {"frames", change.frames},
          {"difference", change.difference},
          {"area", change.area},
          {"polygons", polygons}};
}

nlohmann::ordered_json ToJson(const store::MapHistory& history) {
  nlohmann::ordered_json json = {{"sessions", nlohmann::ordered_json::array()},
                                 {"changes", nlohmann::ordered_json::array()}};
  for (const store::Session& session : history.sessions) {
    json["sessions"].push_back(ToJson(session));
  }
  for (const store::Change& change : history.changes) json["changes"].push_back(ToJson(change));
  return json;
}

nlohmann::ordered_json ToJson(const robot::MapUpdateReport& report) {
  nlohmann::ordered_json json = {{"session", ToJson(report.session)},
                                 {"views_compared", report.views},
                                 {"confirmed", report.confirmed},
                                 {"candidates", report.candidates},
                                 {"keyframes_renewed", report.keyframes},
                                 {"compare_ms", report.compare_ms},
                                 {"refresh_ms", report.refresh_ms}};
  if (report.retirement) json["retired"] = report.retirement->retired;
  return json;
}

nlohmann::ordered_json ToJson(const change::PruneReport& report) {
  return {{"bytes_before", report.bytes_before},
          {"bytes_after", report.bytes_after},
          {"keyframes_retired", report.keyframes.retired},
          {"sessions_removed", report.sessions},
          {"changes_removed", report.changes},
          {"within_budget", report.keyframes.within_budget}};
}

terminal::Table FactsOf(const change::PruneReport& report) {
  terminal::Table table;
  table.AddRow({"keyframes", fmt::format("{} removed", report.keyframes.retired)});
  table.AddRow({"sessions", fmt::format("{} removed", report.sessions)});
  table.AddRow({"changes", fmt::format("{} removed", report.changes)});
  table.AddRow({"size",
                fmt::format("{:.1f} MB, before {:.1f} MB",
                            1e-6 * static_cast<double>(report.bytes_after),
                            1e-6 * static_cast<double>(report.bytes_before))});
  return table;
}

terminal::Table FactsOf(const robot::MapUpdateReport& report) {
  const store::Session& session = report.session;
  terminal::Table table;
  table.AddRow({"session", fmt::format("{}", session.id)});
  table.AddRow({"on the map", fmt::format("{} of {} frames", session.placed, session.frames)});
  table.AddRow({"compared", fmt::format("{} images, {:.1f} m^2", report.views, session.seen_area)});
  if (session.other_light) table.AddRow({"light", "most lamps are not as the map shows them"});
  table.AddRow(
      {"changed", fmt::format("{} places, {:.2f} m^2", report.confirmed, session.changed_area)});
  if (report.candidates > 0) {
    table.AddRow(
        {"uncertain", fmt::format("{} places; another session decides", report.candidates)});
  }
  table.AddRow({"images renewed", fmt::format("{}", report.keyframes)});
  if (report.retirement) {
    table.AddRow({"keyframes", fmt::format("{} removed", report.retirement->retired)});
  }
  return table;
}

ReportTable SessionsTable(const store::MapHistory& history) {
  ReportTable table;
  table.title = "sessions";
  table.columns = {"session", "date", "robot", "source", "placed", "seen m^2", "changed m^2", ""};
  for (const store::Session& session : history.sessions) {
    table.rows.push_back({fmt::format("{}", session.id),
                          InOneLine(session.date, 20),
                          InOneLine(session.robot, 24),
                          InOneLine(session.source, 24),
                          fmt::format("{} of {}", session.placed, session.frames),
                          fmt::format("{:.1f}", session.seen_area),
                          fmt::format("{:.2f}", session.changed_area),
                          session.other_light ? "other light" : ""});
  }
  return table;
}

ReportTable ChangesTable(const std::vector<store::Change>& changes) {
  ReportTable table;
  table.title = "changes";
  table.columns = {"change", "kind", "state", "first", "last", "x", "y", "m^2", "images"};
  for (const store::Change& change : changes) {
    const cv::Point2d middle = MiddleOf(change);
    table.rows.push_back({fmt::format("{}", change.id),
                          store::ToString(change.kind),
                          store::ToString(change.state),
                          fmt::format("{}", change.first_session),
                          fmt::format("{}", change.last_session),
                          fmt::format("{:.2f}", middle.x),
                          fmt::format("{:.2f}", middle.y),
                          fmt::format("{:.2f}", change.area),
                          fmt::format("{}", change.frames)});
  }
  return table;
}

}  // namespace ceilmap::reports
