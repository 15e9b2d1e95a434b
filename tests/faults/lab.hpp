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
/// both with truth. Runs the real program on faulty copies of them.
class Lab {
 public:
  /// @param folder  takes all files; it must exist.
  explicit Lab(std::filesystem::path folder);

  /// `ceilmap map` of a faulty recording over an older map of the same name.
  [[nodiscard]] Outcome Map(const Fault& fault, unsigned seed) const;
  /// `ceilmap localize` of a faulty recording on the good map.
  [[nodiscard]] Outcome Localize(const Fault& fault, unsigned seed) const;

  [[nodiscard]] const std::filesystem::path& Folder() const { return folder_; }
  [[nodiscard]] const Recording& Mapped() const { return mapped_; }
  [[nodiscard]] const Recording& Visited() const { return visited_; }

  /// Arguments of the program for the good recordings, the result named by the caller.
  [[nodiscard]] std::vector<std::string> MapArguments(const std::string& up,
                                                      const std::string& stamps,
                                                      const std::string& map) const;
  [[nodiscard]] std::vector<std::string> LocalizeArguments(const std::string& up,
                                                           const std::string& stamps,
                                                           const std::string& map) const;
  /// The state of the file now. @param before  its bytes then.
  [[nodiscard]] MapState StateOf(const std::filesystem::path& map, const std::string& before) const;

 private:
  struct Stored {
    Recording shots;
    std::filesystem::path up;
    std::filesystem::path stamps;
  };
  [[nodiscard]] Stored Store(const Recording& good, const Fault& fault, unsigned seed) const;

  std::filesystem::path folder_;
  Recording mapped_;
  Recording visited_;
  Pose2 T_room_map_;
};

}  // namespace ceilmap::faults
