#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "samples/simulator/scene.hpp"
#include "tests/faults/outcome.hpp"
#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

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

/// A way in which a camera, a phone or a recorder makes a video of a drive.
struct VideoCase {
  std::string group;
  std::string name;
  /// Changes the scene, which is rendered again; only for worlds with a scene.
  std::function<void(simulator::Scene&)> scene = {};
  /// Frames that reach the file; empty: all.
  std::function<Recording(const Recording&, Random&)> frames = {};
  bool stamps = false;                  ///< the run is given the true times
  std::vector<std::string> encoder;     ///< ffmpeg's options of the output
  std::vector<std::string> flags = {};  ///< options of a second run, which copies the stream
  std::string file = "up.mp4";
};

const std::vector<VideoCase>& AllVideoCases();

/// Stores the case's video in `folder` and runs `ceilmap map` on it.
/// @return nothing where the world has no scene and the case needs one.
std::optional<Outcome> MapVideo(const World& world,
                                const VideoCase& video,
                                unsigned seed,
                                const std::filesystem::path& folder);

/// The same for a video that is already in `folder`, as `file`, and shows the world's shots.
/// @param stamps  whether the run is given their times; if not, a shot's time is its place in the
/// video.
Outcome MapStoredVideo(World world,
                       const std::string& file,
                       bool stamps,
                       const std::filesystem::path& folder);

}  // namespace ceilmap::faults
