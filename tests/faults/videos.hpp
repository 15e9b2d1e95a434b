#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "samples/simulator/scene.hpp"
#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

/// Options of ffmpeg's.
using Options = std::vector<std::string>;
/// `options`, then `more`.
Options With(Options options, const Options& more);

/// A drive under a ceiling with exact truth.
struct World {
  std::string name;
  Recording shots;
  double rate_hz = 10;
  std::string rig;                        ///< text of its rig file
  std::optional<simulator::Scene> scene;  ///< nothing: a recording that was not made here
};

/// Three simulated rooms (tiles at 320 x 240, tiles of a hall, plaster without edges) and the
/// bundled recording lab-map.
std::vector<World> AllWorlds();
/// The first of them.
World TilesWorld();

/// Another robot's drive in the room, with another camera; nothing for a world without a scene.
std::optional<World> VisitorOf(const World& world);

/// A way in which a camera, a phone or a recorder makes a video of a drive.
struct VideoCase {
  std::string group;
  std::string name;
  /// Changes the scene, which is rendered again; only for worlds with a scene.
  std::function<void(simulator::Scene&)> scene = {};
  /// Frames that reach the file; empty: all.
  std::function<Recording(const Recording&, Random&)> frames = {};
  bool stamps = false;  ///< the run is given the true times
  Options encoder;      ///< of the output
  Options flags = {};   ///< options of a second run, which copies the stream
  std::string file = "up.mp4";
};

const std::vector<VideoCase>& AllVideoCases();

/// What the case's video of the world shows. @param world  with a scene where the case needs one.
World Seen(const World& world, const VideoCase& video, unsigned seed);

}  // namespace ceilmap::faults
