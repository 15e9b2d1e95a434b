#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "app/figures/figure.hpp"
#include "app/page/html_text.hpp"
#include "app/reports/camera_calibration_report.hpp"
#include "app/reports/report_folder.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/degrees.hpp"
#include "calib/solve/rectification.hpp"

namespace fs = std::filesystem;

namespace ceilmap::reports {
namespace {

using calibration::SolvedView;

constexpr int kWidthPx = 860;

// Space for labels beside an image of the given aspect ratio.
int HeightOf(cv::Size size) {
  return 90 + static_cast<int>(0.88 * kWidthPx * size.height / size.width);
}

std::string ImageAxes(cv::Size size) {
  return fmt::format(
      "set xrange [-0.5:{}]\nset yrange [{}:-0.5]\nset size ratio {:.5f}\nset xlabel 'u (px)'\n"
      "set ylabel 'v (px)'\n",
      size.width - 0.5,
      size.height - 0.5,
      static_cast<double>(size.height) / size.width);
}

std::string ResidualData(const calibration::CameraCalibration& calibration) {
  std::string text = "u_px,v_px,du_px,dv_px,picture\n";
  for (const SolvedView& view : calibration.solution.views) {
    if (!view.used) continue;
    const calibration::BoardView& board = calibration.views[view.view];
    for (std::size_t i = 0; i < view.residuals_px.size(); ++i) {
      text += fmt::format("{:.3f},{:.3f},{:.4f},{:.4f},{}\n",
                          board.corners_px[i].x,
                          board.corners_px[i].y,
                          view.residuals_px[i].x,
                          view.residuals_px[i].y,
                          view.view);
    }
  }
  return text;
}

// A round factor with which an arrow of the RMS is about two hundredths of the image long.
double ArrowScale(const calibration::CameraCalibration& calibration) {
  const double wanted =
      0.02 * calibration.solution.lens.width_px / std::max(1e-6, calibration.solution.rms_px);
  const double decade = std::pow(10, std::floor(std::log10(wanted)));
  return wanted / decade >= 5 ? 5 * decade : wanted / decade >= 2 ? 2 * decade : decade;
}

figures::Figure ResidualFigure(const calibration::CameraCalibration& calibration) {
  figures::Figure figure;
  figure.name = "residuals";
  figure.width_px = kWidthPx;
  figure.height_px = HeightOf(calibration.solution.lens.Size());
  figure.data = {{"residuals.csv", ResidualData(calibration)}};
  const double scale = ArrowScale(calibration);
  figure.settings =
      ImageAxes(calibration.solution.lens.Size()) +
      fmt::format(
          "set title 'Measured minus modelled corners, {:g} times as long; RMS {:.3f} px'\n",
          scale,
          calibration.solution.rms_px);
  figure.plot = fmt::format(
      "  plot 'residuals.csv' using 1:2:({0:g} * $3):({0:g} * $4) every ::1 \\\n"
      "    with vectors head size screen 0.006,20 filled lc rgb '#0072B2' lw 1 notitle\n",
      scale);
  return figure;
}

figures::Figure CoverageFigure(const calibration::CameraCalibration& calibration) {
  const cv::Size size = calibration.solution.lens.Size();
  std::string cells = "u_px,v_px,boards\n";
  for (std::size_t i = 0; i < calibration.coverage.boards.size(); ++i) {
    const std::size_t row = i / calibration::Coverage::kColumns;
    const std::size_t column = i % calibration::Coverage::kColumns;
    cells += fmt::format(
        "{:.2f},{:.2f},{}\n",
        (static_cast<double>(column) + 0.5) * size.width / calibration::Coverage::kColumns - 0.5,
        (static_cast<double>(row) + 0.5) * size.height / calibration::Coverage::kRows - 0.5,
        calibration.coverage.boards[i]);
  }
  figures::Figure figure;
  figure.name = "coverage";
  figure.width_px = kWidthPx;
  figure.height_px = HeightOf(size);
  figure.data = {{"coverage.csv", std::move(cells)}};
  figure.settings =
      ImageAxes(size) +
      fmt::format(
          "set title 'Number of boards in each part of the image, and corners; {:.0f} % covered'\n"
          "set palette defined (0 '#FFFFFF', 1 '#D6E6F2', 10 '#56B4E9', 20 '#0072B2')\n"
          "set cbrange [0:*]\nset colorbox\nset grid front\n",
          100 * calibration.coverage.Share());
  figure.plot =
      "  plot 'coverage.csv' using 1:2:3 every ::1 with image pixels notitle, \\\n"
      "    'residuals.csv' using 1:2 every ::1 with points pt 7 ps 0.25 lc rgb '#D55E00' notitle\n";
  return figure;
}

figures::Figure ViewFigure(const calibration::CameraCalibration& calibration) {
  std::string data = "view,rms_px,tilt_deg,picture\n";
  int index = 0;
  for (const SolvedView& view : calibration.solution.views) {
    if (!view.used) continue;
    data += fmt::format("{},{:.4f},{:.2f},\"{}\"\n",
                        ++index,
                        view.rms_px,
                        view.tilt_rad * kDegPerRad,
                        calibration.views[view.view].name);
  }
  figures::Figure figure;
  figure.name = "views";
  figure.width_px = kWidthPx;
  figure.data = {{"views.csv", std::move(data)}};
  figure.settings = fmt::format(
      "set title 'Fit of each view'\nset xlabel 'view'\nset ylabel 'RMS (px)'\nset yrange [0:*]\n"
      "set xrange [0.3:{}]\nset style fill solid 0.6 noborder\nset boxwidth 0.7\n",
      index + 0.7);
  figure.plot = fmt::format(
      "  plot 'views.csv' using 1:2 every ::1 with boxes lc rgb '#0072B2' notitle, \\\n"
      "    {:.5f} with lines ls 7 title 'all'\n",
      calibration.solution.rms_px);
  return figure;
}

std::string HtmlTable(const ReportTable& table) {
  std::string html = "<h2>" + page::EscapedForHtml(table.title) + "</h2>\n<table><tr>";
  for (const std::string& column : table.columns)
    html += "<th>" + page::EscapedForHtml(column) + "</th>";
  html += "</tr>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + page::EscapedForHtml(cell) + "</td>";
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string Html(const calibration::CameraCalibration& calibration,
                 const std::vector<ReportTable>& tables,
                 const std::vector<std::string>& figures) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Camera " +
      page::EscapedForHtml(calibration.name) +
      "</title>\n<style>body{font:15px/1.5 sans-serif;max-width:900px;margin:2em auto;padding:0 "
      "1em}"
      "table{border-collapse:collapse}td,th{padding:.15em 1em .15em 0;text-align:left;"
      "border-bottom:1px solid #ddd}img{max-width:100%;height:auto}.two img{max-width:49%}"
      "</style></head><body>\n<h1>Camera " +
      page::EscapedForHtml(calibration.name) + "</h1>\n<table>\n";
  const terminal::Table facts = CameraFacts(calibration);
  for (const auto& row : facts.Rows()) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + page::EscapedForHtml(cell) + "</td>";
    html += "</tr>\n";
  }
  html += "</table>\n";
  for (const std::string& warning : calibration.warnings) {
    html += "<p><strong>To improve it:</strong> " + page::EscapedForHtml(warning) + "</p>\n";
  }
  for (const std::string& figure : figures) {
    html += fmt::format("<p><img src=\"figures/{0}.svg\" alt=\"{0}\"></p>\n", figure);
  }
  html +=
      "<h2>Before and after</h2>\n<p class=\"two\"><img src=\"before.jpg\" alt=\"as taken\">\n"
      "<img src=\"after.jpg\" alt=\"without distortion\"></p>\n";
  for (const ReportTable& table : tables) html += HtmlTable(table);
  return html + "</body></html>\n";
}

std::string Jpeg(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<fs::path> WriteCameraReport(const fs::path& folder,
                                        const calibration::CameraCalibration& calibration) {
  const std::vector<ReportTable> tables = CameraTables(calibration);
  std::vector<figures::Figure> figures;
  if (figures::FindGnuplot()) {
    figures = {ResidualFigure(calibration), CoverageFigure(calibration), ViewFigure(calibration)};
  } else {
    terminal::Warn(
        "gnuplot is not installed: {} has no figures; install it by 'apt-get install gnuplot-nox'",
        folder.string());
  }
  std::vector<std::string> names;
  names.reserve(figures.size());
  for (const figures::Figure& figure : figures) names.push_back(figure.name);
  using Handler = nlohmann::ordered_json::error_handler_t;
  const cv::Mat& before = calibration.images.sample;
  std::vector<fs::path> files = WriteReport(
      folder,
      {{"index.html", Html(calibration, tables, names)},
       {"metrics.json", CameraJson(calibration).dump(2, ' ', false, Handler::replace) + "\n"},
       {"tables.md", FormatMarkdown(tables)},
       {"tables.tex", FormatLatex(tables)},
       {"before.jpg", Jpeg(before)},
       {"after.jpg", Jpeg(calibration::Rectify(calibration.solution.lens, before))}});
  if (figures.empty()) return files;
  figures::FigureFolder drawn(folder / "figures");
  drawn.Draw(figures);
  files.insert(files.end(), drawn.Files().begin(), drawn.Files().end());
  return files;
}

}  // namespace ceilmap::reports
