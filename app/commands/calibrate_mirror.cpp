#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "app/commands/calibrate_commands.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/images.hpp"
#include "app/recordings/panorama_source.hpp"
#include "app/reports/report_folder.hpp"
#include "app/reports/report_table.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/mirror_view.hpp"
#include "calib/rig.hpp"
#include "calib/rig_text.hpp"
#include "calib/solve/mirror_finder.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using calibration::MirrorRingFit;

struct CalibrateMirrorOptions {
  std::string omni;
  fs::path stamps;
  fs::path rig;
  std::string ring;
  fs::path panorama;
  fs::path report;
  fs::path output;

  // Checks everything that can be told without the recording. @throws InputError
  void Check() const;
};

void CalibrateMirrorOptions::Check() const {
  if (!output.empty() && rig.empty()) {
    throw InputError(
        "calibrate mirror: -o writes a rig with the mirror in it; give the rig so far by --rig");
  }
  if (!panorama.empty() && panorama.extension() != ".png") {
    throw InputError(fmt::format("{}: the image's name must end in .png", panorama.string()));
  }
  files::CheckOutputFiles({output, panorama});
  if (!report.empty()) reports::CheckReportFolder(report);
}

// What was seen: the first image, and what all of them tell.
struct MirrorObservation {
  cv::Mat image;
  std::int64_t images = 0;
  MirrorRingFit fit;
};

bool IsImage(const std::string& source) {
  std::error_code ignored;
  return fs::is_regular_file(source, ignored) && recordings::IsImageName(source);
}

MirrorObservation ObserveImage(const std::string& file) {
  MirrorObservation sight;
  sight.image = recordings::ReadImage(file, recordings::Pixels::kColour);
  sight.images = 1;
  sight.fit = calibration::FindRing(sight.image);
  return sight;
}

MirrorObservation ObserveRecording(const CalibrateMirrorOptions& params) {
  recordings::FrameSource source(params.omni,
                                 {.pixels = recordings::Pixels::kColour, .stamps = params.stamps});
  terminal::Progress progress("looking", "frames", source.ExpectedFrames());
  MirrorObservation sight;
  calibration::MirrorActivity activity;
  recordings::Frame frame;
  while (source.Read(frame)) {
    if (sight.image.empty()) sight.image = frame.image.clone();
    activity.Add(frame.image);
    progress.Update(++sight.images);
  }
  if (terminal::Interrupted()) throw RunError("interrupted; nothing was written");
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  sight.fit =
      sight.images == 1 ? calibration::FindRing(sight.image) : calibration::FindRing(activity);
  return sight;
}

void CheckFound(const CalibrateMirrorOptions& params, const MirrorObservation& sight) {
  switch (sight.fit.fault) {
    case calibration::MirrorFault::kNone:
      return;
    case calibration::MirrorFault::kNothingMoves:
      throw InputError(
          fmt::format("{}: nothing moves in the mirror; record it while the robot turns, in a lit "
                      "room with things in it",
                      params.omni));
    case calibration::MirrorFault::kNoRim:
      break;
  }
  throw InputError(
      fmt::format("{}: no mirror with a round rim is to be seen; light the room, or say where it "
                  "is: --ring U,V,INNER,OUTER",
                  params.omni));
}

// A circle that the image shows all around: what a panorama can be made of.
calib::MirrorRing InsideImage(calib::MirrorRing ring, cv::Size size) {
  const Eigen::Vector2d far(size.width - 1, size.height - 1);
  const double room = std::min(ring.centre_px.minCoeff(), (far - ring.centre_px).minCoeff());
  ring.outer_radius_px = std::min(ring.outer_radius_px, std::floor(10 * room) / 10);
  return ring;
}

reports::ReportTable RingTable(const MirrorObservation& sight) {
  const MirrorRingFit& fit = sight.fit;
  const auto sigma = [](double s) { return s > 0 ? fmt::format("{:.3f}", s) : std::string("-"); };
  const auto row = [&](const char* name, double value, double s) {
    return std::vector<std::string>{name, fmt::format("{:.3f}", value), sigma(s), "px"};
  };
  return {"Mirror",
          {"", "measured", "sigma", "unit"},
          {row("centre u", fit.ring.centre_px.x(), std::sqrt(fit.centre_covariance(0, 0))),
           row("centre v", fit.ring.centre_px.y(), std::sqrt(fit.centre_covariance(1, 1))),
           row("outer radius", fit.ring.outer_radius_px, fit.outer_sigma_px),
           row("inner radius", fit.ring.inner_radius_px, fit.inner_sigma_px)}};
}

