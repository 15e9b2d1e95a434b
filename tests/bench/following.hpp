#pragma once

#include <filesystem>

#include "samples/simulator/scene.hpp"

/// A second robot that drives around in a mapped world: how exactly it is followed, and at what
/// cost. Each function prints its figures and returns whether all bounds hold.
/// @param folder  takes the maps; one that is there already is used again.
namespace ceilmap::bench {

/// Ten worlds that differ in all that matters: covariances against the true errors.
bool RunConsistency(const std::filesystem::path& folder);
/// A fifth of the ceiling is covered by panels that the map does not know, each of another grey.
bool RunChanged(const simulator::Scene& scene, const std::filesystem::path& folder);
/// Cameras of all kinds on one map: no pose may be wrong.
bool RunCameras(const simulator::Scene& scene, const std::filesystem::path& folder);
/// Ratio of the time for tracking a frame to that for registering the same frames with each other.
bool RunSpeed(const std::filesystem::path& folder);

}  // namespace ceilmap::bench
