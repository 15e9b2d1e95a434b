#pragma once

#include <string>
#include <vector>

#include "samples/simulator/gyro.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// `wheels.yaml`: the true values of the scene's wheels and gyro, in the units of the scene file,
/// to compare estimates with. Empty if the scene has neither.
/// @param gyro  Samples of MakeGyro, for the bias at their end; empty without a gyro.
std::string SensorTruthYaml(const Scene& scene, const std::vector<GyroSample>& gyro);

}  // namespace ceilmap::simulator
