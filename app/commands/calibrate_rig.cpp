#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/calibrate_commands.hpp"
#include "app/commands/calibrate_rig_options.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/rig_recording.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/recordings/synchronized_stream.hpp"
#include "app/recordings/wheel_inputs.hpp"
#include "app/reports/rig_calibration_report.hpp"
#include "app/reports/wheel_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/rig_text.hpp"
#include "calib/robot_rig.hpp"
#include "compensation/mount/forward_mount_from_motion.hpp"
#include "compensation/mount/up_mount.hpp"
#include "compensation/mount/wheel_constants.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

// The initial rig. Missing values are those of a camera at the mast that points straight up, its
// top to the front, over an axle below it.
std::string KnownRig(const CalibrateRigOptions& params) {
  const bool own = !params.rig.empty();
  const std::string text =
      own ? ReadSettingsText(params.rig, "a rig file (format: calib/README.md)")
          : calib::RigOfCameraInfo(params.camera);
  constexpr double kRoughDistanceM = 2;  // initial value; the tape measure gives the scale
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
    throw InputError(
        fmt::format("{}: does not give the upward camera's height; give --camera-height, or "
                    "both --ceiling-height and --distance",
                    file.string()));
  }
  return calib::CompleteRig(text, file, guess);
}

// The intrinsics are common to both recordings.
void CheckSameSize(const std::string& first,
                   cv::Size first_size,
                   const std::string& second,
                   cv::Size second_size) {
  if (first_size == second_size) return;
  throw InputError(
      fmt::format("{}: images are {}x{} px, those of {} {}x{}; record both in one size",
                  second,
                  second_size.width,
                  second_size.height,
                  first,
                  first_size.width,
                  first_size.height));
}

// Size of the forward images; empty when there is no forward recording. Opens the recordings before
// any work begins.
cv::Size ForwardSize(const CalibrateRigOptions& params) {
  cv::Size size;
  std::string first;
  for (const recordings::RigRecording& recording : {params.Spin(), params.Straight()}) {
    if (recording.forward.empty()) continue;
    const recordings::SynchronizedStream forward(
        recording.forward, recording.stamps, params.bags.TopicAlone("forward"));
    if (first.empty()) {
      first = recording.forward;
      size = forward.Size();
    }
    CheckSameSize(first, size, recording.forward, forward.Size());
  }
  return size;
}

// Scales the rig's cameras to the sizes of the recordings.
std::vector<calib::CameraScaling> FitRig(const CalibrateRigOptions& params,
                                         cv::Size up,
                                         cv::Size forward,
                                         calib::Rig& rig) {
  std::vector<calib::CameraScaling> scalings;
  if (auto scaling = calib::FitUpCamera(rig, params.spin, up)) scalings.push_back(*scaling);
  if (forward.empty()) return scalings;
  const std::string spin = params.Spin().forward;
  const std::string name = spin.empty() ? params.Straight().forward : spin;
  if (auto scaling = calib::FitForwardCamera(rig, name, forward)) scalings.push_back(*scaling);
  return scalings;
}

// The deviation above which an angle counts as not determined.
constexpr double kUncertainDeg = 0.5;

// Names the recordings that determine angles which these did not.
void WarnOfUncertainAngles(const mount::ForwardMount& forward) {
  const auto check = [](const char* name, const mount::Measured& angle, const char* options) {
    const double sigma_deg = kDegPerRad * angle.sigma;
    if (sigma_deg < kUncertainDeg) return;
    terminal::Warn(
        "the forward camera's {} is known to {:.1f} deg only; add {}", name, sigma_deg, options);
  };
  check("yaw", forward.yaw_rad, "--straight-forward");
  check("pitch", forward.pitch_rad, "--spin-forward or --straight-forward");
  check("roll", forward.roll_rad, "--spin-forward");
}

// Wheels and gyro need times: this is known before the recordings are read.
void CheckTimes(const CalibrateRigOptions& params,
                const recordings::FrameSource& spin,
                const recordings::FrameSource& straight) {
  const auto untimed = [](const recordings::FrameSource& source) {
    return source.Stamps() == recordings::StampOrigin::kFrameIndex;
  };
  if (!params.HasWheels() || !(untimed(spin) || untimed(straight))) return;
  throw InputError(
      "calibrate rig: wheels and gyro need the times of the images; give --spin-stamps and "
      "--straight-stamps");
}

// Says why the read-out time was not measured, where the images show one or have times.
void ReportReadout(const CalibrateRigOptions& params,
                   bool has_stamps,
                   const mount::ReadoutFinding& readout) {
  if (readout.is_determined) return;
  if (has_stamps) {
    terminal::Note(
        "the read-out time of the upward camera is known to {:.0f} ms only and remains {:.1f} ms: "
        "the robot moves too slowly by the times of the images",
        1e3 * readout.readout_time_s.sigma,
        1e3 * readout.used_s);
  } else if (readout.is_rolling) {
    terminal::Warn(
        "{}: the rows of an image are exposed one after the other (rolling shutter), but without "
        "times of the images readout_time_s cannot be measured; give --spin-stamps and "
        "--straight-stamps",
        params.spin);
  }
}

