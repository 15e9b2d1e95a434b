#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/files/csv.hpp"
#include "localization/compass/compass.hpp"
#include "localization/heading_track.hpp"

namespace ceilmap::files {

/// Reads measured headings: a CSV file with the columns `timestamp` in seconds, increasing,
/// `heading_deg`, counter-clockwise seen from above, and `sigma_deg`, > 0; other columns are
/// ignored.
/// @return at least one. @throws InputError naming file and line.
std::vector<HeadingSample> ReadHeadings(const std::filesystem::path& file);

/// The same from a table.
std::vector<HeadingSample> HeadingsIn(const CsvTable& table);

/// A measured heading and its frame.
struct MeasuredHeading {
  std::int64_t frame = 0;  ///< in the recording, from 0
  double stamp_s = 0;
  compass::HeadingEstimate estimate;
};

/// The format of ReadHeadings: `timestamp,heading_deg,sigma_deg,confidence`, headings in (-180,
/// 180]; with errors also `true_heading_deg,error_deg`, empty without a true pose. sigma_deg is at
/// least 0.001, also for the first frame, whose heading is 0 by definition.
/// @param errors  Of these headings, or null.
std::string FormatHeadings(const std::vector<MeasuredHeading>& headings,
                           const evaluation::HeadingErrors* errors);

}  // namespace ceilmap::files