void Summarize(const MirrorObservation& sight, terminal::Summary& summary) {
  const MirrorRingFit& fit = sight.fit;
  summary.frames = sight.images;
  const auto value = [](double v, double sigma) {
    return nlohmann::ordered_json{{"value", v}, {"sigma", sigma}};
  };
  summary.quality = {
      {"parameters",
       {{"centre_u_px", value(fit.ring.centre_px.x(), std::sqrt(fit.centre_covariance(0, 0)))},
        {"centre_v_px", value(fit.ring.centre_px.y(), std::sqrt(fit.centre_covariance(1, 1)))},
        {"outer_radius_px", value(fit.ring.outer_radius_px, fit.outer_sigma_px)},
        {"inner_radius_px", value(fit.ring.inner_radius_px, fit.inner_sigma_px)}}},
      {"round_body", fit.round_body},
      {"body_seen", fit.body_seen},
      {"rim_part", fit.rim_ratio},
      {"rim_sigma_px", fit.rim_sigma_px}};
}

cv::Mat Panorama(const MirrorObservation& sight) {
  const calib::MirrorRing ring = InsideImage(sight.fit.ring, sight.image.size());
  calib::MirrorViewParams params;
  params.rows = std::max(1, static_cast<int>(ring.outer_radius_px - ring.inner_radius_px));
  const double middle = 0.5 * (ring.outer_radius_px + ring.inner_radius_px);
  params.columns = std::clamp(static_cast<int>(2 * std::numbers::pi * middle), 8, 16384);
  const calib::MirrorView view(sight.image.size(), ring, params);
  cv::Mat panorama;
  view.Unwrap(sight.image, panorama);
  return panorama;
}

cv::Mat Overlay(const MirrorObservation& sight) {
  constexpr int kShift = 4;  // sub-pixel drawing
  const auto fixed = [](double v) { return static_cast<int>(std::lround(v * (1 << kShift))); };
  cv::Mat image = sight.image.clone();
  if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  const auto dots = [&](const std::vector<Eigen::Vector2d>& points, const cv::Scalar& colour) {
    for (const Eigen::Vector2d& p : points) {
      cv::circle(image, {fixed(p.x()), fixed(p.y())}, fixed(1.5), colour, -1, cv::LINE_AA, kShift);
    }
  };
  const cv::Scalar orange(0, 94, 213);
  const cv::Scalar green(115, 158, 0);
  dots(sight.fit.rim, orange);
  dots(sight.fit.body, orange);
  const calib::MirrorRing& ring = sight.fit.ring;
  const cv::Point centre(fixed(ring.centre_px.x()), fixed(ring.centre_px.y()));
  for (const double radius : {ring.inner_radius_px, ring.outer_radius_px}) {
    cv::circle(image, centre, fixed(radius), green, 1, cv::LINE_AA, kShift);
  }
  cv::drawMarker(image, {centre.x >> kShift, centre.y >> kShift}, green, cv::MARKER_CROSS, 12);
  return image;
}

void WriteImage(const fs::path& file, const cv::Mat& image, terminal::Summary& summary) {
  if (!cv::imwrite(file.string(), image)) {
    throw RunError(fmt::format("{}: cannot be written", file.string()));
  }
  summary.files.push_back(file);
}

void WriteMirrorReport(const fs::path& folder,
                       const MirrorObservation& sight,
                       terminal::Summary& summary) {
  using Handler = nlohmann::ordered_json::error_handler_t;
  const std::vector<reports::ReportTable> tables{RingTable(sight)};
  const auto files = reports::WriteReport(
      folder,
      {{"metrics.json", summary.quality.dump(2, ' ', false, Handler::replace) + "\n"},
       {"tables.md", reports::FormatMarkdown(tables)},
       {"tables.tex", reports::FormatLatex(tables)}});
  summary.files.insert(summary.files.end(), files.begin(), files.end());
  WriteImage(folder / "mirror.png", Overlay(sight), summary);
  WriteImage(folder / "panorama.png", Panorama(sight), summary);
}