// @param rig  With the calibrated upward camera, fitted to the recordings.
// @return nothing without a recording of the forward camera.
std::optional<mount::ForwardMount> CalibrateForward(const CalibrateRigOptions& params,
                                                    const calib::Rig& rig,
                                                    const mount::UpMount& up) {
  std::vector<calibration::MotionWithMatches> motions;
  std::vector<std::string> names;
  const auto read = [&](recordings::RigRecording recording,
                        const std::vector<StampedTwist2>& velocities,
                        const char* label) {
    if (recording.forward.empty()) return;
    recording.velocities = velocities;
    const auto found = recordings::ReadForwardMatches(recording, rig, label);
    if (terminal::Interrupted()) throw RunError("interrupted; nothing was written");
    names.push_back(recording.forward);
    motions.insert(motions.end(), found.begin(), found.end());
  };
  read(params.Spin(), up.spin_velocities, "spin, forward");
  read(params.Straight(), up.straight_velocities, "straight, forward");
  if (names.empty()) return std::nullopt;
  return mount::MeasureForwardMount(
      *rig.forward, motions, up, params.lens_sigma_px, fmt::format("{}", fmt::join(names, ", ")));
}

// The samples of a recording.
mount::DriveSensors SensorsOf(const fs::path& odometry,
                              const fs::path& gyro,
                              const recordings::BagOptions& bags,
                              double axle_behind_m) {
  mount::DriveSensors sensors;
  sensors.wheels = wheels::DeadReckoning({}, axle_behind_m);
  constexpr double kAll = std::numeric_limits<double>::infinity();
  recordings::WheelInputs(odometry, {}, bags.TopicAlone("odometry"))
      .ReadTo(kAll, [&](const auto& sample) { sensors.wheels.Add(sample); });
  recordings::WheelInputs({}, gyro, {}, bags.TopicAlone("gyro"))
      .ReadTo(kAll, [&](const auto& sample) { sensors.gyro.Add(sample); });
  return sensors;
}

// A recording that contradicts the ceiling cannot be that of this drive. @param all  of the sensor.
void CheckAgreement(const fs::path& file,
                    const mount::ComparedPieces& compared,
                    const wheels::WheelsReport& all) {
  if (file.empty()) return;
  if (compared.pieces == 0) {
    throw InputError(
        fmt::format("{}: has no samples at the times of the images; do the two use the same clock?",
                    file.string()));
  }
  const bool faulty = all.fault != wheels::WheelFault::kNone;
  if (2 * compared.slips < compared.pieces && !faulty) return;
  throw InputError(fmt::format("{}: contradicts the ceiling in {} of {} pieces of the way; {}",
                               file.string(),
                               compared.slips,
                               compared.pieces,
                               reports::CauseOf(all)));
}

// @return nothing when there are no samples.
std::optional<mount::WheelConstants> CalibrateWheels(const CalibrateRigOptions& params,
                                                     const calib::Rig& rig,
                                                     const mount::UpMount& up) {
  if (!params.HasWheels()) return std::nullopt;
  const double behind_m = up.axle_behind_mast_m.value;
  const mount::WheelConstants found = mount::MeasureWheelConstants(
      up,
      SensorsOf(params.spin_odometry, params.spin_gyro, params.bags, behind_m),
      SensorsOf(params.straight_odometry, params.straight_gyro, params.bags, behind_m),
      rig.wheels.value_or(wheels::WheelModel{}));
  CheckAgreement(params.spin_odometry, found.wheels.spin, found.wheels.both);
  CheckAgreement(params.straight_odometry, found.wheels.straight, found.wheels.both);
  CheckAgreement(params.spin_gyro, found.gyro.spin, found.gyro.both);
  CheckAgreement(params.straight_gyro, found.gyro.straight, found.gyro.both);
  return found;
}

