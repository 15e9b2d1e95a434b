#include "app/reports/rig_check_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/terminal/table.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using mount::Checked;
using mount::DriveCheck;

constexpr const char* kMoreTurns = "drive with more turns";
constexpr const char* kCalibrateCamera = "run 'ceilmap calibrate camera'";
constexpr const char* kCalibrateRig = "run 'ceilmap calibrate rig'";

// A value in the unit of the table.
struct Unit {
  const char* name;
  double factor = 1;
  int digits = 2;
};
constexpr Unit kPixels{"px", 1, 2};
constexpr Unit kDegrees{"deg", kDegPerRad, 3};
constexpr Unit kMilliseconds{"ms", 1000, 1};
constexpr Unit kMetres{"m", 1, 4};

std::string SeenText(const Checked& checked, const Unit& unit) {
  return fmt::format("{:.{}f} +- {:.{}f}",
                     unit.factor * checked.seen.value,
                     unit.digits,
                     unit.factor * checked.seen.sigma,
                     unit.digits);
}

CheckedProperty Row(const char* key, const char* name, const Checked& checked, const Unit& unit) {
  CheckedProperty row{key,
                      name,
                      fmt::format("{:.{}f}", unit.factor * checked.stated, unit.digits),
                      SeenText(checked, unit),
                      unit.name,
                      "",
                      ""};
  if (!checked.IsWrong() && !checked.IsDetermined()) row.unchecked = kMoreTurns;
  return row;
}

CheckedProperty Unchecked(const char* key, const char* name, const std::string& why) {
  return {key, name, "", "", "", why, ""};
}

std::string SizeText(cv::Size size) {
  return fmt::format("{}x{}", size.width, size.height);
}

CheckedProperty SizeRow(const RigCheck& check) {
  const cv::Size stated = check.rig.up->camera.Size();
  CheckedProperty row{
      "image_size", "image size", SizeText(stated), SizeText(check.size), "px", "", ""};
  if (stated == check.size) return row;
  row.complaint = fmt::format(
      "the images have {} px, camera 'up' of the rig {}: use the rig of this camera, record in "
      "that "
      "size, or {} on images of this size",
      SizeText(check.size),
      SizeText(stated),
      kCalibrateCamera);
  return row;
}

bool LensIsWrong(const DriveCheck& drive) {
  return drive.lens_px.IsWrong() && !drive.focal_explains_lens;
}

CheckedProperty FollowedRow(const RigCheck& check) {
  CheckedProperty row{"followed",
                      "frames followed",
                      fmt::format("{}", check.frames),
                      fmt::format("{}", check.frames - check.lost),
                      "",
                      "",
                      ""};
  if (check.TooManyLost()) row.unchecked = "too many frames are lost to check the rest";
  return row;
}

CheckedProperty FocalRow(const DriveCheck& drive) {
  const Checked& focal = drive.focal_px_seen;
  if (!focal.IsWrong() && !focal.IsDetermined()) {
    return Unchecked(
        "focal_px", "focal length", "this lens does not show it; it is part of the scale below");
  }
  CheckedProperty row = Row("focal_px", "focal length", focal, kPixels);
  if (!focal.IsWrong()) return row;
  const double percent = -100 * focal.Difference() / focal.seen.value;
  row.complaint =
      fmt::format("the focal length looks {:.1f} % too {} ({:.1f} px in the rig, {} seen): {}",
                  std::abs(percent),
                  percent > 0 ? "long" : "short",
                  focal.stated,
                  SeenText(focal, {"", 1, 1}),
                  kCalibrateCamera);
  return row;
}

CheckedProperty LensRow(const RigCheck& check) {
  const DriveCheck& drive = *check.drive;
  CheckedProperty row = Row("lens_px", "lens, towards the edge", drive.lens_px, kPixels);
  if (!LensIsWrong(drive)) return row;
  const double out = drive.lens_px.seen.value;
  row.complaint = fmt::format(
      "the lens model does not fit ({}): points {:.0f} px from the centre appear {:.1f} +- {:.1f} "
      "px "
      "too far {}; are model and coefficients those of this camera? {}",
      calib::RosName(check.rig.up->camera.model),
      drive.lens_radius_px,
      std::abs(out),
      drive.lens_px.seen.sigma,
      out > 0 ? "in" : "out",
      kCalibrateCamera);
  return row;
}

std::vector<CheckedProperty> TiltRows(const DriveCheck& drive) {
  CheckedProperty pitch = Row("pitch_deg", "pitch", drive.pitch_rad, kDegrees);
  CheckedProperty roll = Row("roll_deg", "roll", drive.roll_rad, kDegrees);
  if (drive.pitch_rad.IsWrong() || drive.roll_rad.IsWrong()) {
    CheckedProperty& row = drive.pitch_rad.IsWrong() ? pitch : roll;
    row.complaint = fmt::format(
        "the camera looks tilted by {:.2f} deg from the rig (pitch {} instead of {} deg, roll {} "
        "instead of {}), or its principal point is wrong: {}",
        kDegPerRad * std::hypot(drive.pitch_rad.Difference(), drive.roll_rad.Difference()),
        pitch.seen,
        pitch.stated,
        roll.seen,
        roll.stated,
        kCalibrateRig);
  }
  return {pitch, roll};
}

