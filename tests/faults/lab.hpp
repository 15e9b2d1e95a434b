#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "calib/base/pose2.hpp"
#include "tests/faults/fault.hpp"
#include "tests/support/child_process.hpp"

namespace ceilmap::faults {

/// What stands under a map's name after a run.
enum class MapState {
  kOld,  ///< bit by bit what stood there before
  kNew,  ///< another map, which opens and contains all poses of its metadata
  kLost  ///< neither
};

/// What the program did, and how right it was.
struct Outcome {
  int exit_code = 0;
  /// Its message after a failure; "" after success.
  std::string message;
  /// Exit code 0, 1 or 2; when it is not 0, one line on stderr gives the reason.
  bool orderly = false;
  int shots = 0;      ///< images of the recording
  int placed = 0;     ///< that got a pose
  double rmse_m = 0;  ///< of these, against where their images were taken
  double largest_m = 0;
  /// Accepted although wrong: an error of more than 0.05 m or 0.02 rad, and by more than four of
  /// the standard deviations that are claimed.
  int wrong = 0;
  MapState map = MapState::kOld;

  [[nodiscard]] double Coverage() const;
  /// No crash, no wrong pose, no map lost.
  [[nodiscard]] bool Survived() const { return orderly && wrong == 0 && map != MapState::kLost; }
};

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

/// What the run left, judged as all runs are.
Outcome OutcomeOf(const support::ProcessResult& result, const Recording& shots);

}  // namespace ceilmap::faults
