#include "app/commands/localize_files.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "app/files/hypotheses_csv.hpp"
#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"

namespace ceilmap::commands {

LocalizeFiles::LocalizeFiles(LocalizeOutputs outputs, const calib::LevelView& level)
    : outputs_(std::move(outputs)),
      level_(level),
      trajectory_(outputs_.trajectory, outputs_.predicted),
      uncompensated_(outputs_.uncompensated, outputs_.predicted),
      status_(outputs_.status),
      hypotheses_(outputs_.hypotheses) {
  status_.Append(files::StatusHeader());
  hypotheses_.Append(files::HypothesesHeader());
}

void LocalizeFiles::Add(const robot::Estimate& estimate) {
  status_.Append(files::FormatStatusLine(estimate));
  hypotheses_.Append(files::FormatHypotheses(estimate));
  const bool placed = trajectory_.Add(estimate);
  graph::FramePose frame = robot::ToFramePose(estimate);
  if (placed) frame.T_map_base = level_.Uncompensated(frame.T_map_base, frame.tilt);
  frame.tilt = {};
  uncompensated_.Add(frame);
  if (!outputs_.stream || !placed) return;
  fmt::print(
      "{}",
      files::FormatTumLine(ToStampedPose(estimate.stamp_s, estimate.pose.pose, estimate.tilt)));
  std::fflush(stdout);
}

void LocalizeFiles::CommitStatus() {
  status_.Commit();
  hypotheses_.Commit();
}

void LocalizeFiles::Commit(terminal::Summary& summary) {
  trajectory_.Commit();
  uncompensated_.Commit();
  CommitStatus();
  for (const std::filesystem::path& file :
       {outputs_.trajectory, outputs_.uncompensated, outputs_.status, outputs_.hypotheses}) {
    if (!file.empty()) summary.files.push_back(file);
  }
}

}  // namespace ceilmap::commands
