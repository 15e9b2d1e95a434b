#include "app/reports/camera_calibration_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calib/base/degrees.hpp"
#include "calib/solve/rectification.hpp"

namespace ceilmap::reports {
namespace {

using calibration::CameraSolution;
using calibration::SolvedView;
constexpr Eigen::Index kPinhole = 4;

std::vector<std::string> ValueNames(calib::LensModel model) {
  std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
  for (std::string& name : calib::CoefficientNames(model)) names.push_back(std::move(name));
  return names;
}

// Rounded to two significant digits of the standard deviation.
std::string WithSigma(double value, double sigma) {
  if (!(sigma > 0)) return fmt::format("{:g}", value);
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
  return fmt::format("{:.{}f} +- {:.{}f}", value, digits, sigma, digits);
}

// By reason, its first words, because the messages on blur and misfit contain numbers.
void AddLeftOut(const calibration::CameraCalibration& calibration, terminal::Table& table) {
  std::map<std::string, int> counts;
  for (const auto& [name, why] : calibration.left_out) ++counts[why.substr(0, why.find(':'))];
  for (const auto& [why, count] : counts) {
    table.AddRow({"left out", fmt::format("{}", count), why});
  }
}

}  // namespace

terminal::Table CameraFacts(const calibration::CameraCalibration& calibration) {
  const CameraSolution& solution = calibration.solution;
  terminal::Table table;
  table.AddRow({"images",
                fmt::format("{}", calibration.images.images),
                fmt::format("{} with a {}, {} used",
                            calibration.images.views.size(),
                            calibration.board.Name(),
                            solution.UsedViews())});
  AddLeftOut(calibration, table);
  table.AddRow({"RMS",
                fmt::format("{:.3f}", solution.rms_px),
                fmt::format("px, over {} corners", solution.corners)});
  const std::vector<std::string> names = ValueNames(solution.lens.model);
  const Eigen::VectorXd values = solution.lens.Values();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const bool free = solution.free[index];
    const char* const unit = i < kPinhole ? "px"
                             : free       ? ""
                                    : "not estimated: it does not differ from 0 significantly";
    table.AddRow({names[index], WithSigma(values[i], solution.Sigma(i)), unit});
  }
  table.AddRow({"standard deviation",
                fmt::format("{:.2f}", solution.CornerSigma()),
                "px, at the image's corners"});
  table.AddRow(
      {"coverage", fmt::format("{:.0f} %", 100 * calibration.coverage.Share()), "of the image"});
  return table;
}

nlohmann::ordered_json CameraJson(const calibration::CameraCalibration& calibration) {
  const CameraSolution& solution = calibration.solution;
  nlohmann::ordered_json json;
  json["board"] = calibration.board.Name();
  json["distortion_model"] = calib::RosName(solution.lens.model);
  json["image_width"] = solution.lens.width_px;
  json["image_height"] = solution.lens.height_px;
  const std::vector<std::string> names = ValueNames(solution.lens.model);
  const Eigen::VectorXd values = solution.lens.Values();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    json["values"][name] = values[i];
    json["sigmas"][name] = solution.Sigma(i);
  }
  json["rms_px"] = solution.rms_px;
  json["corners"] = solution.corners;
  json["corner_sigma_px"] = solution.CornerSigma();
  json["coverage"] = calibration.coverage.Share();
  json["pictures"] = calibration.images.images;
  json["pictures_with_board"] = calibration.images.views.size();
  json["views"] = nlohmann::ordered_json::array();
  for (const SolvedView& view : solution.views) {
    if (!view.used) continue;
    json["views"].push_back({{"name", calibration.views[view.view].name},
                             {"rms_px", view.rms_px},
                             {"tilt_deg", kDegPerRad * view.tilt_rad},
                             {"edge_px", calibration.views[view.view].edge_px}});
  }
  json["left_out"] = nlohmann::ordered_json::array();
  for (const auto& [name, why] : calibration.left_out) {
    json["left_out"].push_back({{"name", name}, {"why", why}});
  }
  json["warnings"] = calibration.warnings;
  return json;
}

calib::CameraInfo CameraInfoOf(const calibration::CameraCalibration& calibration) {
  const CameraSolution& solution = calibration.solution;
  calib::CameraInfo info;
  info.name = calibration.name;
  info.lens = solution.lens;
  info.rectified = calibration::RectifiedPinhole(solution.lens);
  std::string sigmas = "standard deviations:";
  const std::vector<std::string> names = ValueNames(solution.lens.model);
  const Eigen::VectorXd values = solution.lens.Values();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    sigmas += fmt::format(" {} {:.3g}", names[static_cast<std::size_t>(i)], solution.Sigma(i));
  }
  info.remarks = {fmt::format("ceilmap calibrate camera: {} views of a {}, RMS {:.3f} px",
                              solution.UsedViews(),
                              calibration.board.Name(),
                              solution.rms_px),
                  sigmas};
  return info;
}

std::vector<ReportTable> CameraTables(const calibration::CameraCalibration& calibration) {
  const CameraSolution& solution = calibration.solution;
  ReportTable lens{"Camera", {"value", "estimate", "sigma"}, {}};
  const std::vector<std::string> names = ValueNames(solution.lens.model);
  const Eigen::VectorXd values = solution.lens.Values();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    lens.rows.push_back({names[static_cast<std::size_t>(i)],
                         fmt::format("{:.6g}", values[i]),
                         fmt::format("{:.2g}", solution.Sigma(i))});
  }
  ReportTable views{"Views", {"image", "RMS (px)", "tilt (deg)", "edge (px)", "corners"}, {}};
  for (const SolvedView& view : solution.views) {
    if (!view.used) continue;
    const calibration::BoardView& board = calibration.views[view.view];
    views.rows.push_back({board.name,
                          fmt::format("{:.3f}", view.rms_px),
                          fmt::format("{:.1f}", kDegPerRad * view.tilt_rad),
                          board.edge_px > 0 ? fmt::format("{:.1f}", board.edge_px) : "",
                          fmt::format("{}", board.ids.size())});
  }
  std::vector<ReportTable> tables = {std::move(lens), std::move(views)};
  if (calibration.left_out.empty()) return tables;
  ReportTable& left_out = tables.emplace_back(ReportTable{"Left out", {"image", "why"}, {}});
  for (const auto& [name, why] : calibration.left_out) left_out.rows.push_back({name, why});
  return tables;
}

}  // namespace ceilmap::reports