CheckedProperty YawRow(const DriveCheck& drive) {
  if (!drive.yaw_rad) {
    return Unchecked("yaw_deg", "yaw", "the robot also drives sideways, or too little");
  }
  const Checked& yaw = *drive.yaw_rad;
  CheckedProperty row = Row("yaw_deg", "yaw", yaw, kDegrees);
  if (!yaw.IsWrong()) return row;
  const double off_deg = kDegPerRad * yaw.Difference();
  constexpr double kTurnedDeg = 45;
  constexpr double kOppositeDeg = 135;
  const char* how = "";
  if (std::abs(off_deg) > kOppositeDeg) {
    how = ", rotated by half a turn (or the robot drove backwards)";
  } else if (std::abs(off_deg) > kTurnedDeg) {
    how = ", rotated by a quarter turn";
  }
  row.complaint =
      fmt::format("the yaw of the camera is wrong by {:.1f} deg{} ({} deg in the rig, {} seen): {}",
                  off_deg,
                  how,
                  row.stated,
                  row.seen,
                  kCalibrateRig);
  return row;
}

CheckedProperty ReadoutRow(const RigCheck& check) {
  const DriveCheck& drive = *check.drive;
  if (!check.has_stamps) return Unchecked("readout_ms", "read-out time", "needs --stamps");
  CheckedProperty row = Row("readout_ms", "read-out time", drive.readout_s, kMilliseconds);
  if (!drive.readout_s.IsWrong()) return row;
  row.complaint = fmt::format(
      "the read-out time looks like {} ms, the rig has {}: {}, or write readout_time_s: {:.4f}",
      row.seen,
      row.stated,
      kCalibrateRig,
      drive.readout_s.seen.value);
  return row;
}

// What an error of the scale may come from.
std::string ScaleCause(const DriveCheck& drive, double percent) {
  const Checked& focal = drive.focal_px_seen;
  constexpr double kSigmas = 4;  // an error of less than the limit would show
  const bool focal_known = !focal.IsWrong() && kSigmas * focal.seen.sigma < focal.limit;
  return fmt::format("h or the camera's height{} is wrong by {:.1f} %",
                     focal_known ? "" : ", or the focal length,",
                     std::abs(percent));
}

constexpr const char* kNoPlane =
    "no surface stands out as the ceiling; drive under a part of it that is plane";
constexpr const char* kOtherTime = "the odometry does not cover the drive, or it turns too little";

CheckedProperty DistanceRow(const RigCheck& check) {
  const DriveCheck& drive = *check.drive;
  constexpr const char* kKey = "distance_m";
  constexpr const char* kName = "ceiling above camera";
  if (!drive.distance_m) {
    return Unchecked(
        kKey, kName, check.has_odometry ? kOtherTime : "needs --odometry or --distance");
  }
  const Checked& distance = *drive.distance_m;
  CheckedProperty row = Row(kKey, kName, distance, kMetres);
  if (!row.unchecked.empty() && !drive.shows_plane) row.unchecked = kNoPlane;
  if (!distance.IsWrong()) return row;
  row.complaint = fmt::format(
      "the ceiling looks {} m above the camera, {} by the rig: {}; measure them again, "
      "or {}",
      row.seen,
      row.stated,
      ScaleCause(drive, 100 * distance.Difference() / distance.stated),
      kCalibrateRig);
  return row;
}

CheckedProperty AxleRow(const DriveCheck& drive) {
  constexpr const char* kKey = "axle_m";
  constexpr const char* kName = "camera ahead of axle";
  if (!drive.axle_m) return Unchecked(kKey, kName, "the robot also drives sideways, or too little");
  const Checked& axle = *drive.axle_m;
  CheckedProperty row = Row(kKey, kName, axle, kMetres);
  if (!row.unchecked.empty() && !drive.shows_plane) row.unchecked = kNoPlane;
  if (!axle.IsWrong()) return row;
  constexpr double kMinM = 0.05;
  const std::string by = std::abs(axle.stated) < kMinM || drive.distance_m
                             ? ""
                             : ", or " + ScaleCause(drive, 100 * axle.Difference() / axle.stated) +
                                   " (--distance or --odometry shows which)";
  row.complaint = fmt::format(
      "the camera looks {} m ahead of the axle, a + x of the rig is {}: a is wrong{}; {}",
      row.seen,
      row.stated,
      by,
      kCalibrateRig);
  return row;
}

