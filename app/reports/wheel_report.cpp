#include "app/reports/wheel_report.hpp"

#include <fmt/format.h>

#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using robot::WheelsReport;
using wheels::Uncertain;
using wheels::WheelFault;

std::string CauseOf(const WheelsReport& wheels) {
  switch (wheels.fault) {
    case WheelFault::kNone:
      return "";
    case WheelFault::kOppositeYaw:
      return "its yaw has the opposite sign: counter-clockwise, seen from above, must be positive";
    case WheelFault::kOppositeTravel:
      return "by it the robot drives backwards: the x axis of base must point ahead";
    case WheelFault::kUnits:
      return fmt::format("the way is {:.3g} times as long: it must be in metres",
                         wheels.travel_ratio);
    case WheelFault::kUnrelated:
      return "it may be of another robot, another recording, or another clock";
  }
  return "";
}

/// Whether the drive has shown a constant.
bool Shown(const Uncertain& found, const Uncertain& before) {
  constexpr double kBetter = 0.5;
  return found.sigma < kBetter * before.sigma;
}

std::string WithSigma(const Uncertain& value, double unit, int decimals) {
  return fmt::format(
      "{:.{}f} +- {:.{}f}", unit * value.value, decimals, unit * value.sigma, decimals);
}

}  // namespace

std::vector<std::string> WheelWarnings(const SensorResult& result) {
  std::vector<std::string> warnings;
  const WheelsReport& wheels = result.report.wheels;
  const std::string odometry = result.inputs->OdometryFile().string();
  if (odometry.empty()) return warnings;
  const auto sorted = [&warnings](const std::string& file, int rows) {
    if (rows == 0) return;
    warnings.push_back(fmt::format(
        "{}: {} rows were not later than the one before; they were sorted", file, rows));
  };
  sorted(odometry, result.inputs->Odometry().out_of_order);
  sorted(result.inputs->GyroFile().string(), result.inputs->Gyro().out_of_order);
  if (wheels.fault != WheelFault::kNone) {
    warnings.push_back(
        fmt::format("{}: contradicts the ceiling all the way, and was not used further; {}",
                    odometry,
                    CauseOf(wheels)));
  } else if (wheels.samples == 0 || wheels.missing > 0) {
    const std::string frames =
        wheels.samples == 0 ? "no frame has" : fmt::format("{} frames have no", wheels.missing);
    warnings.push_back(
        fmt::format("{}: {} odometry at the same time (gaps, or another clock: it covers {:.3f} to "
                    "{:.3f} s)",
                    odometry,
                    frames,
                    result.inputs->Odometry().FirstStamp(),
                    result.inputs->Odometry().LastStamp()));
  }
  return warnings;
}

nlohmann::ordered_json WheelQuality(const WheelsReport& wheels) {
  const auto json = [](const Uncertain& value, double unit) {
    return nlohmann::ordered_json{{"value", unit * value.value}, {"sigma", unit * value.sigma}};
  };
  const wheels::WheelModel& model = wheels.model;
  return {{"samples", wheels.samples},
          {"missing", wheels.missing},
          {"compared", wheels.pieces},
          {"slips", wheels.slips},
          {"fault", CauseOf(wheels)},
          {"scale", json(model.scale, 1)},
          {"turn_scale", json(model.turn_scale, 1)},
          {"gyro_bias_deg_s", json(model.gyro_bias_rad_s, kDegPerRad)},
          {"late_s", json(model.late_s, 1)},
          {"gyro_late_s", json(model.gyro_late_s, 1)},
          {"travel_noise_per_sqrt_m", model.travel_noise_per_sqrt_m},
          {"yaw_noise_deg_per_sqrt_m", kDegPerRad * model.yaw_noise_per_sqrt_m}};
}

void AddWheelRows(const WheelsReport& wheels, terminal::Table& table) {
  if (wheels.samples == 0) return;
  const wheels::WheelModel& model = wheels.model;
  const wheels::WheelModel before;
  const auto add = [&table](const char* name,
                            const Uncertain& found,
                            const Uncertain& first,
                            double unit,
                            int decimals,
                            const char* note) {
    if (Shown(found, first)) table.AddRow({name, WithSigma(found, unit, decimals), note});
  };
  constexpr double kMsPerS = 1e3;
  add("wheel scale", model.scale, before.scale, 1, 5, "true travel / travel by the wheels");
  add("turn scale", model.turn_scale, before.turn_scale, 1, 4, "true turn / turn by the wheels");
  add("wheels late", model.late_s, before.late_s, kMsPerS, 1, "ms, against the images");
  add("gyro bias", model.gyro_bias_rad_s, before.gyro_bias_rad_s, kDegPerRad, 3, "deg/s");
  add("gyro late", model.gyro_late_s, before.gyro_late_s, kMsPerS, 1, "ms, against the images");
  if (wheels.slips > 0) {
    table.AddRow({"slips",
                  fmt::format("{}", wheels.slips),
                  fmt::format("of {} pieces of the way contradict the ceiling", wheels.pieces)});
  }
}

}  // namespace ceilmap::reports
