#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tests/faults/outcome.hpp"
#include "tests/faults/videos.hpp"

namespace ceilmap::faults {

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

/// A map of a world's drive, on which another robot is localized by videos of every kind.
class VideoLab {
 public:
  /// Makes the map of a video of good quality in `folder`, where the runs take place too.
  VideoLab(const World& world, std::filesystem::path folder);

  /// Stores the case's video and runs `ceilmap localize` on it.
  /// @return nothing where the world has no scene, or the case changes it.
  [[nodiscard]] std::optional<Outcome> Localize(const VideoCase& video, unsigned seed) const;

 private:
  std::filesystem::path folder_;
  std::optional<World> visitor_;
  Pose2 T_room_map_;
};

}  // namespace ceilmap::faults