void WriteRig(const CalibrateMirrorOptions& params,
              const MirrorObservation& sight,
              terminal::Summary& summary) {
  const std::string text = ReadSettingsText(params.rig, "a rig file (format: calib/README.md)");
  calib::ParseRig(text, params.rig);
  calib::RigValues values;
  values.omni = {
      InsideImage(sight.fit.ring, sight.image.size()), sight.image.cols, sight.image.rows};
  const std::string changed = calib::ChangeRig(text, params.rig, values, params.output);
  calib::ParseRig(changed, params.output);
  files::WriteFileAtomically(params.output, changed);
  summary.files.push_back(params.output);
}

void PrintReport(const MirrorObservation& sight, const terminal::Summary& summary) {
  const MirrorRingFit& fit = sight.fit;
  fmt::print("{}", reports::FormatPlain(RingTable(sight)));
  fmt::print("rim seen in {:.0f} % of all directions, to {:.2f} px\n",
             100 * std::min(1.0, fit.rim_ratio),
             fit.rim_sigma_px);
  if (fit.body_seen && !fit.round_body && sight.images > 1) {
    fmt::print("the inner circle leaves out all of the robot, which is not round\n");
  }
  fmt::print("ceilmap heading --ring {:.2f},{:.2f},{:.2f},{:.2f}\n",
             fit.ring.centre_px.x(),
             fit.ring.centre_px.y(),
             fit.ring.inner_radius_px,
             InsideImage(fit.ring, sight.image.size()).outer_radius_px);
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

void RunCalibrateMirror(const CalibrateMirrorOptions& params,
                        const CommonOptions& common,
                        terminal::Summary& summary) {
  params.Check();
  std::optional<calib::MirrorRing> by_hand;
  if (!params.ring.empty()) by_hand = recordings::ParseRing(params.ring, "--ring");
  MirrorObservation sight =
      IsImage(params.omni) ? ObserveImage(params.omni) : ObserveRecording(params);
  if (by_hand) {
    sight.fit = {};
    sight.fit.ring = *by_hand;
  }
  CheckFound(params, sight);
  Summarize(sight, summary);
  if (!sight.fit.body_seen && !by_hand) {
    terminal::Warn(
        "{}: nothing in the middle of the mirror stands still; its inner radius is a guess",
        params.omni);
  }
  if (!params.output.empty()) WriteRig(params, sight, summary);
  if (!params.panorama.empty()) WriteImage(params.panorama, Panorama(sight), summary);
  if (!params.report.empty()) WriteMirrorReport(params.report, sight, summary);
  if (!common.quiet) PrintReport(sight, summary);
}

}  // namespace

Command AddCalibrateMirrorCommand(CLI::App& calibrate) {
  Command command = MakeCommand(
      calibrate,
      "mirror",
      "Measures where a convex mirror shows the room in the images of the camera below it, from "
      "a recording of a robot that turns.",
      "ceilmap calibrate mirror --omni turn.mp4 --rig rig.yaml -o new.yaml --report mirror\n"
      "  ceilmap calibrate mirror --omni image.jpg --panorama panorama.png\n"
      "A SOURCE is a video file, a folder or printf pattern of images, /dev/videoN, or a URL.");
  auto params = std::make_shared<CalibrateMirrorOptions>();
  CLI::App& cli = *command.cli;
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  const std::string input = "Input";
  const std::string result = "Results";
  add("--omni",
      params->omni,
      "The mirror while the robot turns or drives; or a single image, in which only light and "
      "dark tell, less well",
      "SOURCE")
      ->required()
      ->group(input);
  add("--stamps", params->stamps, "Not needed; checked when given", "FRAMES.csv")->group(input);
  add("--rig", params->rig, "The rig so far, with or without a camera 'omni'", "RIG.yaml")
      ->group(input);
  add("--ring",
      params->ring,
      "Where the ring is, measured by hand: nothing is looked for",
      "U,V,INNER,OUTER")
      ->group(input);
  add("-o,--output",
      params->output,
      "The rig with the mirror as measured, all else as it was",
      "RIG.yaml")
      ->group(result);
  add("--panorama", params->panorama, "The first image unwrapped", "FILE.png")->group(result);
  add("--report",
      params->report,
      "New folder for the image with circles and what they go through, a panorama, tables",
      "DIR")
      ->group(result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunCalibrateMirror(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
