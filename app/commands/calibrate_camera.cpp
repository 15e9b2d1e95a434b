#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "app/commands/calibrate_commands.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/board_images.hpp"
#include "app/reports/camera_calibration_report.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"
#include "calib/solve/board_drawing.hpp"
#include "calib/solve/camera_calibration.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct CalibrateCameraOptions {
  std::vector<std::string> images;
  std::string board = "chessboard";
  std::string corners;
  double square_m = 0;
  double marker_m = 0;
  std::string dictionary = "4x4_50";
  std::string model = "plumb_bob";
  bool all_terms = false;
  int max_views = 40;
  std::string name = "camera";
  recordings::BagOptions bags;
  fs::path report;
  fs::path output;
  fs::path print_board;
  std::string paper = "a4";

  // @throws InputError
  [[nodiscard]] calibration::Board Board() const;
  void Check(files::Existing existing) const;
};

// The library names the field first; the option has the same name.
template <typename Function>
auto NamingOption(const Function& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw InputError(fmt::format("--{}", error.what()));
  }
}

calib::LensModel ParseModel(const std::string& text) {
  const std::string name = text == "rational" ? "rational_polynomial" : text;
  const auto model = calib::FindLensModel(name);
  if (model) return *model;
  throw InputError(fmt::format("--model {}: must be plumb_bob, rational or equidistant", text));
}

calibration::Board CalibrateCameraOptions::Board() const {
  return NamingOption([this] {
    const cv::Size size = calibration::ParseCorners(corners);
    calibration::Board result;
    result.kind = calibration::ParseBoardKind(board);
    result.columns = size.width;
    result.rows = size.height;
    result.square_m = square_m;
    result.marker_m = marker_m;
    result.dictionary = dictionary;
    result.Validate();
    return result;
  });
}

void CalibrateCameraOptions::Check(files::Existing existing) const {
  constexpr int kMinViews = 3;
  if (max_views < kMinViews) {
    throw InputError(fmt::format("--views {}: must be at least {}", max_views, kMinViews));
  }
  if (output.empty() && print_board.empty()) {
    throw InputError(
        "calibrate camera: name the result with -o INFO.yaml, or a board to print with "
        "--print-board");
  }
  if (!print_board.empty() && !(images.empty() && output.empty())) {
    throw InputError("--print-board: print the board first, then calibrate with its images");
  }
  files::CheckOutputFiles({output, print_board}, existing);
  if (!report.empty()) files::CheckOutputFolder(report, existing);
}

void PrintBoard(const CalibrateCameraOptions& params,
                const CommonOptions& common,
                terminal::Summary& summary) {
  const calibration::Board board = params.Board();
  const std::string extension = params.print_board.extension().string();
  if (extension != ".pdf" && extension != ".svg") {
    throw InputError(
        fmt::format("--print-board {}: must end in .pdf or .svg", params.print_board.string()));
  }
  const calibration::BoardDrawing drawing = NamingOption(
      [&] { return calibration::DrawBoard(board, calibration::ParsePaper(params.paper)); });
  files::WriteFileAtomically(
      params.print_board,
      extension == ".pdf" ? calibration::FormatPdf(drawing) : calibration::FormatSvg(drawing));
  summary.files = {params.print_board};
  if (common.quiet) return;
  fmt::print("{} on {}\nwritten {}\n", board.Name(), params.paper, params.print_board.string());
}

