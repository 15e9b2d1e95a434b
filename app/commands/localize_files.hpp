#pragma once

#include <filesystem>
#include <optional>

#include "app/files/output_files.hpp"
#include "app/files/trajectory_file.hpp"
#include "app/terminal/summary.hpp"
#include "calib/level_view.hpp"
#include "localization/robot/estimate.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::commands {

/// What `localize` writes frame by frame; a path that is empty: not written.
struct LocalizeOutputs {
  std::filesystem::path trajectory;     ///< TUM, or a bag
  std::filesystem::path uncompensated;  ///< the same without compensation of the tilt
  std::filesystem::path status;
  std::filesystem::path hypotheses;
  bool predicted = false;  ///< trajectories have the poses by the wheels alone too
  bool stream = false;     ///< poses to stdout, as they are found
  /// Poses in the coordinates of the building; nothing: in those of the map.
  std::optional<survey::SiteFrame> site;
};

/// Files and messages of `localize` that are written during the run.
class LocalizeFiles {
 public:
  /// @param level  of the localizer's view. @throws RunError when a file cannot be written.
  LocalizeFiles(LocalizeOutputs outputs, const calib::LevelView& level);

  void Add(const robot::Estimate& in_map);
  /// Completes the files that say why there is no pose.
  void CommitStatus();
  /// Completes all files and names them in the summary.
  void Commit(terminal::Summary& summary);

 private:
  void AddUncompensated(const robot::Estimate& in_map, bool placed);

  LocalizeOutputs outputs_;
  calib::LevelView level_;
  files::TrajectoryFile trajectory_;
  files::TrajectoryFile uncompensated_;
  files::GrowingFile status_;
  files::GrowingFile hypotheses_;
};

}  // namespace ceilmap::commands
