#include "app/reports/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "app/evaluation/association.hpp"
#include "app/files/estimate_file.hpp"
#include "app/files/stamps.hpp"
#include "app/files/tum.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::StampedHeading;
using evaluation::TimeOffset;

std::vector<files::NamedFile> ParseEstimates(const std::vector<std::string>& arguments) {
  std::vector<files::NamedFile> files;
  std::set<std::string> names;
  for (const std::string& argument : arguments) {
    files.push_back(files::ParseNamedFile(argument));
    if (!names.insert(files.back().name).second) {
      throw InputError(fmt::format(
          "{}: the name '{}' is used twice; write NAME={}", argument, files.back().name, argument));
    }
  }
  return files;
}

// Alignment of a map, from the run that created it.
Similarity2 FrameOfMap(const std::filesystem::path& truth_file,
                       const std::filesystem::path& estimate_file,
                       double max_dt_s) {
  const std::vector<StampedPose> truth = files::ReadTum(truth_file);
  const std::vector<StampedPose> estimate = files::ReadTum(estimate_file);
  std::vector<evaluation::PosePair> pairs;
  for (const auto& [k, c] : evaluation::MatchStamps(truth, estimate, max_dt_s)) {
    pairs.push_back({truth[k], estimate[c]});
  }
  if (pairs.size() < 2) {
    throw InputError(
        fmt::format("{}: {} poses within {} s of one of {}, must be at least 2 to align on",
                    estimate_file.string(),
                    pairs.size(),
                    max_dt_s,
                    truth_file.string()));
  }
  return evaluation::Align(pairs, evaluation::Alignment::kSe2);
}

// Time between the nearest two stamps.
double NearestSeconds(const std::vector<StampedPose>& truth,
                      const std::vector<StampedHeading>& estimate) {
  double nearest_s = std::numeric_limits<double>::infinity();
  for (const StampedHeading& heading : estimate) {
    const auto later = std::lower_bound(
        truth.begin(), truth.end(), heading.stamp_s, [](const StampedPose& pose, double t) {
          return pose.stamp_s < t;
        });
    if (later != truth.end()) nearest_s = std::min(nearest_s, later->stamp_s - heading.stamp_s);
    if (later == truth.begin()) continue;
    nearest_s = std::min(nearest_s, heading.stamp_s - std::prev(later)->stamp_s);
  }
  return nearest_s;
}

class Comparer {
 public:
  explicit Comparer(const ComparisonInputs& params)
      : params_(params), truth_(files::ReadTum(params.truth)), evaluation_(params.evaluation) {
    if (!params.expect.empty()) {
      evaluation_.expected = static_cast<std::int64_t>(files::ReadStamps(params.expect).size());
    }
    if (params.frame_from.empty()) return;
    evaluation_.T_truth_estimate =
        FrameOfMap(params.frame_from.at(0), params.frame_from.at(1), evaluation_.max_dt_s);
  }

  // Its table also has compensations, so that it takes BEFORE.
  void Before(const std::filesystem::path& file);
  void Add(const files::NamedFile& file);
  Comparison Take() {
    comparison_.truth = std::move(truth_);
    return std::move(comparison_);
  }

 private:
  files::Estimate Read(const std::filesystem::path& file, ComparedEstimate& compared) const;
  [[nodiscard]] evaluation::LevelAlignment AlignLevel(const std::filesystem::path& file,
                                                      const files::Estimate& estimate,
                                                      double added_s) const;
  void CompareBefore(const files::NamedFile& file, const files::Estimate& estimate, double added_s);
  [[noreturn]] void ThrowNothingInCommon(const std::filesystem::path& file,
                                         const files::Estimate& estimate,
                                         double added_s) const;
  [[nodiscard]] std::string LikelyOffset(const files::Estimate& estimate, double added_s) const;
  [[nodiscard]] evaluation::CompensationParams Compensation() const {
    return {.max_dt_s = params_.evaluation.max_dt_s};
  }

  const ComparisonInputs& params_;
  std::vector<StampedPose> truth_;
  std::vector<StampedPose> before_;
  evaluation::EvaluationParams evaluation_;
  Comparison comparison_;
};

// @param added_s  Offset that was already added to its stamps.
std::string Comparer::LikelyOffset(const files::Estimate& estimate, double added_s) const {
  if (!estimate.poses.empty()) {
    const std::optional<TimeOffset> offset = evaluation::FindTimeOffset(truth_, estimate.poses);
    if (offset && offset->IsReliable() &&
        std::abs(offset->offset_s) > params_.evaluation.max_dt_s) {
      return fmt::format("the motions agree with --offset {:.3f}", added_s + offset->offset_s);
    }
  }
  const double first_s = estimate.headings.front().stamp_s;
  if (first_s <= truth_.back().stamp_s &&
      estimate.headings.back().stamp_s >= truth_.front().stamp_s) {
    return fmt::format("the nearest two are {:.3g} s apart, see --max-dt",
                       NearestSeconds(truth_, estimate.headings));
  }
  return fmt::format("if both begin at the same time, it is --offset {:.3f}",
                     added_s + truth_.front().stamp_s - first_s);
}

void Comparer::ThrowNothingInCommon(const std::filesystem::path& file,
                                    const files::Estimate& estimate,
                                    double added_s) const {
  throw InputError(
      fmt::format("{}: no pose within {} s of one of {}; its stamps are {:.3f} to {:.3f} s, the "
                  "truth's {:.3f} to {:.3f} s; {}",
                  file.string(),
                  params_.evaluation.max_dt_s,
                  params_.truth.string(),
                  estimate.headings.front().stamp_s,
                  estimate.headings.back().stamp_s,
                  truth_.front().stamp_s,
                  truth_.back().stamp_s,
                  LikelyOffset(estimate, added_s)));
}

