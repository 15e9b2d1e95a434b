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

void LocalizeFiles::Add(const robot::Estimate& in_map) {
  const std::optional<survey::SiteFrame>& site = outputs_.site;
  const robot::Estimate estimate = site ? robot::InSite(in_map, *site) : in_map;
  status_.Append(files::FormatStatusLine(estimate));
  hypotheses_.Append(files::FormatHypotheses(estimate));
  const bool placed = trajectory_.Add(estimate);
  AddUncompensated(in_map, placed);
  if (!outputs_.stream || !placed) return;
  fmt::print(
      "{}",
      files::FormatTumLine(ToStampedPose(estimate.stamp_s, estimate.pose.pose, estimate.tilt)));
  std::fflush(stdout);
}

/// The effect of a tilt is known in the map's scale.
void LocalizeFiles::AddUncompensated(const robot::Estimate& in_map, bool placed) {
  graph::FramePose frame = robot::ToFramePose(in_map);
  if (placed) frame.T_map_base = level_.Uncompensated(frame.T_map_base, frame.tilt);
  if (placed && outputs_.site) frame.T_map_base = outputs_.site->S_site_map * frame.T_map_base;
  frame.tilt = {};
  uncompensated_.Add(frame);
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
