#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/evaluation/compensation.hpp"
#include "app/evaluation/consistency.hpp"
#include "app/evaluation/heading_errors.hpp"
#include "app/evaluation/time_offset.hpp"
#include "app/evaluation/trajectory_errors.hpp"
#include "app/files/arguments.hpp"
#include "app/files/status_csv.hpp"
#include "app/reports/compensation_report.hpp"

namespace ceilmap::reports {

/// Conversion of an estimate's clock to that of the truth.
struct ClockOffset {
  bool search = false;  ///< determined from the motion; else ...
  double seconds = 0;   ///< ... this is added to the stamps of the estimate
};

struct ComparisonInputs {
  std::filesystem::path truth;
  std::vector<std::string> estimates;  ///< `[NAME=]FILE`, no name twice
  std::filesystem::path before;        ///< without tilt compensation; empty: no comparison
  /// `before` is of another run than the estimates: each is aligned by its own level part.
  bool before_is_another_run = false;
  std::filesystem::path expect;  ///< stamps with expected poses; empty: the truth's
  /// The truth of the run that created the map, and its estimate: their alignment is that of the
  /// map and of all robots on it. Empty: each estimate is aligned as `evaluation` requests.
  std::vector<std::filesystem::path> frame_from;
  ClockOffset offset;
  evaluation::EvaluationParams evaluation;
};

/// Comparison of one estimate with the truth.
struct ComparedEstimate {
  files::NamedFile file;
  double offset_s = 0;                                   ///< added to its stamps
  std::optional<evaluation::TimeOffset> found_offset;    ///< set if it was searched
  std::optional<evaluation::TrajectoryErrors> errors;    ///< unset: headings only
  evaluation::HeadingErrors heading;                     ///< relative to its first matched pose
  std::optional<evaluation::Consistency> consistency;    ///< if it has covariances
  std::vector<evaluation::PoseCovariance> covariances;   ///< of its poses; empty: unknown
  std::map<std::string, std::int64_t> frames_of_status;  ///< of a status file
  std::vector<files::FrameStatus> placed;                ///< of a status file, of each pose
  std::vector<files::FrameStatus> unplaced;  ///< of a status file, with stamps of the truth's clock
  std::int64_t matched = 0;
  std::int64_t expected = 0;

  [[nodiscard]] double Coverage() const {
    return expected > 0 ? static_cast<double>(matched) / static_cast<double>(expected) : 0;
  }
};

/// Results of tilt compensation.
struct BeforeAndAfter {
  evaluation::LevelAlignment alignment;
  evaluation::TiltDegrees largest_true_tilt;
  std::vector<NamedCompensation> estimates;  ///< all, in order of the arguments
};

struct Comparison {
  std::vector<StampedPose> truth;
  std::vector<ComparedEstimate> estimates;  ///< in the order of the arguments
  std::optional<BeforeAndAfter> compensation;
};

/// Reads all files and compares them.
/// @throws InputError on unusable files, two estimates of the same name, and an estimate that has
/// no pose at the time of a true one.
Comparison Compare(const ComparisonInputs& params);

}  // namespace ceilmap::reports
