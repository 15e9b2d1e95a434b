#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"
#include "tests/faults/fault.hpp"
#include "tests/faults/outcome.hpp"
#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

/// A room, the recording that it is mapped from, its map, and the recording of another robot there;
/// both with truth, and with wheels and a gyro where the world has them. Runs the real program on
/// faulty copies of them.
class Lab {
 public:
  /// @param folder  takes all files; it must exist.
  explicit Lab(std::filesystem::path folder, const LabWorld& world = TilesRoom());

  /// `ceilmap map` of a faulty recording over an older map of the same name.
  [[nodiscard]] Outcome Map(const Fault& fault, unsigned seed) const;
  /// `ceilmap localize` of a faulty recording on the good map.
  [[nodiscard]] Outcome Localize(const Fault& fault, unsigned seed) const;

  [[nodiscard]] const std::filesystem::path& Folder() const { return folder_; }
  [[nodiscard]] const Recording& Mapped() const { return mapped_.shots; }
  [[nodiscard]] const Recording& Visited() const { return visited_.shots; }

  /// Arguments of the program for the two robots, with the options that name a recording; paths
  /// are relative to the folder.
  [[nodiscard]] static std::vector<std::string> MapArguments(const std::vector<std::string>& inputs,
                                                             const std::string& map);
  [[nodiscard]] static std::vector<std::string> LocalizeArguments(
      const std::vector<std::string>& inputs, const std::string& map);
  /// The state of the file now. @param before  its bytes then.
  [[nodiscard]] MapState StateOf(const std::filesystem::path& map, const std::string& before) const;

 private:
  /// A good drive.
  struct Drive {
    std::string name;  // of its files
    Recording shots;
    Motion motion;
  };
  /// A faulty one, in files.
  struct Stored {
    Recording shots;
    std::vector<std::string> inputs;  // options
  };
  [[nodiscard]] Drive Record(const std::string& name, const simulator::Scene& scene) const;
  [[nodiscard]] Stored Store(const Drive& good, const Fault& fault, unsigned seed) const;
  /// Stores motion beside the images. @return its options.
  [[nodiscard]] std::vector<std::string> StoreMotion(const Motion& motion,
                                                     const Fault& fault,
                                                     Random& random) const;

  std::filesystem::path folder_;
  Drive mapped_;
  Drive visited_;
  Pose2 T_room_map_;
};

}  // namespace ceilmap::faults