CheckedProperty MirrorRow(const RigCheck& check) {
  const DriveCheck& drive = *check.drive;
  constexpr const char* kName = "mirrored";
  CheckedProperty row{kName, kName, "no", "no", "", "", ""};
  if (drive.leans_mirrored && drive.mirrored.value_or(true)) {
    row.seen = "yes";
    row.complaint =
        "the images are mirrored: the camera leans to the other side than by the rig; switch off "
        "the "
        "flip of the camera's driver";
  } else if (!drive.mirrored) {
    return Unchecked(
        kName, kName, check.has_odometry ? kOtherTime : "needs --first-turn or --odometry");
  } else if (*drive.mirrored) {
    row.seen = "yes";
    row.complaint =
        "the images are mirrored: the robot turns left where they show a turn to the right; switch "
        "off the flip of the camera's driver";
  }
  return row;
}

CheckedProperty StampsRow(const RigCheck& check) {
  const DriveCheck& drive = *check.drive;
  constexpr const char* kKey = "stamps_late_ms";
  constexpr const char* kName = "stamps late by";
  if (!drive.late_s) {
    return Unchecked(kKey, kName, check.has_odometry ? kOtherTime : "needs --odometry");
  }
  CheckedProperty row = Row(kKey, kName, *drive.late_s, kMilliseconds);
  if (!drive.late_s->IsWrong()) return row;
  const double late_ms = 1000 * drive.late_s->seen.value;
  row.complaint = fmt::format(
      "the stamps of the images are {:.0f} +- {:.0f} ms too {} relative to the odometry: a stamp "
      "is "
      "the middle of the exposure, by the same clock",
      std::abs(late_ms),
      1000 * drive.late_s->seen.sigma,
      late_ms > 0 ? "late" : "early");
  return row;
}

}  // namespace

bool RigCheck::TooManyLost() const {
  constexpr double kMaxLost = 0.2;
  return static_cast<double>(lost) > kMaxLost * static_cast<double>(frames);
}

std::vector<CheckedProperty> CheckedProperties(const RigCheck& check) {
  std::vector<CheckedProperty> rows{SizeRow(check)};
  if (check.frames > 0) rows.push_back(FollowedRow(check));
  if (!check.drive) return rows;
  const DriveCheck& drive = *check.drive;
  // The values below are no longer those of this camera, or of this robot.
  if (LensIsWrong(drive)) {
    rows.push_back(LensRow(check));
    return rows;
  }
  if (check.TooManyLost()) return rows;
  rows.push_back(MirrorRow(check));
  rows.push_back(LensRow(check));
  rows.push_back(FocalRow(drive));
  if (drive.mirrored.value_or(drive.leans_mirrored)) return rows;
  for (const CheckedProperty& row : TiltRows(drive)) rows.push_back(row);
  rows.push_back(YawRow(drive));
  rows.push_back(AxleRow(drive));
  rows.push_back(DistanceRow(check));
  rows.push_back(ReadoutRow(check));
  rows.push_back(StampsRow(check));
  return rows;
}

void Summarize(const RigCheck& check, terminal::Summary& summary) {
  nlohmann::ordered_json properties = nlohmann::ordered_json::object();
  nlohmann::ordered_json complaints = nlohmann::ordered_json::array();
  for (const CheckedProperty& row : CheckedProperties(check)) {
    properties[row.key] = {{"rig", row.stated}, {"seen", row.seen}, {"unchecked", row.unchecked}};
    if (!row.complaint.empty()) complaints.push_back(row.complaint);
  }
  summary.frames = check.frames;
  summary.quality = {{"complaints", complaints}, {"properties", properties}};
  if (check.drive) {
    summary.quality["sigma_px"] = check.drive->camera.sigma_px;
    summary.quality["depth_ratio"] = check.drive->camera.depth_ratio;
    summary.quality["places"] = check.drive->camera.places;
    summary.quality["inliers"] = check.drive->camera.inliers;
  }
}

void PrintReport(const RigCheck& check, bool quiet, double seconds) {
  const std::vector<CheckedProperty> rows = CheckedProperties(check);
  if (!quiet) {
    terminal::Table table;
    table.AddRow({"", "rig", "seen", "unit", ""});
    for (const CheckedProperty& row : rows) {
      std::string verdict = "agrees";
      if (!row.unchecked.empty()) verdict = "not checked: " + row.unchecked;
      if (!row.complaint.empty()) verdict = "WRONG";
      table.AddRow({row.name, row.stated, row.seen, row.unit, verdict});
    }
    fmt::print("{}", table.Format());
    if (check.drive) {
      fmt::print(
          "{} of {} places in {} views agree, residual {:.3f} px, depth {:.1f} %; {:.1f} s\n",
          check.drive->camera.inliers,
          check.drive->camera.places,
          check.drive->camera.cameras.size(),
          check.drive->camera.sigma_px,
          100 * check.drive->camera.depth_ratio,
          seconds);
    }
  }
  for (const CheckedProperty& row : rows) {
    if (!row.complaint.empty()) fmt::print("{}\n", row.complaint);
  }
}

}  // namespace ceilmap::reports
