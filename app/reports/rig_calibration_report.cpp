#include "app/reports/rig_calibration_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "app/figures/figure.hpp"
#include "app/reports/report_folder.hpp"
#include "app/reports/report_table.hpp"
#include "app/reports/rig_calibration_figures.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::reports {
namespace {

// One parameter of the rig, in the unit of the table.
struct Parameter {
  const char* key;  // key in JSON
  const char* name;
  const char* unit;
  double before = 0;
  mount::Measured found;
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

mount::Measured InDegrees(const mount::Measured& m) {
  return {kDegPerRad * m.value, kDegPerRad * m.sigma};
}

// Milliseconds; the rig's own value without a deviation where it was not measured.
mount::Measured ReadoutOf(const mount::ReadoutFinding& readout) {
  if (!readout.is_determined) return {1e3 * readout.used_s, 0};
  return {1e3 * readout.readout_time_s.value, 1e3 * readout.readout_time_s.sigma};
}

// Parameters from the upward camera's recordings.
std::vector<Parameter> MountParameters(const calib::Rig& before, const mount::UpMount& result) {
  const MountAngles angles = AnglesOf(before.up->T_base_cam.linear());
  const Eigen::Vector3d& t = before.up->T_base_cam.translation();
  const double Z = before.ceiling_height_m - t.z();
  const double focal_px = std::sqrt(before.up->camera.fx * before.up->camera.fy);
  const auto millimetres = [](const mount::Measured& m) {
    return mount::Measured{1000 * m.value, 1000 * m.sigma};
  };
  return {
      {"a_m", "a", "m", before.axle_behind_mast_m, result.axle_behind_mast_m},
      {"camera_y_m", "camera y", "m", t.y(), result.camera_y_m},
      {"camera_z_m", "camera z", "m", t.z(), result.camera_z_m},
      {"yaw_deg", "yaw", "deg", kDegPerRad * angles.yaw_rad, InDegrees(result.yaw_rad), 3},
      {"pitch_deg", "pitch", "deg", kDegPerRad * angles.pitch_rad, InDegrees(result.pitch_rad), 3},
      {"roll_deg", "roll", "deg", kDegPerRad * angles.roll_rad, InDegrees(result.roll_rad), 3},
      {"readout_ms",
       "read-out",
       "ms",
       1000 * before.up->readout_time_s,
       ReadoutOf(result.readout),
       2},
      {"h_m", "h", "m", before.ceiling_height_m, result.ceiling_height_m},
      {"distance_m", "ceiling above camera", "m", Z, result.distance_m},
      {"mm_per_px", "scale", "mm/px", 1000 * Z / focal_px, millimetres(result.m_per_px)}};
}

std::vector<Parameter> ForwardParameters(const calib::Rig& before,
                                         const mount::ForwardMount& result) {
  const mount::ForwardAngles angles = mount::ForwardAnglesOf(before.forward->T_base_cam.linear());
  const auto add =
      [](const char* key, const char* name, double was_rad, const mount::Measured& found) {
        return Parameter{key, name, "deg", kDegPerRad * was_rad, InDegrees(found), 3};
      };
  return {add("forward_yaw_deg", "forward yaw", angles.yaw_rad, result.yaw_rad),
          add("forward_pitch_deg", "forward pitch (up)", angles.pitch_rad, result.pitch_rad),
          add("forward_roll_deg", "forward roll", angles.roll_rad, result.roll_rad)};
}

// What the recordings have shown of wheels and gyro.
std::vector<Parameter> WheelParameters(const calib::Rig& before,
                                       const mount::WheelConstants& result) {
  const wheels::WheelModel was = before.wheels.value_or(wheels::WheelModel{});
  const wheels::WheelModel& is = result.model;
  std::vector<Parameter> shown;
  const auto add = [&shown](const char* key,
                            const char* name,
                            const char* unit,
                            double factor,
                            const wheels::Uncertain& old,
                            const wheels::Uncertain& found,
                            int digits) {
    if (!(found.sigma < old.sigma)) return;
    const mount::Measured measured{factor * found.value, factor * found.sigma};
    shown.push_back({key, name, unit, factor * old.value, measured, digits});
  };
  constexpr double kMsPerS = 1e3;
  add("wheel_scale", "wheel scale", "", 1, was.scale, is.scale, 4);
  add("turn_scale", "turn scale", "", 1, was.turn_scale, is.turn_scale, 4);
  add("wheels_late_ms", "wheels late", "ms", kMsPerS, was.late_s, is.late_s, 1);
  add("gyro_bias_deg_s",
      "gyro bias",
      "deg/s",
      kDegPerRad,
      was.gyro_bias_rad_s,
      is.gyro_bias_rad_s,
      3);
  add("gyro_late_ms", "gyro late", "ms", kMsPerS, was.gyro_late_s, is.gyro_late_s, 1);
  return shown;
}

std::vector<Parameter> ParametersOf(const calib::Rig& before, const RigFindings& result) {
  std::vector<Parameter> all = MountParameters(before, result.up);
  const auto add = [&all](const std::vector<Parameter>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  if (result.forward) add(ForwardParameters(before, *result.forward));
  if (result.wheels) add(WheelParameters(before, *result.wheels));
  return all;
}

ReportTable ParameterTable(const calib::Rig& before, const RigFindings& result) {
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

std::string RigHeader(const RigFindings& found) {
  const mount::UpMount& result = found.up;
  std::string text = "# measured by ceilmap calibrate rig, with standard deviations:\n";
  const auto add =
      [&text](const char* name, const mount::Measured& m, double unit, const char* unit_name) {
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
  if (result.readout.is_determined) add("up: read-out", result.readout.readout_time_s, 1, "s");
  if (found.forward) {
    add("forward: yaw", found.forward->yaw_rad, kDegPerRad, "deg");
    add("forward: pitch (up)", found.forward->pitch_rad, kDegPerRad, "deg");
    add("forward: roll", found.forward->roll_rad, kDegPerRad, "deg");
  }
  if (found.wheels) {
    const wheels::WheelModel& model = found.wheels->model;
    const auto shown = [&add](const char* name,
                              const wheels::Uncertain& value,
                              const wheels::WheelsReport& by,
                              double unit,
                              const char* unit_name) {
      if (by.pieces > 0) add(name, {value.value, value.sigma}, unit, unit_name);
    };
    shown("wheels: scale", model.scale, found.wheels->wheels.both, 1, "");
    shown("wheels: turn scale", model.turn_scale, found.wheels->wheels.both, 1, "");
    shown("wheels: late", model.late_s, found.wheels->wheels.both, 1, "s");
    shown("gyro: bias", model.gyro_bias_rad_s, found.wheels->gyro.both, kDegPerRad, "deg/s");
    shown("gyro: late", model.gyro_late_s, found.wheels->gyro.both, 1, "s");
  }
  return text;
}

void Summarize(const calib::Rig& before, const RigFindings& found, terminal::Summary& summary) {
  const mount::UpMount& result = found.up;
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
  for (const Parameter& p : ParametersOf(before, found)) {
    parameters[p.key] = {{"before", p.before}, {"value", p.found.value}, {"sigma", p.found.sigma}};
  }
  const calibration::RigSolution& solution = result.solution;
  summary.quality = {{"parameters", parameters},
                     {"places", solution.places},
                     {"inliers", solution.inliers},
                     {"sigma_px", solution.sigma_px},
                     {"spin",
                      {{"keyframes", solution.spin.size()},
                       {"turn_deg", kDegPerRad * result.spin_turn_rad},
                       {"wander_mm", 1000 * result.axle_motion_m}}},
                     {"straight",
                      {{"keyframes", solution.straight.size()},
                       {"turn_deg", kDegPerRad * result.course_turn_rad},
                       {"length_m", result.drive_length_m.value}}}};
  if (found.forward) {
    summary.quality["forward"] = {{"pairs", found.forward->pairs},
                                  {"matches", found.forward->solution.matches},
                                  {"inliers", found.forward->solution.inliers},
                                  {"sigma_px", found.forward->solution.sigma_px}};
  }
}

void WriteRigReport(const std::filesystem::path& folder,
                    const calib::Rig& before,
                    const RigFindings& found,
                    const mount::CeilingRecording& spin,
                    terminal::Summary& summary) {
  const mount::UpMount& result = found.up;
  const std::vector<ReportTable> tables{ParameterTable(before, found)};
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
      throw RunError(fmt::format("{}: cannot be written", file.string()));
    }
    files.push_back(file);
  };
  draw("spin-before.png", before.ceiling_height_m, before.axle_behind_mast_m);
  up.T_base_cam = result.T_base_up;
  draw("spin-after.png", result.ceiling_height_m.value, result.axle_behind_mast_m.value);
  summary.files.insert(summary.files.end(), files.begin(), files.end());
  try {
    figures::FigureFolder figures(folder / "figures");
    figures.Draw(RigFigures(result));
    summary.files.insert(summary.files.end(), figures.Files().begin(), figures.Files().end());
  } catch (const RunError& error) {
    terminal::Warn("no figures: {}", error.what());
  }
}

void PrintReport(const calib::Rig& before,
                 const RigFindings& found,
                 double seconds,
                 const terminal::Summary& summary) {
  fmt::print("{}\n", FormatPlain(ParameterTable(before, found)));
  const mount::UpMount& result = found.up;
  const calibration::RigSolution& solution = result.solution;
  terminal::Table facts;
  facts.AddRow({"spin",
                fmt::format("{:.1f}", kDegPerRad * result.spin_turn_rad),
                fmt::format("deg in {} views, axle steady to {:.1f} mm",
                            solution.spin.size(),
                            1000 * result.axle_motion_m)});
  facts.AddRow({"straight drive",
                fmt::format("{:.3f}", result.drive_length_m.value),
                fmt::format("m in {} views, course steady to {:.2f} deg",
                            solution.straight.size(),
                            kDegPerRad * result.course_turn_rad)});
  facts.AddRow({"places",
                fmt::format("{}", solution.places),
                fmt::format("of the ceiling in two views, residual {:.3f} px", solution.sigma_px)});
  if (found.forward) {
    facts.AddRow({"forward camera",
                  fmt::format("{}", found.forward->solution.matches),
                  fmt::format("matches in {} pairs of images, residual {:.3f} px",
                              found.forward->pairs,
                              found.forward->solution.sigma_px)});
  }
  facts.AddRow({"time", fmt::format("{:.1f}", seconds), "s"});
  fmt::print("{}", facts.Format());
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace ceilmap::reports
