#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/bags/mcap_writer.hpp"
#include "app/files/output_files.hpp"
#include "app/files/trajectory_bag.hpp"
#include "localization/robot/estimate.hpp"

namespace ceilmap::files {

/// True for the name of a bag: it ends in `.mcap`.
bool IsBagName(const std::filesystem::path& file);

/// A trajectory that is written frame by frame and becomes visible at the end: TUM lines, or a bag
/// (TrajectoryBag), depending on its name. TUM has no line for a frame without a pose, a bag has
/// its status. Without a name all is discarded.
class TrajectoryFile {
 public:
  /// @param predicted  Poses of status kPredicted are written too.
  /// @throws as AtomicFile, and RunError when the disk cannot be written; as all functions below.
  explicit TrajectoryFile(const std::filesystem::path& target, bool predicted = false);

  /// @throws InputError for a time that the file cannot hold.
  void CheckStamp(double stamp_s) const;
  /// @return true when its pose is part of the trajectory. @throws as CheckStamp.
  bool Add(const graph::FramePose& frame);
  /// The same with the agreement of the image and the map.
  bool Add(const robot::Estimate& estimate);
  /// Completes the content, so that only a failure of the disk's names can follow.
  void Close();
  void Commit();
  [[nodiscard]] bool IsBag() const { return bag_.has_value(); }
  [[nodiscard]] const std::filesystem::path& Target() const { return target_; }

 private:
  bool Add(const graph::FramePose& frame, const TrajectoryBag::Values& values);

  std::filesystem::path target_;
  bool predicted_;
  GrowingFile text_;
  std::optional<bags::McapWriter> writer_;
  std::optional<TrajectoryBag> bag_;
};

}  // namespace ceilmap::files
