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
#include "app/recordings/bag_options.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/images.hpp"
#include "app/recordings/panorama_source.hpp"
#include "app/recordings/rig_warnings.hpp"
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
  recordings::BagOptions bags;
  fs::path panorama;
  fs::path report;
  fs::path output;

  // Checks everything that can be checked without the recording. @throws InputError
  void Check(files::Existing existing) const;
};

void CalibrateMirrorOptions::Check(files::Existing existing) const {
  if (!output.empty() && rig.empty()) {
    throw InputError(
        "calibrate mirror: -o writes a rig with the mirror added; give the existing rig by --rig");
  }
  if (!panorama.empty() && panorama.extension() != ".png") {
    throw InputError(fmt::format("{}: the image's name must end in .png", panorama.string()));
  }
  files::CheckOutputFiles({output, panorama}, existing);
  if (!report.empty()) files::CheckOutputFolder(report, existing);
}

// Result of the observation: the first image, and the fit to all images.
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
  MirrorObservation observation;
  observation.image = recordings::ReadImage(file, recordings::Pixels::kColour);
  observation.images = 1;
  observation.fit = calibration::FindRing(observation.image);
  return observation;
}

MirrorObservation ObserveRecording(const CalibrateMirrorOptions& params) {
  recordings::FrameSource source(params.omni,
                                 {.pixels = recordings::Pixels::kColour,
                                  .stamps = params.stamps,
                                  .bag = params.bags.Topic("omni")});
  terminal::Progress progress("searching", "frames", source.ExpectedFrames());
  MirrorObservation observation;
  calibration::MirrorActivity activity;
  recordings::Frame frame;
  while (source.Read(frame)) {
    if (observation.image.empty()) observation.image = frame.image.clone();
    activity.Add(frame.image);
    progress.Update(++observation.images);
  }
  if (terminal::Interrupted()) throw RunError("interrupted; nothing was written");
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  observation.fit = observation.images == 1 ? calibration::FindRing(observation.image)
                                            : calibration::FindRing(activity);
  return observation;
}

void CheckFound(const CalibrateMirrorOptions& params, const MirrorObservation& observation) {
  switch (observation.fit.fault) {
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
      fmt::format("{}: no mirror with a round rim was found; light the room, or give its position: "
                  "--ring U,V,INNER,OUTER",
                  params.omni));
}

// The largest ring that lies completely inside the image, as a panorama requires.
calib::MirrorRing InsideImage(calib::MirrorRing ring, cv::Size size) {
  const Eigen::Vector2d far(size.width - 1, size.height - 1);
  const double room = std::min(ring.centre_px.minCoeff(), (far - ring.centre_px).minCoeff());
  ring.outer_radius_px = std::min(ring.outer_radius_px, std::floor(10 * room) / 10);
  return ring;
}

reports::ReportTable RingTable(const MirrorObservation& observation) {
  const MirrorRingFit& fit = observation.fit;
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

void Summarize(const MirrorObservation& observation, terminal::Summary& summary) {
  const MirrorRingFit& fit = observation.fit;
  summary.frames = observation.images;
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
      {"rim_ratio", fit.rim_ratio},
      {"rim_sigma_px", fit.rim_sigma_px}};
}

cv::Mat Panorama(const MirrorObservation& observation) {
  const calib::MirrorRing ring = InsideImage(observation.fit.ring, observation.image.size());
  calib::MirrorViewParams params;
  params.rows = std::max(1, static_cast<int>(ring.outer_radius_px - ring.inner_radius_px));
  const double middle = 0.5 * (ring.outer_radius_px + ring.inner_radius_px);
  params.columns = std::clamp(static_cast<int>(2 * std::numbers::pi * middle), 8, 16384);
  const calib::MirrorView view(observation.image.size(), ring, params);
  cv::Mat panorama;
  view.Unwrap(observation.image, panorama);
  return panorama;
}

cv::Mat Overlay(const MirrorObservation& observation) {
  constexpr int kShift = 4;  // sub-pixel drawing
  const auto fixed = [](double v) { return static_cast<int>(std::lround(v * (1 << kShift))); };
  cv::Mat image = observation.image.clone();
  if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  const auto dots = [&](const std::vector<Eigen::Vector2d>& points, const cv::Scalar& colour) {
    for (const Eigen::Vector2d& p : points) {
      cv::circle(image, {fixed(p.x()), fixed(p.y())}, fixed(1.5), colour, -1, cv::LINE_AA, kShift);
    }
  };
  const cv::Scalar orange(0, 94, 213);
  const cv::Scalar green(115, 158, 0);
  dots(observation.fit.rim, orange);
  dots(observation.fit.body, orange);
  const calib::MirrorRing& ring = observation.fit.ring;
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
                       const MirrorObservation& observation,
                       terminal::Summary& summary) {
  using Handler = nlohmann::ordered_json::error_handler_t;
  const std::vector<reports::ReportTable> tables{RingTable(observation)};
  const auto files = reports::WriteReport(
      folder,
      {{"metrics.json", summary.quality.dump(2, ' ', false, Handler::replace) + "\n"},
       {"tables.md", reports::FormatMarkdown(tables)},
       {"tables.tex", reports::FormatLatex(tables)}});
  summary.files.insert(summary.files.end(), files.begin(), files.end());
  WriteImage(folder / "mirror.png", Overlay(observation), summary);
  WriteImage(folder / "panorama.png", Panorama(observation), summary);
}

