#include "samples/simulator/sensor_truth.hpp"

#include <fmt/format.h>

#include "calib/base/degrees.hpp"
#include "samples/simulator/scene_fields.hpp"

namespace ceilmap::simulator {
namespace {

/// The plain fields of a group by the names of the scene file.
template <typename Group, std::size_t N>
std::string FieldsText(const Group& group, const std::array<Field<Group>, N>& fields) {
  std::string text;
  for (const Field<Group>& field : fields) {
    text +=
        fmt::format("  {}: {:.12g}\n", field.key, group.*std::get<double Group::*>(field.member));
  }
  return text;
}

std::string WheelsText(const Scene& scene) {
  const Wheels& wheels = *scene.wheels;
  const double start_s = StartStamp(scene);
  std::string text = "wheels:\n";
  text += fmt::format("  kind: {}\n", kWheelsKinds.at(static_cast<std::size_t>(wheels.kind)));
  text += fmt::format("  axle_x_m: {:.12g}  # in base: the point of the speeds\n",
                      -scene.axle_behind_mast_m);
  text += fmt::format("  travel_ratio: {:.12g}  # recorded travel over true travel\n",
                      1 + wheels.scale_error_ratio);
  text += fmt::format("  yaw_ratio: {:.12g}  # recorded turn over true turn\n",
                      1 + wheels.track_width_error_ratio);
  text += FieldsText(wheels, kWheelsFields);
  text += "  slips:";
  text += wheels.slips.empty() ? " []\n" : "\n";
  for (const Slip& slip : wheels.slips) {
    text += fmt::format("    - {{from_stamp_s: {:.6f}, to_stamp_s: {:.6f}, extra_m: {:.12g}}}\n",
                        start_s + slip.at_s,
                        start_s + slip.at_s + slip.duration_s,
                        slip.extra_m);
  }
  text += "  gaps:";
  text += wheels.gaps.empty() ? " []\n" : "\n";
  for (const TimeSpan& gap : wheels.gaps) {
    text += fmt::format("    - {{from_stamp_s: {:.6f}, to_stamp_s: {:.6f}}}\n",
                        start_s + gap.from_s,
                        start_s + gap.to_s);
  }
  return text;
}

std::string GyroText(const Gyro& gyro, const std::vector<GyroSample>& samples) {
  std::string text = "gyro:\n" + FieldsText(gyro, kGyroFields);
  if (samples.empty()) return text;
  double sum_rad_s = 0;
  for (const GyroSample& sample : samples) sum_rad_s += sample.bias_rad_s;
  const double mean_rad_s = sum_rad_s / static_cast<double>(samples.size());
  text += fmt::format("  mean_bias_deg_s: {:.9g}\n  end_bias_deg_s: {:.9g}\n",
                      mean_rad_s / kRadPerDeg,
                      samples.back().bias_rad_s / kRadPerDeg);
  return text;
}

}  // namespace

std::string SensorTruthYaml(const Scene& scene, const std::vector<GyroSample>& gyro) {
  if (!scene.wheels && !scene.gyro) return {};
  std::string text =
      "# What holds for odometry.csv and gyro.csv. Stamps are true ones, as in frames.csv.\n";
  text += fmt::format("seed: {}\n", scene.seed);
  if (scene.wheels) text += WheelsText(scene);
  if (scene.gyro) text += GyroText(*scene.gyro, gyro);
  return text;
}

}  // namespace ceilmap::simulator
