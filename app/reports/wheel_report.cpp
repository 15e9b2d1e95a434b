#include "app/reports/wheel_report.hpp"

#include <fmt/format.h>

#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using wheels::Uncertain;
using wheels::WheelFault;
using wheels::WheelsReport;

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

std::string CauseOf(const WheelsReport& wheels) {
  switch (wheels.fault) {
    case WheelFault::kOppositeYaw:
      return "its yaw has the opposite sign: counter-clockwise, seen from above, must be positive";
    case WheelFault::kOppositeTravel:
      return "by it the robot drives backwards: the x axis of base must point ahead";
    case WheelFault::kUnits:
      return fmt::format("the way is {:.3g} times as long: it must be in metres",
                         wheels.travel_ratio);
    case WheelFault::kTurnUnits:
      return fmt::format("its turns are {:.3g} times as large: turn rates must be in rad/s",
                         1 / wheels.turn_ratio);
    case WheelFault::kNone:
    case WheelFault::kUnrelated:
      return "it may be of another robot, another recording, or another clock";
  }
  return "";
}

std::vector<std::string> WheelWarnings(const recordings::WheelInputs& inputs,
                                       const WheelsReport& wheels,
                                       const std::string& images) {
  std::vector<std::string> warnings;
  const bool has_wheels = !inputs.OdometryName().empty();
  const std::string& file = has_wheels ? inputs.OdometryName() : inputs.GyroName();
  if (file.empty()) return warnings;
  const auto sorted = [&warnings](const std::string& name, int rows) {
    if (rows == 0) return;
    warnings.push_back(fmt::format(
        "{}: {} rows were not later than the one before; they were sorted", name, rows));
  };
  sorted(inputs.OdometryName(), inputs.Odometry().out_of_order);
  sorted(inputs.GyroName(), inputs.Gyro().out_of_order);
  for (std::string& warning : inputs.BagWarnings()) warnings.push_back(std::move(warning));
  // Only bags are opened without reading a sample.
  const bool empty = has_wheels ? inputs.Odometry().Empty() : inputs.Gyro().samples.empty();
  if (empty) {
    warnings.push_back(fmt::format("{}: no message of it could be used", file));
    return warnings;
  }
  const bool none = wheels.samples == 0 && !wheels.gyro;
  constexpr std::int64_t kAtTheEnds = 2;  // frames that begin before, or end after the samples
  if (wheels.fault != WheelFault::kNone) {
    warnings.push_back(fmt::format("{}: contradicts {} all the way, and was not used further; {}",
                                   file,
                                   images,
                                   CauseOf(wheels)));
  } else if (none || wheels.missing > kAtTheEnds) {
    const std::string frames =
        none ? "no frame has" : fmt::format("{} frames have no", wheels.missing);
    const double first_s =
        has_wheels ? inputs.Odometry().FirstStamp() : inputs.Gyro().samples.front().stamp_s;
    const double last_s =
        has_wheels ? inputs.Odometry().LastStamp() : inputs.Gyro().samples.back().stamp_s;
    warnings.push_back(
        fmt::format("{}: {} {} at the same time (gaps, or another clock: it covers {:.3f} to "
                    "{:.3f} s)",
                    file,
                    frames,
                    has_wheels ? "odometry" : "turn rate",
                    first_s,
                    last_s));
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
          {"gyro_stuck_s", wheels.gyro_stuck_s},
          {"fault", wheels.fault == WheelFault::kNone ? "" : CauseOf(wheels)},
          {"scale", json(model.scale, 1)},
          {"turn_scale", json(model.turn_scale, 1)},
          {"gyro_bias_deg_s", json(model.gyro_bias_rad_s, kDegPerRad)},
          {"late_s", json(model.late_s, 1)},
          {"gyro_late_s", json(model.gyro_late_s, 1)},
          {"travel_noise_per_sqrt_m", model.travel_noise_per_sqrt_m},
          {"yaw_noise_deg_per_sqrt_m", kDegPerRad * model.yaw_noise_per_sqrt_m}};
}

void AddWheelRows(const WheelsReport& wheels, const std::string& images, terminal::Table& table) {
  if (wheels.samples == 0 && !wheels.gyro) return;
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
  if (wheels.samples > 0 && wheels.gyro_stuck_s > 0) {
    table.AddRow({"gyro stuck",
                  fmt::format("{:.1f}", wheels.gyro_stuck_s),
                  "s with one value exactly; there the wheels gave the turn"});
  }
  if (wheels.slips > 0) {
    table.AddRow({"slips",
                  fmt::format("{}", wheels.slips),
                  fmt::format("of {} pieces of the way contradict {}", wheels.pieces, images)});
  }
}

}  // namespace ceilmap::reports
