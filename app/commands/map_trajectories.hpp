#pragma once

#include <filesystem>
#include <vector>

#include "app/files/trajectory_file.hpp"
#include "app/terminal/summary.hpp"
#include "calib/ceiling_view.hpp"
#include "localization/robot/estimate.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::commands {

/// Placed and predicted frames of a recording in order of time.
std::vector<graph::FramePose> PlacedFrames(const mapping::MappingResult& map);

/// The trajectories that `map` writes. Their poses are known at the end of the run.
class MapTrajectories {
 public:
  /// @param uncompensated  Of --uncompensated. Both may be empty.
  /// @param predicted  Frames that only the wheels place are written too.
  MapTrajectories(const std::filesystem::path& trajectory,
                  const std::filesystem::path& uncompensated,
                  bool predicted);

  /// Takes note of a frame while the map is made: one that gets no pose has a status in a bag.
  /// @throws InputError for a time that a file cannot hold.
  void Note(const robot::Estimate& estimate);
  /// Writes the content of the files, which do not appear yet.
  void Write(const mapping::MappingResult& map, const calib::CeilingView& view);
  /// Makes the files appear, and adds their names to the summary.
  void Commit(terminal::Summary& summary);

 private:
  files::TrajectoryFile trajectory_;
  files::TrajectoryFile uncompensated_;
  std::vector<graph::FramePose> noted_;  // of each frame; only for bags
};

}  // namespace ceilmap::commands
