#include "app/compensation_report.hpp"

#include <fmt/format.h>

#include <optional>

#include "app/csv.hpp"
#include "app/table.hpp"

namespace ceilmap::app {
namespace {

using evaluation::CompensatedFrame;
using evaluation::Compensation;
using evaluation::CompensationRatio;
using evaluation::ErrorStatistics;
using evaluation::PathErrors;
using evaluation::PlacedError;
using evaluation::TiltDegrees;
using nlohmann::ordered_json;

std::string Centimetres(double metres) {
  return fmt::format("{:.2f}", 100 * metres);
}

std::string ThreeDecimals(double value) {
  return fmt::format("{:.3f}", value);
}

// Lengths to the nanometre, as in trajectories.
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

std::string FormatTables(const std::vector<NamedCompensation>& rows) {
  Table errors;
  errors.AddRow({"compensation",
                 "along before cm",
                 "after",
                 "ratio",
                 "across before cm",
                 "after",
                 "ratio",
                 "rmse before cm",
                 "after",
                 "ratio"});
  Table tilt;
  tilt.AddRow({"tilt", "pitch rmse deg", "max", "roll rmse deg", "max"});
  for (const auto& [name, c] : rows) {
    errors.AddRow({name,
                   Centimetres(c.before.max_along_m),
                   Centimetres(c.after.max_along_m),
                   ThreeDecimals(c.ratio.max_along),
                   Centimetres(c.before.max_across_m),
                   Centimetres(c.after.max_across_m),
                   ThreeDecimals(c.ratio.max_across),
                   Centimetres(c.before.rmse_m),
                   Centimetres(c.after.rmse_m),
                   ThreeDecimals(c.ratio.rmse)});
    tilt.AddRow({name,
                 ThreeDecimals(c.pitch_deg.rmse),
                 ThreeDecimals(c.pitch_deg.max),
                 ThreeDecimals(c.roll_deg.rmse),
                 ThreeDecimals(c.roll_deg.max)});
  }
  return errors.Format() + '\n' + tilt.Format();
}

std::string FormatTableCsv(const std::vector<NamedCompensation>& rows) {
  std::string text =
      "estimate,along_before_m,along_m,along_ratio,across_before_m,across_m,across_ratio,"
      "rmse_before_m,rmse_m,rmse_ratio,pitch_rmse_deg,pitch_max_deg,roll_rmse_deg,roll_max_deg\n";
  for (const auto& [name, c] : rows) {
    text += fmt::format("{},{:.9f},{:.9f},{:.6f},{:.9f},{:.9f},{:.6f},{:.9f},{:.9f},{:.6f},",
                        CsvField(name),
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

std::string FormatFramesCsv(const Compensation& compensation) {
  std::string text =
      "timestamp,along_before_m,across_before_m,along_m,across_m,true_pitch_deg,true_roll_deg,"
      "pitch_deg,roll_deg,true_x,true_y,before_x,before_y,x,y\n";
  for (const CompensatedFrame& frame : compensation.frames) {
    text += fmt::format("{:.6f},{},{},{},{},{:.9f},{:.9f},{},{}\n",
                        frame.stamp_s,
                        Errors(frame.before),
                        Errors(frame.after),
                        Angles(frame.true_tilt),
                        Angles(frame.tilt),
                        frame.p_truth.x(),
                        frame.p_truth.y(),
                        Position(frame.before),
                        Position(frame.after));
  }
  return text;
}

ordered_json ToJson(const ErrorStatistics& statistics) {
  return {{"rmse", statistics.rmse},
          {"mean", statistics.mean},
          {"median", statistics.median},
          {"p95", statistics.p95},
          {"max", statistics.max}};
}

ordered_json ToJson(const PathErrors& errors) {
  return {{"matched", errors.matched},
          {"expected", errors.expected},
          {"max_along_m", errors.max_along_m},
          {"max_across_m", errors.max_across_m},
          {"max_m", errors.max_m},
          {"rmse_m", errors.rmse_m}};
}

ordered_json ToJson(const Compensation& compensation) {
  const CompensationRatio& ratio = compensation.ratio;
  return {{"after", ToJson(compensation.after)},
          {"ratio",
           {{"max_along", ratio.max_along},
            {"max_across", ratio.max_across},
            {"max", ratio.max},
            {"rmse", ratio.rmse}}},
          {"tilt_error_deg",
           {{"pitch", ToJson(compensation.pitch_deg)}, {"roll", ToJson(compensation.roll_deg)}}}};
}

}  // namespace ceilmap::app