// Reads an estimate and converts its stamps to the clock of the truth.
files::Estimate Comparer::Read(const std::filesystem::path& file,
                               ComparedEstimate& compared) const {
  files::Estimate estimate = files::ReadEstimate(file);
  for (const std::string& warning : estimate.warnings) terminal::PrintWarning(warning);
  compared.offset_s = params_.offset.seconds;
  if (params_.offset.search) {
    if (estimate.poses.empty()) {
      throw InputError(
          fmt::format("{}: has headings only, --offset auto needs poses; give --offset SECONDS",
                      file.string()));
    }
    compared.found_offset = evaluation::FindTimeOffset(truth_, estimate.poses);
    if (!compared.found_offset || !compared.found_offset->IsReliable()) {
      throw InputError(fmt::format(
          "{}: the robot's motion does not determine the offset of its clock from that of "
          "{}; give --offset SECONDS",
          file.string(),
          params_.truth.string()));
    }
    compared.offset_s = compared.found_offset->offset_s;
  }
  if (compared.offset_s != 0) estimate.Delay(compared.offset_s);
  return estimate;
}

void Comparer::Before(const std::filesystem::path& file) {
  ComparedEstimate compared;
  const files::Estimate estimate = Read(file, compared);
  if (estimate.poses.empty()) {
    throw InputError(fmt::format("{}: has headings only, --before needs poses", file.string()));
  }
  comparison_.compensation = BeforeAndAfter{
      AlignLevel(file, estimate, compared.offset_s), evaluation::LargestTilt(truth_), {}};
  before_ = estimate.poses;
}

// By the map of the robots where there is one, otherwise by the level part of the trajectory.
evaluation::LevelAlignment Comparer::AlignLevel(const std::filesystem::path& file,
                                                const files::Estimate& estimate,
                                                double added_s) const {
  auto alignment = evaluation::AlignLevelFrames(truth_, estimate.poses, Compensation());
  if (alignment.matched == 0) ThrowNothingInCommon(file, estimate, added_s);
  if (evaluation_.T_truth_estimate) {
    alignment.T_truth_before = evaluation_.T_truth_estimate->motion;
    return alignment;
  }
  if (!alignment.T_truth_before) {
    throw InputError(fmt::format(
        "{}: {} of its {} compared frames are level by {} (pitch and roll below {} deg), "
        "must be at least 2 to align on",
        file.string(),
        alignment.level,
        alignment.matched,
        params_.truth.string(),
        Compensation().level_below_deg));
  }
  return alignment;
}

void Comparer::CompareBefore(const files::NamedFile& file,
                             const files::Estimate& estimate,
                             double added_s) {
  if (estimate.poses.empty()) {
    throw InputError(
        fmt::format("{}: has headings only, --before compares poses", file.file.string()));
  }
  const Pose2& T_truth_before = *comparison_.compensation->alignment.T_truth_before;
  std::optional<Pose2> T_truth_after;
  if (params_.before_is_another_run) {
    T_truth_after = AlignLevel(file.file, estimate, added_s).T_truth_before;
  }
  auto compensation = evaluation::CompareCompensation(
      truth_, before_, estimate.poses, T_truth_before, Compensation(), T_truth_after);
  comparison_.compensation->estimates.push_back({file.name, std::move(compensation.value())});
}

void Comparer::Add(const files::NamedFile& file) {
  ComparedEstimate compared;
  compared.file = file;
  files::Estimate estimate = Read(file.file, compared);
  auto heading = evaluation::CompareHeadings(estimate.headings, truth_, evaluation_.max_dt_s);
  if (!heading) ThrowNothingInCommon(file.file, estimate, compared.offset_s);
  compared.heading = std::move(*heading);
  compared.matched = static_cast<std::int64_t>(compared.heading.of.size());
  compared.expected = evaluation_.expected.value_or(static_cast<std::int64_t>(truth_.size()));
  if (compared.matched > compared.expected) {
    throw InputError(
        fmt::format("{}: {} stamps, but {} poses of {} have a true one; is it another "
                    "recording's?",
                    params_.expect.string(),
                    compared.expected,
                    compared.matched,
                    file.file.string()));
  }
  if (comparison_.compensation) CompareBefore(file, estimate, compared.offset_s);
  if (!estimate.poses.empty()) {
    compared.errors = evaluation::EvaluateTrajectory(truth_, estimate.poses, evaluation_);
  }
  if (compared.errors && !estimate.covariances.empty()) {
    compared.consistency = evaluation::MeasureConsistency(*compared.errors, estimate.covariances);
  }
  compared.covariances = std::move(estimate.covariances);
  compared.frames_of_status = std::move(estimate.frames_of_status);
  compared.placed = std::move(estimate.placed);
  compared.unplaced = std::move(estimate.unplaced);
  comparison_.estimates.push_back(std::move(compared));
}

}  // namespace

Comparison Compare(const ComparisonInputs& params) {
  const std::vector<files::NamedFile> files = ParseEstimates(params.estimates);
  Comparer comparer(params);
  if (!params.before.empty()) comparer.Before(params.before);
  for (const files::NamedFile& file : files) comparer.Add(file);
  return comparer.Take();
}

}  // namespace ceilmap::reports
