#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "app/calibrate_commands.hpp"
#include "app/clock.hpp"
#include "app/console.hpp"
#include "app/frame_source.hpp"
#include "app/interrupt.hpp"
#include "app/output_files.hpp"
#include "app/report_folder.hpp"
#include "app/rig_calibration.hpp"
#include "app/rig_calibration_report.hpp"
#include "app/robot_rig.hpp"
#include "calib/error.hpp"
#include "calib/rig_text.hpp"
#include "calib/yaml_value.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using std::chrono::steady_clock;

struct CalibrateRigParams {
  fs::path rig;
  fs::path camera;
  std::string spin;
  fs::path spin_stamps;
  std::string straight;
  fs::path straight_stamps;
  std::optional<double> camera_height_m;
  TapeMeasures tape;
  double lens_sigma_px = calibration::RigSolverParams{}.lens_sigma_px;
  fs::path output;
  fs::path report;

  // Checks everything that can be told without the recordings. @throws calib::InputError
  void Check() const;
};

void CheckPositive(const char* option, const std::optional<double>& value) {
  if (!value || (*value > 0 && *value < 1e4)) return;
  throw calib::InputError(fmt::format("{} {}: must be > 0, in metres", option, *value));
}

void CalibrateRigParams::Check() const {
  if (rig.empty() == camera.empty()) {
    throw calib::InputError(
        "calibrate rig: give either --rig RIG.yaml, or --camera CAMERA_INFO.yaml for a rig that "
        "does not exist yet");
  }
  if (!tape.ceiling_height_m && !tape.distance_m) {
    throw calib::InputError(
        "calibrate rig: give --ceiling-height, or --distance of the straight drive; without a tape "
        "measure nothing has a scale");
  }
  CheckPositive("--ceiling-height", tape.ceiling_height_m);
  CheckPositive("--distance", tape.distance_m);
  CheckPositive("--camera-height", camera_height_m);
  CheckPositive("--tape-sigma", tape.sigma_m);
  CheckPositive("--lens-sigma", lens_sigma_px);
  CheckOutputFiles({output});
  if (!report.empty()) CheckReportFolder(report);
}

// The rig as far as it is known: what is missing is a camera that looks straight up from the mast,
// its top to the front, over an axle that is below it.
std::string KnownRig(const CalibrateRigParams& params) {
  const bool own = !params.rig.empty();
  const std::string text =
      own ? calib::ReadSettingsText(params.rig, "a rig file (format: calib/README.md)")
          : calib::RigOfCameraInfo(params.camera);
  constexpr double kRoughDistanceM = 2;  // only to begin with; the tape tells
  const double camera_height_m = params.camera_height_m.value_or(0);
  calib::RigValues guess;
  guess.axle_behind_mast_m = 0;
  guess.ceiling_height_m = params.tape.ceiling_height_m.value_or(camera_height_m + kRoughDistanceM);
  guess.T_base_up = Eigen::Isometry3d::Identity();
  guess.T_base_up->linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  guess.T_base_up->translation().z() = camera_height_m;
  const fs::path& file = own ? params.rig : params.camera;
  calib::RigValues pose;
  pose.T_base_up = guess.T_base_up;
  const bool height_told = params.camera_height_m || params.tape.GivesCameraHeight();
  if (!height_told && calib::CompleteRig(text, file, pose) != text) {
    throw calib::InputError(
        fmt::format("{}: tells nothing of the upward camera's height; give --camera-height, or "
                    "both --ceiling-height and --distance",
                    file.string()));
  }
  return calib::CompleteRig(text, file, guess);
}

