#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "app/commands/calibrate_commands.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/bag_motion.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/bag_rig.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/rig_recording.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/reports/rig_check_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/stamped_pose.hpp"
#include "compensation/mount/drive_check.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct CalibrateCheckOptions {
  fs::path rig;
  std::string up;
  fs::path stamps;
  fs::path odometry;
  recordings::BagOptions bags;
  std::optional<double> distance_m;
  std::string first_turn;
  double seconds = 60;
};

void Check(const CalibrateCheckOptions& params) {
  if (params.distance_m && (*params.distance_m <= 0 || *params.distance_m > 1e4)) {
    throw InputError(fmt::format("--distance {}: must be > 0, in metres", *params.distance_m));
  }
  if (params.seconds <= 0) {
    throw InputError(fmt::format("--seconds {}: must be > 0", params.seconds));
  }
}

std::vector<StampedPose> PosesOf(const files::OdometryRecording& odometry,
                                 const std::string& name) {
  if (odometry.poses.empty()) {
    throw InputError(fmt::format("{}: its odometry has speeds only, must have poses", name));
  }
  std::vector<StampedPose> poses;
  poses.reserve(odometry.poses.size());
  for (const wheels::OdometrySample& sample : odometry.poses) {
    poses.push_back(ToStampedPose(sample.stamp_s, sample.T_odom_base));
  }
  return poses;
}

mount::DriveKnowledge KnowledgeOf(const CalibrateCheckOptions& params) {
  mount::DriveKnowledge knowledge;
  if (!params.odometry.empty()) {
    knowledge.odometry =
        recordings::IsBag(params.odometry.string())
            ? PosesOf(recordings::ReadBagOdometry(params.odometry.string(),
                                                  params.bags.TopicAlone("odometry")),
                      params.odometry.string())
            : files::ReadTum(params.odometry);
  }
  knowledge.distance_m = params.distance_m;
  if (params.first_turn == "left") knowledge.first_turn = mount::TurnDirection::kLeft;
  if (params.first_turn == "right") knowledge.first_turn = mount::TurnDirection::kRight;
  return knowledge;
}

// A drive that says little of the rig is no result.
void CheckTurns(const reports::RigCheck& check) {
  constexpr double kMinTurnDeg = 45;
  if (!check.drive || check.drive->turn_rad >= kMinTurnDeg * kRadPerDeg) return;
  throw InputError(
      fmt::format("{}: the robot turns by {:.0f} deg only, must be at least {:.0f}; drive straight "
                  "ahead, turn, and drive straight ahead again",
                  check.source,
                  check.drive->turn_rad * kDegPerRad,
                  kMinTurnDeg));
}

void RunCalibrateCheck(CalibrateCheckOptions params,
                       const CommonOptions& common,
                       terminal::Summary& out) {
  const auto start = std::chrono::steady_clock::now();
  params.bags.CheckMain("up", params.up);
  params.odometry = params.bags.Complete("odometry", params.odometry.string(), "up", params.up);
  Check(params);
  const mount::DriveKnowledge knowledge = KnowledgeOf(params);
  reports::RigCheck check;
  check.rig = calib::ReadRig(params.rig);
  if (!check.rig.up) {
    throw InputError(fmt::format("{}: has no upward camera (cameras: up)", params.rig.string()));
  }
  recordings::PrintRigWarnings(check.rig);
  recordings::FrameSource source(params.up,
                                 {.stamps = params.stamps, .bag = params.bags.Topic("up")});
  check.source = source.Name();
  check.has_stamps = source.Stamps() != recordings::StampOrigin::kFrameIndex;
  check.has_odometry = !knowledge.odometry.empty();
  check.size = source.Size();
  recordings::PrintCameraDifference(
      params.up, params.bags.Topic("up"), "up", *check.rig.up, check.rig);
  // The intrinsics are those of one size.
  if (check.size == check.rig.up->camera.Size()) {
    const calib::CeilingView view(*check.rig.up, check.rig.ceiling_height_m);
    const recordings::FollowedDrive drive = recordings::FollowDrive(source, view, params.seconds);
    check.frames = drive.frames;
    check.lost = drive.lost;
    if (!drive.parts.empty()) check.drive = mount::CheckDrive(check.rig, drive.parts, knowledge);
    CheckTurns(check);
  }
  out.interrupted = terminal::Interrupted();
  reports::Summarize(check, out);
  reports::PrintReport(check, common.quiet, terminal::SecondsSince(start));
  const auto rows = reports::CheckedProperties(check);
  const auto complaints = std::count_if(
      rows.begin(), rows.end(), [](const auto& row) { return !row.complaint.empty(); });
  if (complaints > 0) {
    out.failure = fmt::format("{}: does not agree with {}", params.rig.string(), check.source);
  } else if (!check.drive || check.TooManyLost()) {
    out.failure = fmt::format(
        "{}: {} of {} frames do not match those before them; drive more slowly, under a ceiling "
        "with "
        "texture, with the lights on. If the images are good, the rig is that of another camera",
        check.source,
        check.lost,
        check.frames);
  }
}

}  // namespace

Command AddCalibrateCheckCommand(CLI::App& calibrate) {
  Command command = MakeCommand(
      calibrate,
      "check",
      "Compares a rig with what the upward camera shows during some 20 seconds of ordinary "
      "driving, "
      "straight ahead and in turns: size, lens, mounting, scale, read-out time, stamps.",
      "ceilmap calibrate check --rig rig.yaml --up drive.mp4 --stamps frames.csv\n"
      "  ceilmap calibrate check --rig rig.yaml --up drive.mp4 --stamps frames.csv --odometry "
      "wheels.tum\n"
      "  ceilmap calibrate check --rig rig.yaml --up drive.mcap --odometry-topic /odom\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<CalibrateCheckOptions>();
  CLI::App& cli = *command.cli;
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Input");
  };
  add("--rig", params->rig, "The rig to check", "RIG.yaml")->required();
  add("--up", params->up, "The upward camera during the drive", "SOURCE")->required();
  add("--stamps", params->stamps, "Time of each frame: index,timestamp", "FRAMES.csv");
  add("--seconds", params->seconds, "Use the beginning of the recording only", "S")
      ->capture_default_str();
  add("--odometry",
      params->odometry,
      "The drive as the wheels measured it: checks the ceiling's height, the stamps, and whether "
      "the images are mirrored",
      "WHEELS.tum");
  add("--distance",
      params->distance_m,
      "Distance in a straight line from the robot's position in the first frame to that in the "
      "last that is used, by a tape measure: checks the ceiling's height",
      "M");
  add("--first-turn",
      params->first_turn,
      "Direction of the robot's first turn, left or right: checks whether the images are mirrored",
      "SIDE")
      ->check(CLI::IsMember({"left", "right"}));
  params->bags.AddTo(cli, {"up", "odometry"});
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunCalibrateCheck(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
