#include "app/commands/calibrate_rig_options.hpp"

#include <fmt/format.h>

#include "app/files/output_files.hpp"
#include "app/reports/report_folder.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

void CheckPositive(const char* option, const std::optional<double>& value) {
  if (!value || (*value > 0 && *value < 1e4)) return;
  throw InputError(fmt::format("{} {}: must be > 0, in metres", option, *value));
}

}  // namespace

void CalibrateRigOptions::Check() const {
  if (rig.empty() == camera.empty()) {
    throw InputError(
        "calibrate rig: give either --rig RIG.yaml, or --camera CAMERA_INFO.yaml for a rig that "
        "does not exist yet");
  }
  if (!tape.ceiling_height_m && !tape.distance_m) {
    throw InputError(
        "calibrate rig: give --ceiling-height, or --distance of the straight drive; without a tape "
        "measure nothing has a scale");
  }
  CheckPositive("--ceiling-height", tape.ceiling_height_m);
  CheckPositive("--distance", tape.distance_m);
  CheckPositive("--camera-height", camera_height_m);
  CheckPositive("--tape-sigma", tape.sigma_m);
  const bool forward = !spin_forward.empty() || !straight_forward.empty();
  if (forward && rig.empty()) {
    throw InputError(
        "calibrate rig: a forward camera's recordings need its intrinsics and its place; give "
        "--rig instead of --camera, with cameras: forward in it");
  }
  CheckPositive("--lens-sigma", lens_sigma_px);
  files::CheckOutputFiles({output});
  if (!report.empty()) reports::CheckReportFolder(report);
}

void CalibrateRigOptions::AddInput(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Input");
  };
  add("--rig",
      rig,
      "The rig as far as it is known: the upward camera's intrinsics, and its height (z of its "
      "pose). h, a and the rest of the pose may be left out; where they stand they are a start, "
      "and x of the camera's pose stays",
      "RIG.yaml");
  add("--camera",
      camera,
      "Instead of a rig: the upward camera's camera_info, for a rig with nothing else in it",
      "CAMERA_INFO.yaml");
  add("--spin", spin, "The upward camera while the robot turns on the spot, once around", "SOURCE")
      ->required();
  add("--straight", straight, "The same while it drives straight ahead", "SOURCE")->required();
  add("--spin-stamps",
      spin_stamps,
      "Time of each frame, of both cameras where there are two; else not needed, checked when "
      "given",
      "FRAMES.csv");
  add("--straight-stamps", straight_stamps, "Likewise", "FRAMES.csv");
}

void CalibrateRigOptions::AddForward(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Forward camera");
  };
  add("--spin-forward",
      spin_forward,
      "The forward camera during the spin: how it is turned, pitch and roll above all. The rig "
      "must "
      "have its intrinsics and its place, and its direction to 10 deg",
      "SOURCE");
  add("--straight-forward",
      straight_forward,
      "The same during the straight drive: pitch and yaw",
      "SOURCE");
}

void CalibrateRigOptions::AddTape(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text) {
    return cli.add_option(name, value, text)->type_name("M")->group("Tape measure");
  };
  add("--ceiling-height", tape.ceiling_height_m, "Of the ceiling above the floor");
  add("--distance",
      tape.distance_m,
      "From where the robot stands in the first frame of the straight drive to where it stands in "
      "the last; with --ceiling-height too, the camera's height comes out");
  add("--camera-height", camera_height_m, "Of the camera above the floor [as in the rig]");
  add("--tape-sigma", tape.sigma_m, "Standard deviation of these [0.001]");
}

void CalibrateRigOptions::AddTo(CLI::App& cli) {
  AddInput(cli);
  AddTape(cli);
  AddForward(cli);
  cli.add_option("--lens-sigma",
                 lens_sigma_px,
                 "How far off the intrinsics may put a point at the image's edge, for the "
                 "standard deviations; "
                 "calibrate camera tells, as what corners are known to [0.05]")
      ->type_name("PX")
      ->group("Input");
  cli.add_option("--report",
                 report,
                 "New folder for figures of the fit, the mean image of the spin by the rig as it "
                 "was and as measured, and tables")
      ->type_name("DIR")
      ->group("Results");
  cli.add_option("-o,--output",
                 output,
                 "The rig with a, h and the upward camera's pose as measured, all else as it was")
      ->required()
      ->type_name("RIG.yaml")
      ->group("Results");
}

}  // namespace ceilmap::commands
