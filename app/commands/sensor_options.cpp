#include "app/commands/sensor_options.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap::commands {
namespace {

using compensation::TiltMethod;

void CheckTilt(const SensorOptions& options, bool have_rig) {
  const std::string& tilt = options.tilt;
  if (!have_rig && (!options.forward.empty() || (!tilt.empty() && tilt != "none"))) {
    throw InputError(
        fmt::format("{}: tilt can only be measured with the robot's geometry; give --rig",
                    options.forward.empty() ? "--tilt " + tilt : "--forward"));
  }
  if ((tilt == "forward" || tilt == "matsumoto") && options.forward.empty()) {
    throw InputError(fmt::format("--tilt {}: needs the forward camera; give --forward", tilt));
  }
  if (options.forward.empty() && !options.forward_stamps.empty()) {
    throw InputError("--forward-stamps: there are no forward frames; give --forward");
  }
}

void CheckHeading(const SensorOptions& options, bool have_rig) {
  if (!options.omni.empty() && !options.heading.empty()) {
    throw InputError("--omni and --heading: give one of the two");
  }
  if (!options.heading_model.empty() && (!options.omni.empty() || !options.heading.empty())) {
    throw InputError(fmt::format("--heading-model and {}: give one of the two",
                                 options.omni.empty() ? "--heading" : "--omni"));
  }
  if (!options.heading_model.empty() && options.forward.empty()) {
    throw InputError("--heading-model: needs the forward camera; give --forward");
  }
  if (!options.omni.empty() && !have_rig) {
    throw InputError("--omni: the mirror is described in the robot's geometry; give --rig");
  }
  if (options.omni.empty() && !options.omni_stamps.empty()) {
    throw InputError("--omni-stamps: there are no mirror frames; give --omni");
  }
}

}  // namespace

void SensorOptions::AddTo(CLI::App& cli,
                          const std::string& inputs,
                          const std::string& priors,
                          const std::string& results) {
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("--forward", forward, "Forward camera, for the tilt caused by debris", "SOURCE")
      ->group(inputs);
  add("--forward-stamps", forward_stamps, "Time of each forward frame [--stamps]", "FRAMES.csv")
      ->group(inputs);
  add("--tilt",
      tilt,
      "Tilt compensation: none; by the forward camera (forward; matsumoto: as published by "
      "Matsumoto et al. 2010, each frame alone); by the keystone distortion of the ceiling; or by "
      "ceiling and forward camera [fused with a rig; ceiling without --forward]",
      "METHOD")
      ->check(CLI::IsMember({"none", "matsumoto", "forward", "ceiling", "fused"}))
      ->group(inputs);
  add("--uncompensated", uncompensated, "Poses without compensation", "T0.tum")->group(results);
  add("--omni", omni, "Camera under a convex mirror, for the heading", "SOURCE")->group(inputs);
  add("--omni-stamps", omni_stamps, "Time of each mirror frame [--stamps]", "FRAMES.csv")
      ->group(inputs);
  add("--heading", heading, "Measured headings: timestamp,heading_deg,sigma_deg", "H.csv")
      ->group(priors);
  wheels.AddTo(
      cli, inputs, results, "Turn rates of a gyro, alone or beside --odometry: timestamp,omega_z");
}

void SensorOptions::AddModelTo(CLI::App& cli, const std::string& priors) {
  cli.add_option("--heading-model",
                 heading_model,
                 "Headings by the colours in --forward: a model of 'compass learn', "
                 "learned at poses on this map")
      ->type_name("MODEL")
      ->group(priors);
}

std::vector<std::string> SensorOptions::BagSources() {
  return {"up", "forward", "omni", "odometry", "gyro"};
}

void SensorOptions::TakeBag(const recordings::BagOptions& bags, const std::string& up) {
  bags.CheckMain("up", up);
  forward = bags.Complete("forward", forward, "up", up);
  omni = bags.Complete("omni", omni, "up", up);
  wheels.TakeBag(bags, "up", up);
}

void SensorOptions::Check(bool have_rig) const {
  if (!wheels.odometry.empty() && !have_rig) {
    throw InputError("--odometry: is in metres; give --rig, so that the map is in metres too");
  }
  wheels.CheckRigOut(have_rig);
  CheckHeading(*this, have_rig);
  CheckTilt(*this, have_rig);
}

recordings::SensorFiles SensorOptions::Files(bool have_rig,
                                             const std::filesystem::path& stamps,
                                             HeadingFrame headings_frame,
                                             const recordings::BagOptions& bags) const {
  recordings::SensorFiles files;
  files.forward = forward;
  files.forward_stamps = forward_stamps;
  files.omni = omni;
  files.omni_stamps = omni_stamps;
  files.headings = heading;
  files.heading_model = heading_model;
  files.odometry = wheels.odometry;
  files.gyro = wheels.gyro;
  files.forward_topic = bags.Topic("forward");
  files.omni_topic = bags.Topic("omni");
  files.odometry_topic = bags.Topic("odometry");
  files.gyro_topic = bags.Topic("gyro");
  files.headings_frame = headings_frame;
  files.stamps = stamps;
  if (have_rig && tilt != "none") {
    files.tilt = tilt == "matsumoto" ? TiltMethod::kMatsumoto
                 : tilt == "forward" ? TiltMethod::kForward
                 : tilt == "ceiling" ? TiltMethod::kCeiling
                                     : TiltMethod::kFused;
  }
  return files;
}

}  // namespace ceilmap::commands
