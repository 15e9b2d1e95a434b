#include "app/reports/coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/reports/recording_checks.hpp"

namespace ceilmap::reports {
namespace {

bool IsFailure(const Coverage& coverage) {
  return 10 * coverage.on_map < coverage.frames;
}

// After "N of them "; the number of the group precedes it.
std::string AmbiguousCause(const Coverage& coverage) {
  std::string text = "fit several places, because the ceiling is periodic; ";
  if (!coverage.has_heading) text += "give --omni or --heading, or ";
  if (!coverage.localizes) {
    return text + "drive where the ceiling is unique: past lamps, beams, signs or marks";
  }
  if (!coverage.has_start) text += "give --start, or ";
  return text + "drive farther, to where the ceiling is unique";
}

std::string LostCause(const Coverage& coverage) {
  if (coverage.localizes) {
    return "match no place of the map; is it the map of this place, and the rig of this robot? "
           "Outside the mapped area, extend the map by 'ceilmap map --append'";
  }
  std::string text = "could not be connected to the frames before them; ";
  if (!coverage.has_stamps) text += "if frames are missing, give --stamps; ";
  return text +
         "record more frames a second or drive more slowly, compress less, and check that the rig "
         "is that of this camera";
}

}  // namespace

bool HasOwnStamps(recordings::StampOrigin stamps) {
  return stamps == recordings::StampOrigin::kStampsFile ||
         stamps == recordings::StampOrigin::kClock || stamps == recordings::StampOrigin::kStream;
}

double Coverage::Ratio() const {
  return frames > 0 ? static_cast<double>(on_map) / static_cast<double>(frames) : 0;
}

Coverage CoverageOf(const mapping::MapperReport& report,
                    recordings::StampOrigin stamps,
                    const SensorResult& sensors) {
  Coverage coverage;
  coverage.frames = report.frames;
  coverage.on_map = report.tracked - report.unconnected;
  coverage.without_texture = report.without_texture;
  coverage.ambiguous = report.ambiguous;
  coverage.lost = report.lost - report.without_texture;
  coverage.unconnected = report.unconnected;
  coverage.coding_loss = report.coding_loss;
  coverage.has_stamps = HasOwnStamps(stamps);
  coverage.has_heading = sensors.report.heading.has_value();
  return coverage;
}

Coverage CoverageOf(const localization::LocalizerReport& report,
                    recordings::StampOrigin stamps,
                    const SensorResult& sensors) {
  Coverage coverage;
  coverage.frames = report.frames;
  coverage.on_map = report.tracking + report.relocalized;
  coverage.ambiguous = report.ambiguous;
  coverage.lost = report.lost;
  coverage.coding_loss = report.coding_loss;
  coverage.localizes = true;
  coverage.has_stamps = HasOwnStamps(stamps);
  coverage.has_heading = sensors.report.heading.has_value();
  return coverage;
}

std::string ToString(const Coverage& coverage) {
  const bool some = coverage.on_map > 0;
  const bool all = coverage.on_map == coverage.frames;
  const double percent =
      std::clamp(std::round(100 * coverage.Ratio()), some ? 1.0 : 0.0, some && all ? 100.0 : 99.0);
  return fmt::format("{} of {} frame{} ({:.0f} %)",
                     coverage.on_map,
                     coverage.frames,
                     coverage.frames == 1 ? "" : "s",
                     percent);
}

void Summarize(const Coverage& coverage, nlohmann::ordered_json& quality) {
  quality["on_map"] = coverage.on_map;
  quality["on_map_ratio"] = coverage.Ratio();
}

std::string LikelyCause(const Coverage& coverage) {
  const std::int64_t most =
      std::max({coverage.without_texture, coverage.ambiguous, coverage.lost, coverage.unconnected});
  const auto of_group = [&](const std::string& cause) { return fmt::format("{} {}", most, cause); };
  if (coverage.without_texture == most) {
    return of_group(
        "show no texture: dark, uniform, covered or out of focus; light the room, focus on the "
        "ceiling, and look at the images");
  }
  if (coverage.coding_loss > kMaxCodingLoss && coverage.ambiguous < most) {
    return of_group(
        "could not be connected, because compression removed the texture of the ceiling; record "
        "with a higher bitrate (x264: CRF 25 or less)");
  }
  if (coverage.unconnected == most) {
    return of_group(
        "are in parts that are not connected to the map; drive back over the start, or where the "
        "ceilings overlap, or map each part separately");
  }
  return of_group(coverage.ambiguous == most ? AmbiguousCause(coverage) : LostCause(coverage));
}

std::optional<std::string> CoverageWarning(const Coverage& coverage) {
  if (2 * coverage.on_map >= coverage.frames || IsFailure(coverage)) return std::nullopt;
  return fmt::format("only {} are on the map: {}", ToString(coverage), LikelyCause(coverage));
}

std::string CoverageFailure(const Coverage& coverage, const std::string& source) {
  if (!IsFailure(coverage)) return "";
  const std::string figure = coverage.on_map == 0
                                 ? fmt::format("none of its {} frames is", coverage.frames)
                                 : fmt::format("only {} are", ToString(coverage));
  return fmt::format("{}: {} on the map: {}", source, figure, LikelyCause(coverage));
}

}  // namespace ceilmap::reports
