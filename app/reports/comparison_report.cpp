#include "app/reports/comparison_report.hpp"

#include <fmt/format.h>

#include "app/files/csv.hpp"
#include "app/reports/comparison_tables.hpp"
#include "app/reports/evaluation_json.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::ErrorStatistics;
using evaluation::PoseErrorStatistics;
using nlohmann::ordered_json;

ordered_json EstimateJson(const ComparedEstimate& estimate, const std::string& align) {
  ordered_json json = {
      {"matched", estimate.matched},
      {"expected", estimate.expected},
      {"coverage", estimate.Coverage()},
      {"path_m", estimate.errors ? estimate.errors->path_m : estimate.heading.path_m},
      {"align", align}};
  if (estimate.errors) json.update(ToJson(*estimate.errors));
  json["file"] = estimate.file.file.string();
  json["offset_s"] = estimate.offset_s;
  if (estimate.found_offset) json["found_offset"] = ToJson(*estimate.found_offset);
  json["heading"] = ToJson(estimate.heading);
  if (estimate.consistency) json["consistency"] = ToJson(*estimate.consistency);
  if (!estimate.frames_of_status.empty()) json["frames_of_status"] = estimate.frames_of_status;
  return json;
}

// Rows of one estimate in metrics.csv.
class MetricRows {
 public:
  explicit MetricRows(std::string name) : name_(std::move(name)) {}

  void Add(const std::string& error, const char* unit, const ErrorStatistics& s) {
    text_ += fmt::format("{},{},{},{}", files::CsvField(name_), error, unit, s.count);
    for (const double value :
         {s.rmse, s.mean, s.median, s.std, s.min, s.p75, s.p90, s.p95, s.p99, s.max}) {
      text_ += fmt::format(",{:.9g}", value);
    }
    text_ += '\n';
  }
  void Add(const std::string& error, const char* unit, const std::optional<ErrorStatistics>& s) {
    if (s) Add(error, unit, *s);
  }
  void Add(const std::string& error, const std::optional<PoseErrorStatistics>& s) {
    if (!s) return;
    Add(error + " translation", "m", s->translation_m);
    Add(error + " rotation", "deg", s->rotation_deg);
    Add(error + " rotation part", "1", s->rotation_block);
    Add(error + " full", "1", s->full);
  }
  [[nodiscard]] const std::string& Text() const { return text_; }

 private:
  std::string name_;
  std::string text_;
};

std::string Number(double value) {
  return fmt::format("{:.9g}", value);
}

std::string NumberOrNothing(const std::optional<double>& value) {
  return value ? Number(*value) : "";
}

std::string JoinWithCommas(const std::vector<std::string>& fields) {
  return fmt::format("{}\n", fmt::join(fields, ","));
}

// Fields of NAME-errors.csv after the true pose.
std::string ErrorFields(const evaluation::FrameError* error) {
  if (error == nullptr) return ",,,,,,,,,,";
  return fmt::format("{:.9f},{:.9f},{:.7f},{:.9f},{:.9f},{:.9f},{:.7f},{:.7f},{:.7f},{:.9f},{:.7f}",
                     error->T_truth_base.x,
                     error->T_truth_base.y,
                     kDegPerRad * error->T_truth_base.yaw,
                     error->position_m,
                     error->along_m,
                     error->across_m,
                     error->yaw_deg,
                     error->pitch_deg,
                     error->roll_deg,
                     error->pose.translation_m,
                     kDegPerRad * error->pose.angle_rad);
}

}  // namespace

ordered_json ComparisonJson(const Comparison& comparison,
                            const ComparisonInputs& params,
                            const std::string& align) {
  ordered_json metrics = {{"truth", params.truth.string()}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    metrics["estimates"][estimate.file.name] = EstimateJson(estimate, align);
  }
  if (!comparison.compensation) return metrics;
  const auto& [alignment, largest_true_tilt, estimates] = *comparison.compensation;
  for (const auto& [name, compensation] : estimates) {
    metrics["estimates"][name]["compensation"] = ToJson(compensation);
  }
  metrics["before"] = ToJson(estimates.front().compensation.before);
  metrics["before"]["file"] = params.before.string();
  metrics["before"]["level_frames"] = alignment.level;
  metrics["true_tilt_deg"] = {{"pitch_max", largest_true_tilt.pitch_deg},
                              {"roll_max", largest_true_tilt.roll_deg}};
  return metrics;
}

std::string FormatMetricsCsv(const Comparison& comparison) {
  std::string text = "estimate,error,unit,count,rmse,mean,median,std,min,p75,p90,p95,p99,max\n";
  for (const ComparedEstimate& estimate : comparison.estimates) {
    MetricRows rows(estimate.file.name);
    if (estimate.errors) {
      const evaluation::TrajectoryErrors& errors = *estimate.errors;
      rows.Add("position", "m", errors.position_m);
      rows.Add("yaw", "deg", errors.yaw_deg);
      rows.Add("position per metre", "m", errors.per_metre_m);
      rows.Add("yaw per metre", "deg", errors.per_metre_yaw_deg);
      rows.Add("ape", errors.pose);
      rows.Add("rpe frame", errors.per_frame);
      rows.Add("rpe metre", errors.per_metre);
      rows.Add("rpe metre all pairs", errors.per_metre_all_pairs);
      for (const evaluation::SegmentErrors& segment : errors.segments) {
        const std::string what = fmt::format("segment {:g} m ", segment.length_m);
        rows.Add(what + "translation", "%", segment.translation_percent);
        rows.Add(what + "rotation", "deg/m", segment.rotation_deg_per_m);
      }
    }
    rows.Add("heading", "deg", estimate.heading.error_deg);
    text += rows.Text();
  }
  return text;
}

