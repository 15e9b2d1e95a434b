#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/reports/comparison.hpp"
#include "app/reports/report_folder.hpp"

namespace ceilmap::reports {

/// The files of a comparison by `evaluate`.

/// metrics.json. @param align  Name of the alignment, as for the option.
nlohmann::ordered_json ComparisonJson(const Comparison& comparison,
                                      const ComparisonInputs& params,
                                      const std::string& align);

/// metrics.csv: a row per estimate and kind of error, with its statistics.
std::string FormatMetricsCsv(const Comparison& comparison);
/// estimates.csv: one row per estimate with its single values.
std::string FormatEstimatesCsv(const Comparison& comparison);
/// NAME-errors.csv: a line for each pose of the truth.
/// @param compensation  of this estimate, or null.
std::string FormatErrorsCsv(const std::vector<StampedPose>& truth,
                            const ComparedEstimate& estimate,
                            const evaluation::Compensation* compensation);

/// All files of the report folder.
std::vector<ReportFile> ReportFiles(const Comparison& comparison,
                                    const nlohmann::ordered_json& metrics);

}  // namespace ceilmap::reports