void RunCalibrateCamera(const CalibrateCameraOptions& params,
                        const CommonOptions& common,
                        terminal::Summary& summary) {
  params.Check(common.Existing());
  if (!params.print_board.empty()) return PrintBoard(params, common, summary);
  const calibration::Board board = params.Board();
  calibration::SolverParams solver;
  solver.model = ParseModel(params.model);
  solver.choose_terms = !params.all_terms;
  calibration::BoardImages images =
      recordings::FindBoards(params.images, board, params.bags.Topic("image"));
  if (terminal::Interrupted()) throw RunError("interrupted before all images were processed");
  calibration::CameraCalibration calibration = calibration::CalibrateCamera(
      board, std::move(images), solver, static_cast<std::size_t>(params.max_views));
  calibration.name = params.name;
  for (const std::string& warning : calibration.warnings) terminal::PrintWarning(warning);
  summary.frames = calibration.images.images;
  summary.quality = reports::CameraJson(calibration);
  files::WriteFileAtomically(params.output,
                             calib::FormatCameraInfo(reports::CameraInfoOf(calibration)));
  summary.files = {params.output};
  if (!params.report.empty()) {
    for (fs::path& file : reports::WriteCameraReport(params.report, calibration)) {
      summary.files.push_back(std::move(file));
    }
  }
  if (common.quiet) return;
  fmt::print("{}", reports::CameraFacts(calibration).Format());
  if (common.verbose) {
    for (const reports::ReportTable& table : reports::CameraTables(calibration)) {
      fmt::print("\n{}\n{}", table.title, reports::FormatPlain(table));
    }
  }
  fmt::print("written {}\n", params.output.string());
  if (!params.report.empty()) fmt::print("written {}\n", (params.report / "index.html").string());
}

void AddBoardOptions(CLI::App& cli, CalibrateCameraOptions& params) {
  const std::string group = "Board";
  const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group(group);
  };
  add("--board",
      params.board,
      "chessboard, or charuco: with markers, may be partly visible",
      "KIND")
      ->capture_default_str();
  add("--corners",
      params.corners,
      "Inner corners, where four squares meet; 9x6: 10x7 squares",
      "CxR")
      ->required();
  add("--square", params.square_m, "Side of a square, metres; measure it: printers may scale", "M")
      ->required();
  add("--marker", params.marker_m, "Side of a marker, metres; only with charuco", "M");
  add("--dictionary", params.dictionary, "Dictionary of the markers, e.g. 5x5_100", "NAME")
      ->capture_default_str();
}

}  // namespace

Command AddCalibrateCameraCommand(CLI::App& calibrate) {
  Command command =
      MakeCommand(calibrate,
                  "camera",
                  "Measures a camera's focal lengths, centre and distortion with a printed board.",
                  "ceilmap calibrate camera --print-board board.pdf --corners 9x6 --square 0.025\n"
                  "  ceilmap calibrate camera images --corners 9x6 --square 0.025 -o up.yaml "
                  "--report report\n"
                  "  ceilmap calibrate camera walk.mp4 --board charuco --corners 9x6 --square "
                  "0.025 --marker 0.018 "
                  "-o up.yaml\n"
                  "Fix the board to a flat plate. Record it about 15 times, in all parts of the "
                  "image, near, and "
                  "tilted by 30 to 45 degrees to all sides. Do not move it during an exposure.");
  auto params = std::make_shared<CalibrateCameraOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option(
         "images", params->images, "A folder of images, a video, a bag of ROS, or several images")
      ->type_name("SOURCE");
  params->bags.AddTo(cli, {"image"});
  AddBoardOptions(cli, *params);
  const auto add =
      [&](const char* name, auto& value, const char* text, const char* type, const char* group) {
        return cli.add_option(name, value, text)->type_name(type)->group(group);
      };
  const char* const lens = "Camera";
  add("--model", params->model, "plumb_bob, rational (wide) or equidistant (fisheye)", "NAME", lens)
      ->capture_default_str();
  cli.add_flag("--all-terms", params->all_terms, "Estimate all coefficients, also unnecessary ones")
      ->group(lens);
  add("--views",
      params->max_views,
      "Maximum number of views; the most informative are used",
      "N",
      lens)
      ->capture_default_str();
  add("--name", params->name, "Name of the camera in the file", "NAME", lens)
      ->capture_default_str();
  const char* const result = "Results";
  add("-o,--output",
      params->output,
      "ROS camera_info, for rig.yaml and other programs",
      "INFO.yaml",
      result);
  add("--report",
      params->report,
      "Folder for a report of residuals, coverage and views: index.html",
      "DIR",
      result);
  add("--print-board",
      params->print_board,
      "Only draw the board to scale, for printing",
      "FILE.pdf|svg",
      result);
  add("--paper", params->paper, "a4, a3 or letter", "NAME", result)->capture_default_str();
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunCalibrateCamera(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
