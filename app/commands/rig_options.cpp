#include "app/commands/rig_options.hpp"

#include <fmt/format.h>

#include "app/recordings/bag_rig.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/nominal_rig.hpp"

namespace ceilmap::commands {
namespace {

constexpr double kMinCeilingM = 0.3;

void CheckRange(const char* option,
                const std::optional<double>& value,
                double least,
                double most,
                const char* meaning) {
  if (!value || (*value >= least && *value <= most)) return;
  throw InputError(
      fmt::format("{} {:g}: must be in {:g}..{:g}, {}", option, *value, least, most, meaning));
}

}  // namespace

void RigOptions::AddTo(CLI::App& cli, const std::string& group) {
  const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
    cli.add_option(name, value, text)->type_name(type)->group(group);
  };
  add("--rig", file, "The robot's cameras; without it the map is in pixels", "RIG.yaml");
  add("--fov",
      fov_deg,
      "Without --rig: the field of view across the width of the upward images, for a first map in "
      "metres",
      "DEG");
  cli.add_flag("--rig-from-bag",
               from_bag,
               "Without --rig: the cameras by the camera_info and /tf_static of the bag of --up; "
               "needs --ceiling-height")
      ->group(group);
  add("--ceiling-height",
      ceiling_height_m,
      "With --fov or --rig-from-bag: height of the ceiling above the floor; with --fov and without "
      "--camera-height, above the camera",
      "M");
  add("--camera-height", camera_height_m, "With --fov: height of the camera above the floor", "M");
}

void RigOptions::Check() const {
  const bool nominal = fov_deg || ceiling_height_m || camera_height_m;
  if (from_bag) {
    CheckFromBag();
    return;
  }
  if (!nominal) return;
  if (!file.empty()) {
    throw InputError(fmt::format(
        "{}: --rig gives the camera and its heights; leave one of the two out",
        fov_deg ? "--fov" : (ceiling_height_m ? "--ceiling-height" : "--camera-height")));
  }
  if (!fov_deg) {
    throw InputError(fmt::format("{}: needs --fov DEG, the field of view across the images, too",
                                 ceiling_height_m ? "--ceiling-height" : "--camera-height"));
  }
  if (!ceiling_height_m) {
    throw InputError("--fov: needs --ceiling-height M, the height of the ceiling, too");
  }
  using calib::NominalCamera;
  CheckRange("--fov",
             fov_deg,
             NominalCamera::kMinFovDeg,
             NominalCamera::kMaxFovDeg,
             "in degrees, across the width of the images");
  CheckRange("--ceiling-height",
             ceiling_height_m,
             kMinCeilingM,
             NominalCamera::kMaxHeightM,
             "in metres above the floor");
  if (camera_height_m) {
    CheckRange("--camera-height",
               camera_height_m,
               0,
               *ceiling_height_m - kMinCeilingM,
               "in metres above the floor and 0.3 m below --ceiling-height");
  }
}

void RigOptions::CheckFromBag() const {
  if (!file.empty() || fov_deg || camera_height_m) {
    throw InputError(
        fmt::format("--rig-from-bag and {}: give one of the two",
                    !file.empty() ? "--rig" : (fov_deg ? "--fov" : "--camera-height")));
  }
  if (!ceiling_height_m) {
    throw InputError(
        "--rig-from-bag: a bag does not state the height of the ceiling; give --ceiling-height M, "
        "above the floor");
  }
  CheckRange("--ceiling-height",
             ceiling_height_m,
             kMinCeilingM,
             calib::NominalCamera::kMaxHeightM,
             "in metres above the floor");
}

calib::Rig RigOptions::OfBag(const std::string& up,
                             const std::string& forward,
                             const recordings::BagOptions& bags) const {
  return recordings::ReadBagRig(
      up, bags.Topic("up"), forward, bags.Topic("forward"), *ceiling_height_m);
}

std::optional<calib::Rig> RigOptions::ReadFile() const {
  if (file.empty()) return std::nullopt;
  return calib::ReadRig(file);
}

calib::Rig RigOptions::Nominal(cv::Size size) const {
  return calib::NominalRig(size,
                           {*fov_deg * kRadPerDeg, *ceiling_height_m, camera_height_m.value_or(0)});
}

std::string RigOptions::Assumption() const {
  if (!file.empty()) return "";
  if (from_bag) {
    return fmt::format(
        "--rig-from-bag: base_link is taken to be above the axle, and lengths are as exact as the "
        "{:g} m from the floor to the ceiling and the camera's height in /tf_static",
        *ceiling_height_m);
  }
  if (!fov_deg) return "no --rig: lengths are in pixels of the recording, not in metres";
  return fmt::format(
      "--fov {:g}: lengths in metres are as exact as this angle and the {:g} m from the camera to "
      "the ceiling; the lens is taken to be without distortion",
      *fov_deg,
      *ceiling_height_m - camera_height_m.value_or(0));
}

}  // namespace ceilmap::commands
