#include "calib/wheel_section.hpp"

#include <array>
#include <string_view>

#include "calib/base/degrees.hpp"

namespace ceilmap::calib {
namespace {

using wheels::Uncertain;
using wheels::WheelModel;

struct Constant {
  std::string_view key;
  Uncertain WheelModel::*field;
  double unit;  // of the file, in that of the field
  bool positive;
};

struct Noise {
  std::string_view key;
  double WheelModel::*field;
  double unit;
};

constexpr std::array<Constant, 5> kConstants{{
    {"scale", &WheelModel::scale, 1, true},
    {"turn_scale", &WheelModel::turn_scale, 1, true},
    {"late_s", &WheelModel::late_s, 1, false},
    {"gyro_bias_deg_s", &WheelModel::gyro_bias_rad_s, kRadPerDeg, false},
    {"gyro_late_s", &WheelModel::gyro_late_s, 1, false},
}};

constexpr std::array<Noise, 4> kNoises{{
    {"travel_noise_per_sqrt_m", &WheelModel::travel_noise_per_sqrt_m, 1},
    {"yaw_noise_deg_per_sqrt_m", &WheelModel::yaw_noise_per_sqrt_m, kRadPerDeg},
    {"yaw_noise_per_sqrt_rad", &WheelModel::yaw_noise_per_sqrt_rad, 1},
    {"gyro_noise_deg_per_sqrt_s", &WheelModel::gyro_noise_per_sqrt_s, kRadPerDeg},
}};

void Read(const YamlValue& value, const Constant& constant, WheelModel& model) {
  const std::vector<double> numbers = value.Numbers(2);
  if (!(numbers[1] >= 0) || (constant.positive && !(numbers[0] > 0.1 && numbers[0] < 10))) {
    value.Fail(constant.positive ? "[value in 0.1 .. 10, standard deviation >= 0]"
                                 : "[value, standard deviation >= 0]",
               "write both, e.g. [1.012, 0.002] for a scale");
  }
  model.*constant.field = {numbers[0] * constant.unit, numbers[1] * constant.unit};
}

}  // namespace

WheelModel ParseWheels(const YamlValue& section) {
  section.AllowOnly({"scale",
                     "turn_scale",
                     "late_s",
                     "gyro_bias_deg_s",
                     "gyro_late_s",
                     "travel_noise_per_sqrt_m",
                     "yaw_noise_deg_per_sqrt_m",
                     "yaw_noise_per_sqrt_rad",
                     "gyro_noise_deg_per_sqrt_s"});
  WheelModel model;
  for (const Constant& constant : kConstants) {
    if (const auto value = section.Find(constant.key)) Read(*value, constant, model);
  }
  for (const Noise& noise : kNoises) {
    if (const auto value = section.Find(noise.key)) {
      model.*noise.field = noise.unit * value->PositiveNumber("leave it out where it is not known");
    }
  }
  return model;
}

std::vector<std::pair<std::string, std::vector<double>>> WheelEntries(const WheelModel& model) {
  std::vector<std::pair<std::string, std::vector<double>>> entries;
  entries.reserve(kConstants.size() + kNoises.size());
  for (const Constant& constant : kConstants) {
    const Uncertain& value = model.*constant.field;
    entries.emplace_back(
        constant.key,
        std::vector<double>{value.value / constant.unit, value.sigma / constant.unit});
  }
  for (const Noise& noise : kNoises) {
    entries.emplace_back(noise.key, std::vector<double>{model.*noise.field / noise.unit});
  }
  return entries;
}

}  // namespace ceilmap::calib