std::string FormatEstimatesCsv(const Comparison& comparison) {
  std::string text =
      "estimate,file,matched,expected,coverage,path_m,x_m,y_m,yaw_deg,scale,offset_s,"
      "offset_sigma_s,turned_deg,heading_mean_deg,heading_std_deg,heading_end_deg,drift_deg_per_m,"
      "drift_deg_per_s,position_nees,position_inside_95,pose_nees,pose_inside_95\n";
  for (const ComparedEstimate& estimate : comparison.estimates) {
    const auto& errors = estimate.errors;
    const evaluation::HeadingErrors& heading = estimate.heading;
    std::vector<std::string> fields = {files::CsvField(estimate.file.name),
                                       files::CsvField(estimate.file.file.string()),
                                       fmt::format("{}", estimate.matched),
                                       fmt::format("{}", estimate.expected),
                                       Number(estimate.Coverage()),
                                       Number(errors ? errors->path_m : heading.path_m)};
    if (errors) {
      const Similarity2& T = errors->T_truth_estimate;
      for (const double value : {T.motion.x, T.motion.y, kDegPerRad * T.motion.yaw, T.scale}) {
        fields.push_back(Number(value));
      }
    } else {
      fields.insert(fields.end(), 4, "");
    }
    fields.push_back(fmt::format("{:.6f}", estimate.offset_s));
    fields.push_back(estimate.found_offset ? Number(estimate.found_offset->sigma_s) : "");
    for (const double value :
         {heading.turned_deg, heading.signed_mean_deg, heading.std_deg, heading.end_deg}) {
      fields.push_back(Number(value));
    }
    fields.push_back(NumberOrNothing(heading.drift_deg_per_m));
    fields.push_back(NumberOrNothing(heading.drift_deg_per_s));
    if (const auto& consistency = estimate.consistency) {
      for (const evaluation::Nees& nees : {consistency->position, consistency->pose}) {
        fields.push_back(Number(nees.mean));
        fields.push_back(Number(nees.inside_95));
      }
    } else {
      fields.insert(fields.end(), 4, "");
    }
    text += JoinWithCommas(fields);
  }
  return text;
}

std::string FormatErrorsCsv(const std::vector<StampedPose>& truth,
                            const ComparedEstimate& estimate,
                            const evaluation::Compensation* compensation) {
  std::string text = "timestamp,";
  text += compensation != nullptr ? CompensatedFrameColumns() : "true_x,true_y";
  text +=
      ",true_yaw_deg,way_m,aligned_x,aligned_y,aligned_yaw_deg,position_error_m,ahead_m,left_m,"
      "yaw_error_deg,pitch_error_deg,roll_error_deg,translation_error_m,rotation_error_deg,"
      "heading_error_deg\n";
  const std::vector<double> distance_m = PathLengths(truth);
  std::size_t next = 0;          // next error
  std::size_t next_heading = 0;  // next error of the heading
  for (std::size_t i = 0; i < truth.size(); ++i) {
    text += fmt::format("{:.6f},", truth[i].stamp_s);
    text += compensation != nullptr
                ? FormatCompensatedFrame(compensation->frames[i])
                : fmt::format("{:.9f},{:.9f}", truth[i].position.x(), truth[i].position.y());
    text += fmt::format(",{:.7f},{:.9f},", kDegPerRad * YawOf(truth[i]), distance_m[i]);
    const evaluation::FrameError* error = nullptr;
    if (estimate.errors && next < estimate.errors->frames.size() &&
        estimate.errors->frames[next].truth == i) {
      error = &estimate.errors->frames[next++];
    }
    text += ErrorFields(error) + ',';
    const auto& headings = estimate.heading.of;
    if (next_heading < headings.size() && headings[next_heading].truth == i) {
      text += fmt::format("{:.7f}", headings[next_heading++].error_deg);
    }
    text += '\n';
  }
  return text;
}

std::vector<ReportFile> ReportFiles(const Comparison& comparison, const ordered_json& metrics) {
  const std::vector<ReportTable> tables = ComparisonTables(comparison);
  using Handler = ordered_json::error_handler_t;
  std::vector<ReportFile> files = {
      {"metrics.json", metrics.dump(2, ' ', false, Handler::replace) + "\n"},
      {"metrics.csv", FormatMetricsCsv(comparison)},
      {"estimates.csv", FormatEstimatesCsv(comparison)},
      {"tables.md", FormatMarkdown(tables)},
      {"tables.tex", FormatLatex(tables)}};
  if (comparison.compensation) {
    files.push_back({"compensation.csv", FormatTableCsv(comparison.compensation->estimates)});
  }
  for (std::size_t i = 0; i < comparison.estimates.size(); ++i) {
    const ComparedEstimate& estimate = comparison.estimates[i];
    const evaluation::Compensation* const compensation =
        comparison.compensation ? &comparison.compensation->estimates[i].compensation : nullptr;
    files.push_back({estimate.file.name + "-errors.csv",
                     FormatErrorsCsv(comparison.truth, estimate, compensation)});
  }
  return files;
}

}  // namespace ceilmap::reports