void RunCalibrateRig(const CalibrateRigParams& params, const CommonOptions& common, Summary& out) {
  const auto start = steady_clock::now();
  params.Check();
  const fs::path& file = params.rig.empty() ? params.camera : params.rig;
  const std::string text = KnownRig(params);
  calib::Rig rig = calib::ParseRig(text, file);
  if (params.camera_height_m && rig.up) {
    rig.up->T_base_cam.translation().z() = *params.camera_height_m;
  }
  FrameSource spin_source(params.spin, {.stamps = params.spin_stamps});
  FrameSource straight_source(params.straight, {.stamps = params.straight_stamps});
  UpCameraOf(rig, file, spin_source);
  const calib::MountedCamera& up = UpCameraOf(rig, file, straight_source);
  if (params.tape.ceiling_height_m) rig.ceiling_height_m = *params.tape.ceiling_height_m;
  const calib::CeilingView view(up, rig.ceiling_height_m);
  const CeilingKeyframes spin = ReadCeiling(spin_source, view, "spin");
  const CeilingKeyframes straight = ReadCeiling(straight_source, view, "straight");
  if (Interrupted()) throw calib::RunError("interrupted; nothing was written");
  out.frames = spin.read + straight.read;
  out.stages_ms["follow"] = MillisecondsSince(start);

  const auto solving = steady_clock::now();
  const RigCalibration result =
      CalibrateRig(rig, spin, straight, params.tape, params.lens_sigma_px);
  out.stages_ms["solve"] = MillisecondsSince(solving);
  calib::RigValues values;
  values.axle_behind_mast_m = result.axle_behind_mast_m.value;
  values.ceiling_height_m = result.ceiling_height_m.value;
  values.T_base_up = result.T_base_up;
  const Eigen::Vector3d ahead_before = rig.up->T_base_cam.linear().row(0);
  constexpr double kOpposite = -0.9;  // cosine
  if (ahead_before.dot(result.T_base_up.linear().row(0)) < kOpposite) {
    Warn("{}: by the rig as it was the robot drives backwards; the straight drive counts as ahead",
         params.straight);
  }
  const std::string changed =
      RigHeader(result) + calib::ChangeRig(text, file, values, params.output);
  calib::ParseRig(changed, params.output);  // what no command would read is not written
  WriteFileAtomically(params.output, changed);
  out.files.push_back(params.output);
  Summarize(rig, result, out);
  if (!params.report.empty()) WriteRigReport(params.report, rig, result, spin, out);
  if (!common.quiet) PrintReport(rig, result, SecondsSince(start), out);
}

void AddInput(CLI::App& cli, CalibrateRigParams& params) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Input");
  };
  add("--rig",
      params.rig,
      "The rig as far as it is known: the upward camera's intrinsics, and its height (z of its "
      "pose). h, a and the rest of the pose may be left out; where they stand they are a start, "
      "and x of the camera's pose stays",
      "RIG.yaml");
  add("--camera",
      params.camera,
      "Instead of a rig: the upward camera's camera_info, for a rig with nothing else in it",
      "CAMERA_INFO.yaml");
  add("--spin",
      params.spin,
      "The upward camera while the robot turns on the spot, once around",
      "SOURCE")
      ->required();
  add("--straight", params.straight, "The same while it drives straight ahead", "SOURCE")
      ->required();
  add("--spin-stamps", params.spin_stamps, "Not needed; checked when given", "FRAMES.csv");
  add("--straight-stamps", params.straight_stamps, "Likewise", "FRAMES.csv");
}

void AddTape(CLI::App& cli, CalibrateRigParams& params) {
  const auto add = [&cli](const char* name, auto& value, const char* text) {
    return cli.add_option(name, value, text)->type_name("M")->group("Tape measure");
  };
  add("--ceiling-height", params.tape.ceiling_height_m, "Of the ceiling above the floor");
  add("--distance",
      params.tape.distance_m,
      "From where the robot stands in the first frame of the straight drive to where it stands in "
      "the last; with --ceiling-height too, the camera's height comes out");
  add("--camera-height", params.camera_height_m, "Of the camera above the floor [as in the rig]");
  add("--tape-sigma", params.tape.sigma_m, "Standard deviation of these [0.001]");
}

}  // namespace

Command AddCalibrateRigCommand(CLI::App& calibrate) {
  Command command = MakeCommand(
      calibrate,
      "rig",
      "Measures how the upward camera stands on the robot: where the robot turns, where ahead is, "
      "the camera's tilts, and the ceiling's height, from a turn on the spot and a straight drive.",
      "ceilmap calibrate rig --rig rough.yaml --spin spin.mp4 --straight straight.mp4 "
      "--ceiling-height 2.6 -o rig.yaml\n"
      "  ceilmap calibrate rig --camera up.yaml --camera-height 0.4 --spin spin.mp4 --straight "
      "straight.mp4 --distance 3.02 -o rig.yaml\n"
      "A SOURCE is a video file, a folder or printf pattern of pictures, /dev/videoN, or a URL.");
  auto params = std::make_shared<CalibrateRigParams>();
  CLI::App& cli = *command.cli;
  AddInput(cli, *params);
  AddTape(cli, *params);
  cli.add_option("--lens-sigma",
                 params->lens_sigma_px,
                 "How far off the intrinsics may put a point at the picture's edge, for the "
                 "standard deviations; "
                 "calibrate camera tells, as what corners are known to [0.05]")
      ->type_name("PX")
      ->group("Input");
  cli.add_option("--report",
                 params->report,
                 "New folder for figures of the fit, the mean picture of the spin by the rig as it "
                 "was and as measured, and tables")
      ->type_name("DIR")
      ->group("Results");
  cli.add_option("-o,--output",
                 params->output,
                 "The rig with a, h and the upward camera's pose as measured, all else as it was")
      ->required()
      ->type_name("RIG.yaml")
      ->group("Results");
  command.run = [params](const CommonOptions& common, Summary& summary) {
    RunCalibrateRig(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::app
