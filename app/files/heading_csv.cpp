#include "app/files/heading_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

// In (-180, 180] also after rounding.
std::string FormatAngle(double angle_deg) {
  const std::string text = fmt::format("{:.5f}", angle_deg);
  if (text == "-180.00000") return "180.00000";
  return text == "-0.00000" ? "0.00000" : text;
}

}  // namespace

std::vector<HeadingSample> ReadHeadings(const std::filesystem::path& file) {
  return HeadingsIn(ReadCsv(file));
}

std::vector<HeadingSample> HeadingsIn(const CsvTable& table) {
  const std::size_t stamp_column = table.Column("timestamp");
  const std::size_t heading_column = table.Column("heading_deg");
  const std::size_t sigma_column = table.Column("sigma_deg");
  std::vector<HeadingSample> samples;
  samples.reserve(table.rows.size());
  for (const CsvTable::Row& row : table.rows) {
    const HeadingSample sample{table.Number(row, stamp_column),
                               kRadPerDeg * table.Number(row, heading_column),
                               kRadPerDeg * table.Number(row, sigma_column)};
    if (!(sample.sigma_rad > 0)) {
      throw InputError(fmt::format("{}: sigma_deg must be > 0", table.Place(row)));
    }
    if (!samples.empty() && sample.stamp_s <= samples.back().stamp_s) {
      throw InputError(fmt::format("{}: timestamp {} is not later than {} before it",
                                   table.Place(row),
                                   sample.stamp_s,
                                   samples.back().stamp_s));
    }
    samples.push_back(sample);
  }
  if (samples.empty()) throw InputError(fmt::format("{}: holds no headings", table.name));
  return samples;
}

std::string FormatHeadings(const std::vector<MeasuredHeading>& headings,
                           const evaluation::HeadingErrors* errors) {
  constexpr double kMinSigmaDeg = 0.001;
  std::string text = "timestamp,heading_deg,sigma_deg,confidence";
  text += errors == nullptr ? "\n" : ",true_heading_deg,error_deg\n";
  std::size_t next = 0;  // next error
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const compass::HeadingEstimate& estimate = headings[i].estimate;
    text += fmt::format("{:.6f},{},{:.5f},{:.4f}",
                        headings[i].stamp_s,
                        FormatAngle(kDegPerRad * estimate.heading_rad),
                        std::max(kMinSigmaDeg, kDegPerRad * std::sqrt(estimate.variance_rad2)),
                        estimate.confidence);
    if (errors != nullptr && next < errors->of.size() && errors->of[next].heading == i) {
      const evaluation::HeadingError& error = errors->of[next++];
      text += fmt::format(
          ",{},{:.5f}", FormatAngle(std::remainder(error.true_deg, 360)), error.error_deg);
    } else if (errors != nullptr) {
      text += ",,";
    }
    text += '\n';
  }
  return text;
}

}  // namespace ceilmap::files
