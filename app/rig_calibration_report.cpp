#include "app/rig_calibration_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "app/console.hpp"
#include "app/figure.hpp"
#include "app/report_folder.hpp"
#include "app/report_table.hpp"
#include "app/rig_calibration_figures.hpp"
#include "app/table.hpp"
#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;

// One parameter of the rig, in the unit that people read.
struct Parameter {
  const char* key;  // in JSON
  const char* name;
  const char* unit;
  double before = 0;
  Measured found;
  int digits = 4;
};

struct MountAngles {
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};

MountAngles AnglesOf(const Eigen::Matrix3d& R) {
  return {std::atan2(-R(0, 1), R(0, 0)), std::asin(R(0, 2)), std::atan2(-R(1, 2), R(2, 2))};
}

std::vector<Parameter> ParametersOf(const calib::Rig& before, const RigCalibration& result) {
  const auto degrees = [](const Measured& m) {
    return Measured{kDegPerRad * m.value, kDegPerRad * m.sigma};
  };
  const MountAngles angles = AnglesOf(before.up->T_base_cam.linear());
  const Eigen::Vector3d& t = before.up->T_base_cam.translation();
  const double Z = before.ceiling_height_m - t.z();
  const double focal_px = std::sqrt(before.up->camera.fx * before.up->camera.fy);
  const auto millimetres = [](const Measured& m) {
    return Measured{1000 * m.value, 1000 * m.sigma};
  };
  return {
      {"a_m", "a", "m", before.axle_behind_mast_m, result.axle_behind_mast_m},
      {"camera_y_m", "camera y", "m", t.y(), result.camera_y_m},
      {"camera_z_m", "camera z", "m", t.z(), result.camera_z_m},
      {"yaw_deg", "yaw", "deg", kDegPerRad * angles.yaw_rad, degrees(result.yaw_rad), 3},
      {"pitch_deg", "pitch", "deg", kDegPerRad * angles.pitch_rad, degrees(result.pitch_rad), 3},
      {"roll_deg", "roll", "deg", kDegPerRad * angles.roll_rad, degrees(result.roll_rad), 3},
      {"h_m", "h", "m", before.ceiling_height_m, result.ceiling_height_m},
      {"distance_m", "ceiling above camera", "m", Z, result.distance_m},
      {"mm_per_px", "scale", "mm/px", 1000 * Z / focal_px, millimetres(result.m_per_px)}};
}

ReportTable ParameterTable(const calib::Rig& before, const RigCalibration& result) {
  ReportTable table{"Rig", {"", "before", "measured", "sigma", "unit"}, {}};
  for (const Parameter& p : ParametersOf(before, result)) {
    table.rows.push_back(
        {p.name,
         fmt::format("{:.{}f}", p.before, p.digits),
         fmt::format("{:.{}f}", p.found.value, p.digits + 1),
         p.found.sigma > 0 ? fmt::format("{:.{}f}", p.found.sigma, p.digits + 1) : "-",
         p.unit});
  }
  return table;
}

}  // namespace

std::string RigHeader(const RigCalibration& result) {
  std::string text = "# measured by ceilmap calibrate rig, with standard deviations:\n";
  const auto add = [&text](
                       const char* name, const Measured& m, double unit, const char* unit_name) {
    text += fmt::format(
        "#   {} = {:.5f} +- {:.5f} {}\n", name, unit * m.value, unit * m.sigma, unit_name);
  };
  add("a", result.axle_behind_mast_m, 1, "m");
  add("h", result.ceiling_height_m, 1, "m");
  add("up: y", result.camera_y_m, 1, "m");
  if (result.camera_z_m.sigma > 0) add("up: z", result.camera_z_m, 1, "m");
  add("up: yaw", result.yaw_rad, kDegPerRad, "deg");
  add("up: pitch", result.pitch_rad, kDegPerRad, "deg");
  add("up: roll", result.roll_rad, kDegPerRad, "deg");
  return text;
}

void Summarize(const calib::Rig& before, const RigCalibration& result, Summary& summary) {
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  for (const Parameter& p : ParametersOf(before, result)) {
    parameters[p.key] = {{"before", p.before}, {"value", p.found.value}, {"sigma", p.found.sigma}};
  }
  const calibration::RigSolution& solution = result.solution;
  summary.quality = {{"parameters", parameters},
                     {"places", solution.places},
                     {"inliers", solution.inliers},
                     {"sigma_px", solution.sigma_px},
                     {"spin",
                      {{"keyframes", solution.spin.size()},
                       {"turn_deg", kDegPerRad * result.turn_rad},
                       {"wander_mm", 1000 * result.wander_m}}},
                     {"straight",
                      {{"keyframes", solution.straight.size()},
                       {"turn_deg", kDegPerRad * result.course_rad},
                       {"length_m", result.drive_length_m.value}}}};
}

void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const RigCalibration& result,
                    const CeilingKeyframes& spin,
                    Summary& summary) {
  const std::vector<ReportTable> tables{ParameterTable(before, result)};
  using Handler = nlohmann::ordered_json::error_handler_t;
  std::vector<std::filesystem::path> files =
      WriteReport(folder,
                  {{"metrics.json", summary.quality.dump(2, ' ', false, Handler::replace) + "\n"},
                   {"tables.md", FormatMarkdown(tables)},
                   {"tables.tex", FormatLatex(tables)}});
  calib::MountedCamera up = *before.up;
  const auto draw = [&](const char* name, double height_m, double axle_m) {
    const std::filesystem::path file = folder / name;
    const cv::Mat mosaic = SpinMosaic(spin, result.solution.spin, up, height_m, axle_m);
    if (!cv::imwrite(file.string(), mosaic)) {
      throw calib::RunError(fmt::format("{}: cannot be written", file.string()));
    }
    files.push_back(file);
  };
  draw("spin-before.png", before.ceiling_height_m, before.axle_behind_mast_m);
  up.T_base_cam = result.T_base_up;
  draw("spin-after.png", result.ceiling_height_m.value, result.axle_behind_mast_m.value);
  summary.files.insert(summary.files.end(), files.begin(), files.end());
  try {
    FigureFolder figures(folder / "figures");
    figures.Draw(RigFigures(result));
    summary.files.insert(summary.files.end(), figures.Files().begin(), figures.Files().end());
  } catch (const calib::RunError& error) {
    Warn("no figures: {}", error.what());
  }
}

void PrintReport(const calib::Rig& before,
                 const RigCalibration& result,
                 double seconds,
                 const Summary& summary) {
  fmt::print("{}\n", FormatPlain(ParameterTable(before, result)));
  const calibration::RigSolution& solution = result.solution;
  Table facts;
  facts.AddRow({"spin",
                fmt::format("{:.1f}", kDegPerRad * result.turn_rad),
                fmt::format("deg in {} views, axle steady to {:.1f} mm",
                            solution.spin.size(),
                            1000 * result.wander_m)});
  facts.AddRow({"straight drive",
                fmt::format("{:.3f}", result.drive_length_m.value),
                fmt::format("m in {} views, course steady to {:.2f} deg",
                            solution.straight.size(),
                            kDegPerRad * result.course_rad)});
  facts.AddRow({"places",
                fmt::format("{}", solution.places),
                fmt::format("of the ceiling in two views, residual {:.3f} px", solution.sigma_px)});
  facts.AddRow({"time", fmt::format("{:.1f}", seconds), "s"});
  fmt::print("{}", facts.Format());
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace ceilmap::app
