#include "app/reports/compensation_report.hpp"

#include <fmt/format.h>

#include <optional>

#include "app/files/csv.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::CompensatedFrame;
using evaluation::Compensation;
using evaluation::PlacedError;
using evaluation::TiltDegrees;

std::string Centimetres(double metres) {
  return fmt::format("{:.2f}", 100 * metres);
}

std::string ThreeDecimals(double value) {
  return fmt::format("{:.3f}", value);
}

// Lengths with the digits of trajectories, to the nanometre.
std::string Errors(const std::optional<PlacedError>& error) {
  return error ? fmt::format("{:.9f},{:.9f}", error->along_m, error->across_m) : ",";
}

std::string Position(const std::optional<PlacedError>& error) {
  return error ? fmt::format("{:.9f},{:.9f}", error->p_truth.x(), error->p_truth.y()) : ",";
}

std::string Angles(const std::optional<TiltDegrees>& tilt) {
  return tilt ? fmt::format("{:.6f},{:.6f}", tilt->pitch_deg, tilt->roll_deg) : ",";
}

}  // namespace

std::vector<ReportTable> CompensationTables(const std::vector<NamedCompensation>& rows) {
  ReportTable errors{"Largest errors along and across the path, without and with tilt compensation",
                     {"compensation",
                      "along before cm",
                      "after",
                      "ratio",
                      "across before cm",
                      "after",
                      "ratio",
                      "rmse before cm",
                      "after",
                      "ratio"},
                     {}};
  ReportTable tilt{"Errors of the estimated tilt",
                   {"tilt", "pitch rmse deg", "max", "roll rmse deg", "max"},
                   {}};
  for (const auto& [name, c] : rows) {
    errors.rows.push_back({name,
                           Centimetres(c.before.max_along_m),
                           Centimetres(c.after.max_along_m),
                           ThreeDecimals(c.ratio.max_along),
                           Centimetres(c.before.max_across_m),
                           Centimetres(c.after.max_across_m),
                           ThreeDecimals(c.ratio.max_across),
                           Centimetres(c.before.rmse_m),
                           Centimetres(c.after.rmse_m),
                           ThreeDecimals(c.ratio.rmse)});
    tilt.rows.push_back({name,
                         ThreeDecimals(c.pitch_deg.rmse),
                         ThreeDecimals(c.pitch_deg.max),
                         ThreeDecimals(c.roll_deg.rmse),
                         ThreeDecimals(c.roll_deg.max)});
  }
  return {errors, tilt};
}

std::string FormatTableCsv(const std::vector<NamedCompensation>& rows) {
  std::string text =
      "estimate,along_before_m,along_m,along_ratio,across_before_m,across_m,across_ratio,"
      "rmse_before_m,rmse_m,rmse_ratio,pitch_rmse_deg,pitch_max_deg,roll_rmse_deg,roll_max_deg\n";
  for (const auto& [name, c] : rows) {
    text += fmt::format("{},{:.9f},{:.9f},{:.6f},{:.9f},{:.9f},{:.6f},{:.9f},{:.9f},{:.6f},",
                        files::CsvField(name),
                        c.before.max_along_m,
                        c.after.max_along_m,
                        c.ratio.max_along,
                        c.before.max_across_m,
                        c.after.max_across_m,
                        c.ratio.max_across,
                        c.before.rmse_m,
                        c.after.rmse_m,
                        c.ratio.rmse);
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}\n",
                        c.pitch_deg.rmse,
                        c.pitch_deg.max,
                        c.roll_deg.rmse,
                        c.roll_deg.max);
  }
  return text;
}

std::string_view CompensatedFrameColumns() {
  return "along_before_m,across_before_m,along_m,across_m,true_pitch_deg,true_roll_deg,pitch_deg,"
         "roll_deg,true_x,true_y,before_x,before_y,x,y";
}

std::string FormatCompensatedFrame(const CompensatedFrame& frame) {
  return fmt::format("{},{},{},{},{:.9f},{:.9f},{},{}",
                     Errors(frame.before),
                     Errors(frame.after),
                     Angles(frame.true_tilt),
                     Angles(frame.tilt),
                     frame.p_truth.x(),
                     frame.p_truth.y(),
                     Position(frame.before),
                     Position(frame.after));
}

}  // namespace ceilmap::reports