void WriteRig(const CalibrateMirrorOptions& params,
              const MirrorObservation& observation,
              terminal::Summary& summary) {
  const std::string text = ReadSettingsText(params.rig, "a rig file (format: calib/README.md)");
  recordings::PrintRigWarnings(calib::ParseRig(text, params.rig));
  calib::RigValues values;
  values.omni = {InsideImage(observation.fit.ring, observation.image.size()),
                 observation.image.cols,
                 observation.image.rows};
  const std::string changed = calib::ChangeRig(text, params.rig, values, params.output);
  calib::ParseRig(changed, params.output);
  files::WriteFileAtomically(params.output, changed);
  summary.files.push_back(params.output);
}

void PrintReport(const MirrorObservation& observation, const terminal::Summary& summary) {
  const MirrorRingFit& fit = observation.fit;
  fmt::print("{}", reports::FormatPlain(RingTable(observation)));
  fmt::print("rim visible in {:.0f} % of all directions, sigma {:.2f} px\n",
             100 * std::min(1.0, fit.rim_ratio),
             fit.rim_sigma_px);
  if (fit.body_seen && !fit.round_body && observation.images > 1) {
    fmt::print("the inner circle excludes the whole robot, which is not round\n");
  }
  fmt::print("ceilmap heading --ring {:.2f},{:.2f},{:.2f},{:.2f}\n",
             fit.ring.centre_px.x(),
             fit.ring.centre_px.y(),
             fit.ring.inner_radius_px,
             InsideImage(fit.ring, observation.image.size()).outer_radius_px);
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

void RunCalibrateMirror(const CalibrateMirrorOptions& params,
                        const CommonOptions& common,
                        terminal::Summary& summary) {
  params.bags.CheckMain("omni", params.omni);
  params.Check(common.Existing());
  std::optional<calib::MirrorRing> by_hand;
  if (!params.ring.empty()) by_hand = recordings::ParseRing(params.ring, "--ring");
  MirrorObservation observation =
      IsImage(params.omni) ? ObserveImage(params.omni) : ObserveRecording(params);
  if (by_hand) {
    observation.fit = {};
    observation.fit.ring = *by_hand;
  }
  CheckFound(params, observation);
  Summarize(observation, summary);
  if (!observation.fit.body_seen && !by_hand) {
    terminal::Warn(
        "{}: no static content in the middle of the mirror; its inner radius is only an estimate",
        params.omni);
  }
  if (!params.output.empty()) WriteRig(params, observation, summary);
  if (!params.panorama.empty()) WriteImage(params.panorama, Panorama(observation), summary);
  if (!params.report.empty()) WriteMirrorReport(params.report, observation, summary);
  if (!common.quiet) PrintReport(observation, summary);
}

}  // namespace

Command AddCalibrateMirrorCommand(CLI::App& calibrate) {
  Command command = MakeCommand(
      calibrate,
      "mirror",
      "Measures the position of a convex mirror in the images of the camera below it, from a "
      "recording of a turning robot.",
      "ceilmap calibrate mirror --omni turn.mp4 --rig rig.yaml -o new.yaml --report mirror\n"
      "  ceilmap calibrate mirror --omni image.jpg --panorama panorama.png\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<CalibrateMirrorOptions>();
  CLI::App& cli = *command.cli;
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  const std::string input = "Input";
  const std::string result = "Results";
  add("--omni",
      params->omni,
      "The mirror while the robot turns or drives; or a single image, "
      "with less accuracy",
      "SOURCE")
      ->required()
      ->group(input);
  add("--stamps", params->stamps, "Not needed; checked when given", "FRAMES.csv")->group(input);
  add("--rig", params->rig, "The existing rig, with or without a camera 'omni'", "RIG.yaml")
      ->group(input);
  add("--ring",
      params->ring,
      "Position of the ring, measured by hand; no search",
      "U,V,INNER,OUTER")
      ->group(input);
  add("-o,--output",
      params->output,
      "The rig with the measured mirror, otherwise unchanged",
      "RIG.yaml")
      ->group(result);
  add("--panorama", params->panorama, "The first image unwrapped", "FILE.png")->group(result);
  add("--report",
      params->report,
      "New folder for the image with circles and edge points, a panorama, tables",
      "DIR")
      ->group(result);
  params->bags.AddTo(cli, {"omni"});
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunCalibrateMirror(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
