#include "app/reports/map_quality.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ceilmap::reports {

nlohmann::ordered_json ToJson(const graph::LoopCounts& loops) {
  return {{"compared", loops.compared},
          {"accepted", loops.accepted - loops.outliers},
          {"no_match", loops.no_match},
          {"ambiguous", loops.ambiguous},
          {"off_prediction", loops.off_prediction},
          {"unconfirmed", loops.unconfirmed},
          {"outliers", loops.outliers}};
}

nlohmann::ordered_json ToJson(const graph::MapQuality& quality) {
  return {{"loops", ToJson(quality.loops)},
          {"chi2_per_dof", quality.chi2_per_dof},
          {"max_edge_sigmas", quality.max_edge_sigmas},
          {"odometry_rms", quality.odometry_rms},
          {"loop_rms", quality.loop_rms}};
}

nlohmann::ordered_json ToJson(const std::vector<graph::WeakSpot>& spots) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const graph::WeakSpot& spot : spots) {
    list.push_back({{"kind", graph::ToString(spot.kind)},
                    {"keyframe_id", spot.keyframe_id},
                    {"x", spot.x},
                    {"y", spot.y},
                    {"extent", spot.extent}});
  }
  return list;
}

nlohmann::ordered_json ToJson(const std::vector<store::LeftOut>& places) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const store::LeftOut& place : places) {
    json.push_back({{"kind", store::ToString(place.kind)}, {"area", place.area}});
  }
  return json;
}

std::string Describe(const std::vector<store::LeftOut>& places, const std::string& unit) {
  std::string text;
  for (const store::LeftOut& place : places) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{:.1f} {}^2 ", place.area, unit);
    text += place.kind == store::LeftOut::Kind::kMoves
                ? "below which something moves"
                : "where walls or furniture hide the ceiling";
  }
  return text.empty() ? "nothing" : text;
}

std::string Describe(const graph::WeakSpot& spot, const std::string& unit) {
  std::string place = fmt::format("at ({:.1f}, {:.1f})", spot.x, spot.y);
  switch (spot.kind) {
    case graph::WeakSpot::Kind::kAmbiguous:
      return fmt::format(
          "ambiguous {} and {:.1f} {} around: the ceiling is periodic", place, spot.extent, unit);
    case graph::WeakSpot::Kind::kLost:
      return fmt::format("lost {}: {:.0f} frame{} could not be placed",
                         place,
                         spot.extent,
                         spot.extent == 1 ? "" : "s");
    case graph::WeakSpot::Kind::kUnclosed:
      return fmt::format(
          "unclosed {}: {:.1f} {} of path without a loop closure", place, spot.extent, unit);
  }
  return place;
}

void AddQuality(const graph::MapQuality& quality,
                std::vector<graph::WeakSpot> spots,
                const std::string& unit,
                int max_spots,
                terminal::Table& table) {
  const graph::LoopCounts& loops = quality.loops;
  table.AddRow({"loops closed",
                fmt::format("{} of {} compared", loops.accepted - loops.outliers, loops.compared)});
  table.AddRow({"not closed",
                fmt::format("{} no match, {} ambiguous, {} off the prediction, {} unconfirmed, {} "
                            "contradicted by the rest",
                            loops.no_match,
                            loops.ambiguous,
                            loops.off_prediction,
                            loops.unconfirmed,
                            loops.outliers)});
  table.AddRow({"residuals",
                fmt::format("odometry {:.2g} {}, loops {:.2g} {} RMS an axis; chi2/dof {:.2f}, "
                            "largest {:.1f} sigmas",
                            quality.odometry_rms,
                            unit,
                            quality.loop_rms,
                            unit,
                            quality.chi2_per_dof,
                            quality.max_edge_sigmas)});
  if (spots.empty()) {
    table.AddRow({"weak spots", "none"});
    return;
  }
  std::stable_sort(spots.begin(), spots.end(), [](const auto& a, const auto& b) {
    return std::pair(a.kind, -a.extent) < std::pair(b.kind, -b.extent);
  });
  table.AddRow({"weak spots", fmt::format("{}", spots.size())});
  const auto shown = std::min(spots.size(), static_cast<std::size_t>(max_spots));
  for (std::size_t i = 0; i < shown; ++i) table.AddRow({"", Describe(spots[i], unit)});
  if (shown < spots.size()) {
    table.AddRow({"", fmt::format("and {} more; --json lists them all", spots.size() - shown)});
  }
}

}  // namespace ceilmap::reports
