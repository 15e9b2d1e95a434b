#include "app/commands/calibrate_rig_options.hpp"

#include <fmt/format.h>

#include "app/files/output_files.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

void CheckPositive(const char* option, const std::optional<double>& value) {
  if (!value || (*value > 0 && *value < 1e4)) return;
  throw InputError(fmt::format("{} {}: must be > 0, in metres", option, *value));
}

}  // namespace

void CalibrateRigOptions::Check(files::Existing existing) const {
  if (rig.empty() == camera.empty()) {
    throw InputError(
        "calibrate rig: give either --rig RIG.yaml, or --camera CAMERA_INFO.yaml for a rig that "
        "does not exist yet");
  }
  if (!tape.ceiling_height_m && !tape.distance_m) {
    throw InputError(
        "calibrate rig: give --ceiling-height, or --distance of the straight drive; without a tape "
        "measure there is no scale");
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
  files::CheckOutputFiles({output}, existing);
  if (!report.empty()) files::CheckOutputFolder(report, existing);
}

void CalibrateRigOptions::TakeBags() {
  const auto take = [this](const char* option,
                           const std::string& up,
                           std::string& forward,
                           std::filesystem::path& odometry,
                           std::filesystem::path& gyro) {
    bags.CheckMain("up", up);
    forward = bags.Complete("forward", forward, option, up);
    odometry = bags.Complete("odometry", odometry.string(), option, up);
    gyro = bags.Complete("gyro", gyro.string(), option, up);
  };
  take("spin", spin, spin_forward, spin_odometry, spin_gyro);
  take("straight", straight, straight_forward, straight_odometry, straight_gyro);
}

void CalibrateRigOptions::AddInput(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Input");
  };
  add("--rig",
      rig,
      "The initial rig: the upward camera's intrinsics, and its height (z of its pose). h, a and "
      "the rest of the pose may be left out; given values are initial values, and x of the "
      "camera's pose is not changed",
      "RIG.yaml");
  add("--camera",
      camera,
      "Instead of a rig: the upward camera's camera_info, for a rig with this camera only",
      "CAMERA_INFO.yaml");
  add("--spin", spin, "The upward camera while the robot turns on the spot, once around", "SOURCE")
      ->required();
  add("--straight", straight, "The upward camera while the robot drives straight ahead", "SOURCE")
      ->required();
  add("--spin-stamps",
      spin_stamps,
      "Time of each frame, for both cameras. Needed for two cameras, and for the read-out time of "
      "a "
      "rolling shutter where the recording itself has no times",
      "FRAMES.csv");
  add("--straight-stamps", straight_stamps, "As --spin-stamps", "FRAMES.csv");
}

void CalibrateRigOptions::AddForward(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Forward camera");
  };
  add("--spin-forward",
      spin_forward,
      "The forward camera during the spin: for its pitch and roll. The rig must "
      "contain its intrinsics, its position, and its direction to 10 deg",
      "SOURCE");
  add("--straight-forward",
      straight_forward,
      "The forward camera during the straight drive: for its pitch and yaw",
      "SOURCE");
}

void CalibrateRigOptions::AddWheels(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Wheels and gyro");
  };
  add("--spin-odometry",
      spin_odometry,
      "Wheel odometry of the spin, for the track width: TUM, or CSV timestamp,x,y,yaw_deg or "
      "timestamp,v,omega",
      "WHEELS");
  add("--straight-odometry",
      straight_odometry,
      "Of the straight drive, for the scale of the wheels",
      "WHEELS");
  add("--spin-gyro", spin_gyro, "Turn rates of the spin: timestamp,omega_z", "GYRO.csv");
  add("--straight-gyro", straight_gyro, "Turn rates of the straight drive", "GYRO.csv");
}

bool CalibrateRigOptions::HasWheels() const {
  return !spin_odometry.empty() || !straight_odometry.empty() || !spin_gyro.empty() ||
         !straight_gyro.empty();
}

void CalibrateRigOptions::AddTape(CLI::App& cli) {
  const auto add = [&cli](const char* name, auto& value, const char* text) {
    return cli.add_option(name, value, text)->type_name("M")->group("Tape measure");
  };
  add("--ceiling-height", tape.ceiling_height_m, "Height of the ceiling above the floor");
  add("--distance",
      tape.distance_m,
      "Distance from the robot's position in the first frame of the straight drive to that in the "
      "last; together with --ceiling-height it gives the camera's height");
  add("--camera-height", camera_height_m, "Height of the camera above the floor [as in the rig]");
  add("--tape-sigma", tape.sigma_m, "Standard deviation of these lengths [0.001]");
}

void CalibrateRigOptions::AddTo(CLI::App& cli) {
  AddInput(cli);
  AddTape(cli);
  AddForward(cli);
  AddWheels(cli);
  bags.AddTo(cli, {"up", "forward", "odometry", "gyro"});
  cli.add_option(
         "--lens-sigma",
         lens_sigma_px,
         "Error of a point at the image's edge by the intrinsics, for the "
         "standard deviations; 'calibrate camera' reports it as the error of the corners [0.05]")
      ->type_name("PX")
      ->group("Input");
  cli.add_option("--report",
                 report,
                 "New folder for figures of the fit, the mean image of the spin with the initial "
                 "and with the measured rig, and tables")
      ->type_name("DIR")
      ->group("Results");
  cli.add_option("-o,--output",
                 output,
                 "The rig with the measured a, h, pose and read-out time of the upward camera, and "
                 "constants of wheels and gyro; otherwise unchanged")
      ->required()
      ->type_name("RIG.yaml")
      ->group("Results");
}

}  // namespace ceilmap::commands
