#include "app/files/trajectory_file.hpp"

#include <fmt/format.h>

#include "app/bags/message_encoding.hpp"
#include "app/files/tum.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::files {

bool IsBagName(const std::filesystem::path& file) {
  return file.extension() == ".mcap";
}

TrajectoryFile::TrajectoryFile(const std::filesystem::path& target, bool predicted)
    : target_(target),
      predicted_(predicted),
      text_(IsBagName(target) ? std::filesystem::path() : target) {
  if (IsBagName(target)) {
    writer_.emplace(target);
    bag_.emplace(*writer_);
  } else {
    text_.Append(TumHeader());
  }
}

void TrajectoryFile::CheckStamp(double stamp_s) const {
  if (!bag_) return;
  try {
    bags::Nanoseconds(stamp_s);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", target_.string(), error.what()));
  }
}

bool TrajectoryFile::Add(const graph::FramePose& frame) {
  return Add(frame, {});
}

bool TrajectoryFile::Add(const robot::Estimate& estimate) {
  TrajectoryBag::Values values;
  if (bag_) {
    values = {{"peak", fmt::format("{:.3f}", estimate.peak)},
              {"inliers", fmt::format("{}", estimate.inliers)},
              {"blocks", fmt::format("{}", estimate.blocks)},
              {"hypotheses", fmt::format("{}", estimate.hypotheses)}};
  }
  return Add(robot::ToFramePose(estimate), values);
}

bool TrajectoryFile::Add(const graph::FramePose& frame, const TrajectoryBag::Values& values) {
  const bool with_pose = graph::HasPose(frame.status) ||
                         (predicted_ && frame.status == graph::TrackingStatus::kPredicted);
  if (bag_) {
    CheckStamp(frame.stamp_s);
    bag_->Add(frame, with_pose, values);
  } else if (with_pose) {
    text_.Append(FormatTumLine(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt)));
  }
  return with_pose;
}

void TrajectoryFile::Close() {
  if (writer_) writer_->Close();
  text_.Close();
}

void TrajectoryFile::Commit() {
  if (writer_) writer_->Commit();
  text_.Commit();
}

}  // namespace ceilmap::files