void RunCalibrateRig(CalibrateRigOptions params,
                     const CommonOptions& common,
                     terminal::Summary& out) {
  const auto start = steady_clock::now();
  params.TakeBags();
  params.Check(common.Existing());
  const fs::path& file = params.rig.empty() ? params.camera : params.rig;
  const std::string text = KnownRig(params);
  calib::Rig rig = calib::ParseRig(text, file);
  if (params.camera_height_m && rig.up) {
    rig.up->T_base_cam.translation().z() = *params.camera_height_m;
  }
  const cv::Size forward_size = ForwardSize(params);
  // Each is read alone: one after the other.
  const recordings::BagTopic up_topic = params.bags.TopicAlone("up");
  recordings::FrameSource spin_source(params.spin, {.stamps = params.spin_stamps, .bag = up_topic});
  recordings::FrameSource straight_source(params.straight,
                                          {.stamps = params.straight_stamps, .bag = up_topic});
  CheckTimes(params, spin_source, straight_source);
  const cv::Size size = spin_source.Size();
  CheckSameSize(params.spin, size, params.straight, straight_source.Size());
  const std::vector<calib::CameraScaling> scalings = FitRig(params, size, forward_size, rig);
  if (params.tape.ceiling_height_m) rig.ceiling_height_m = *params.tape.ceiling_height_m;
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  // Where the tape measure gives the camera's height, the initial value may be 0.
  if (!params.tape.GivesCameraHeight()) recordings::PrintRigWarnings(rig);
  const mount::CeilingRecording spin = recordings::ReadCeiling(spin_source, view, "spin");
  const mount::CeilingRecording straight =
      recordings::ReadCeiling(straight_source, view, "straight");
  if (terminal::Interrupted()) throw RunError("interrupted; nothing was written");
  out.frames = spin.frames + straight.frames;
  out.stages_ms["follow"] = terminal::MillisecondsSince(start);

  const auto solving = steady_clock::now();
  reports::RigFindings found;
  found.up = mount::MeasureUpMount(rig, spin, straight, params.tape, params.lens_sigma_px);
  const mount::UpMount& result = found.up;
  out.stages_ms["solve"] = terminal::MillisecondsSince(solving);
  calib::RigValues values;
  values.axle_behind_mast_m = result.axle_behind_mast_m.value;
  values.ceiling_height_m = result.ceiling_height_m.value;
  values.T_base_up = result.T_base_up;
  if (result.readout.used_s != rig.up->readout_time_s) {
    values.up_readout_time_s = result.readout.used_s;
  }
  const Eigen::Vector3d ahead_before = rig.up->T_base_cam.linear().row(0);
  constexpr double kOpposite = -0.9;  // cosine
  if (ahead_before.dot(result.T_base_up.linear().row(0)) < kOpposite) {
    terminal::Warn(
        "{}: the robot drives backwards by the given rig; the straight drive is taken as ahead",
        params.straight);
  }
  const bool has_stamps = spin.has_stamps && straight.has_stamps;
  ReportReadout(params, has_stamps, result.readout);
  found.wheels = CalibrateWheels(params, rig, result);
  if (found.wheels) values.wheels = found.wheels->model;
  const auto moving = steady_clock::now();
  calib::Rig measured = calib::ParseRig(calib::ChangeRig(text, file, values, params.output), file);
  FitRig(params, size, forward_size, measured);
  found.forward = CalibrateForward(params, measured, found.up);
  out.stages_ms["motion"] = terminal::MillisecondsSince(moving);
  if (found.forward) values.T_base_forward = found.forward->T_base_forward;
  if (found.forward) WarnOfUncertainAngles(*found.forward);
  const std::string changed =
      reports::RigHeader(found) + calib::ChangeRig(text, file, values, params.output);
  calib::ParseRig(changed, params.output);  // fails if no command could read the result
  files::WriteFileAtomically(params.output, changed);
  out.files.push_back(params.output);
  for (const calib::CameraScaling& scaling : scalings) terminal::PrintNote(scaling.Text());
  reports::Summarize(rig, found, out);
  if (!params.report.empty()) reports::WriteRigReport(params.report, rig, found, spin, out);
  if (!common.quiet) reports::PrintReport(rig, found, terminal::SecondsSince(start), out);
}

}  // namespace

Command AddCalibrateRigCommand(CLI::App& calibrate) {
  Command command = MakeCommand(
      calibrate,
      "rig",
      "Measures how the upward camera is mounted: the rotation centre, the forward direction, the "
      "camera's tilt and the ceiling's height, from a turn on the spot and a straight drive.",
      "ceilmap calibrate rig --rig rough.yaml --spin spin.mp4 --straight straight.mp4 "
      "--ceiling-height 2.6 -o rig.yaml\n"
      "  ceilmap calibrate rig --camera up.yaml --camera-height 0.4 --spin spin.mp4 --straight "
      "straight.mp4 --distance 3.02 -o rig.yaml\n"
      "  ceilmap calibrate rig --rig rough.yaml --spin spin/up.mp4 --spin-forward "
      "spin/forward.mp4 --straight straight/up.mp4 --straight-forward straight/forward.mp4 "
      "--ceiling-height 2.6 -o rig.yaml\n"
      "  ceilmap calibrate rig --rig rough.yaml --spin spin.mp4 --spin-odometry spin.csv "
      "--straight "
      "straight.mp4 --straight-odometry straight.csv --ceiling-height 2.6 -o rig.yaml\n"
      "  ceilmap calibrate rig --rig rough.yaml --spin spin.mcap --straight straight.mcap "
      "--up-topic "
      "/up/image_raw --ceiling-height 2.6 -o rig.yaml\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<CalibrateRigOptions>();
  params->AddTo(*command.cli);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunCalibrateRig(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
