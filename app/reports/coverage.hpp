#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/recordings/frame_source.hpp"
#include "app/reports/sensor_report.hpp"
#include "localization/localizer.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::reports {

/// How many frames of a run got a place on the map, and the evidence for the cause when few did.
struct Coverage {
  std::int64_t frames = 0;  ///< processed; without those that a live source dropped
  std::int64_t on_map = 0;
  /// Of the other frames, each counted once:
  std::int64_t without_texture = 0;
  std::int64_t ambiguous = 0;
  std::int64_t lost = 0;
  std::int64_t unconnected = 0;

  double coding_loss = 0;  ///< fraction of the sensor's noise that the codec removed, 0..1
  bool localizes = false;  ///< on an existing map; otherwise the run makes the map
  bool has_stamps = true;  ///< by --stamps, or by the clock of a live source
  bool has_heading = false;
  bool has_start = false;  ///< --start of a localization

  /// 0..1; 0 without frames.
  [[nodiscard]] double Ratio() const;
};

/// Whether the stamps are the true times of the frames: by --stamps, or by a live source.
bool HasOwnStamps(recordings::StampOrigin stamps);

Coverage CoverageOf(const mapping::MapperReport& report,
                    recordings::StampOrigin stamps,
                    const SensorResult& sensors);
Coverage CoverageOf(const localization::LocalizerReport& report,
                    recordings::StampOrigin stamps,
                    const SensorResult& sensors);

/// `4 of 145 frames (3 %)`: 0 % and 100 % mean none and all.
std::string ToString(const Coverage& coverage);

/// Adds on_map and on_map_ratio.
void Summarize(const Coverage& coverage, nlohmann::ordered_json& quality);

/// The likely cause that frames are not on the map, and what to do, by the largest group of them.
std::string LikelyCause(const Coverage& coverage);

/// The warning for a run with less than half of its frames on the map; nothing for other runs, and
/// for those of CoverageFailure.
std::optional<std::string> CoverageWarning(const Coverage& coverage);
/// The error of a run with less than a tenth of its frames on the map; empty for other runs.
/// @param source  Name of the recording.
std::string CoverageFailure(const Coverage& coverage, const std::string& source);

}  // namespace ceilmap::reports
