#include "ceilmap_ros/logic/mapping_logic.hpp"

#include <fmt/format.h>

#include <utility>

#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

/// Appears complete or not at all.
void CopyFile(const std::filesystem::path& from, const std::filesystem::path& to) {
  ceilmap::AtomicFile file(to);
  std::filesystem::copy_file(
      from, file.PartialPath(), std::filesystem::copy_options::overwrite_existing);
  file.Commit();
}

}  // namespace

MappingLogic::MappingLogic(const ceilmap::calib::Rig& rig, const MappingOptions& params)
    : params_(params), inbox_(params.inbox), rig_(rig, params.camera_from_info) {
  params.transform.Validate();
  if (params.mosaic_max_px < 512) throw ceilmap::InputError("mosaic_max_px must be >= 512");
  // Here and not with the first image, so that a map that cannot be written is refused at once.
  MakeMapper();
  health_.SetMap(params.map.string());
  health_.SetCamera(rig_.Ready(), "");
}

MappingLogic::~MappingLogic() = default;

void MappingLogic::MakeMapper() {
  mosaic_.reset();
  mapper_.reset();  // it holds the file's name
  mapper_ = std::make_unique<robot::CeilingMapper>(rig_.Get(), params_.map, params_.mapper);
  mosaic_.emplace(mapper_->View(), params_.mosaic_max_px);
}

void MappingLogic::RequestSave(const std::filesystem::path& copy, const SaveDone& done) {
  {
    const std::scoped_lock lock(mutex_);
    save_ = Save{copy, done};
  }
  inbox_.Wake();
}

SaveResult MappingLogic::Finish() {
  // The mapper takes no image after this, whether or not it succeeds.
  mosaic_.reset();
  const std::unique_ptr<robot::CeilingMapper> mapper = std::move(mapper_);
  try {
    const std::size_t placed = mapper->Finish().frames.size();
    return {true, fmt::format("{}: {} images; mapping has ended", params_.map.string(), placed)};
  } catch (const std::exception& error) {
    return {false, fmt::format("{}; restart the node", error.what())};
  }
}

SaveResult MappingLogic::SaveMap(const std::filesystem::path& copy) {
  if (!ended_) {
    if (mapper_->PlacedFrames() == 0) return {false, "no image was mapped yet; drive first"};
    ended_ = Finish();
    health_.NoteEnd(ended_->success, ended_->message);
  }
  if (!ended_->success || copy.empty() || copy == params_.map) return *ended_;
  try {
    CopyFile(params_.map, copy);
    return {true, fmt::format("{}; copied to {}", ended_->message, copy.string())};
  } catch (const std::exception& error) {
    return {false, fmt::format("{}; the copy failed: {}", ended_->message, error.what())};
  }
}

std::optional<Fix> MappingLogic::Add(const Batch& batch) {
  if (batch.clock_reset) timeline_.Restart(EarliestStamp(batch));
  RigState rig = rig_;
  const bool changed = rig.Update(batch);
  if (changed && mapper_->PlacedFrames() > 0) {
    throw ceilmap::InputError("the camera changed while the map grew; save the map and restart");
  }
  rig_ = std::move(rig);
  health_.SetCamera(rig_.Ready(), rig_.CameraMismatch());
  if (!rig_.Ready()) return std::nullopt;
  if (changed) MakeMapper();
  AddSensors(batch, timeline_, *mapper_);
  const robot::Estimate estimate =
      mapper_->AddCeiling({batch.frame.grey, timeline_.At(batch.frame.stamp), index_++});
  if (estimate.HasPose()) mosaic_->Add(mapper_->Rectified(), estimate.pose.pose);
  Fix fix = MakeFix(batch, estimate, params_.transform);
  if (params_.mapper.append) {
    fix.pose.reset();
    fix.map_to_odom.reset();
  }
  return fix;
}

std::optional<Fix> MappingLogic::Step(Stamp now) {
  std::optional<Save> save;
  {
    const std::scoped_lock lock(mutex_);
    save = std::exchange(save_, std::nullopt);
  }
  if (save) {
    save->done(SaveMap(save->copy));
    return std::nullopt;
  }
  const std::optional<Batch> batch = inbox_.Take(now);
  if (!batch || !mapper_) return std::nullopt;
  try {
    std::optional<Fix> fix = Add(*batch);
    health_.Note(fix, now);
    return fix;
  } catch (const std::exception& error) {
    health_.NoteError(error.what());
    return std::nullopt;
  }
}

CeilingGrid MappingLogic::Preview() const {
  if (ended_ && ended_->success) {
    return ReadCeilingGrid(ceilmap::store::MapReader(params_.map), params_.mosaic_max_px);
  }
  if (!mosaic_) return {};
  const ceilmap::mosaic::Mosaic mosaic = mosaic_->Copy();
  return ToCeilingGrid(mosaic.grid, mosaic.grey, mosaic.alpha);
}

Health MappingLogic::Diagnose(Stamp now) const {
  return health_.Judge(inbox_.Counts(), now);
}

}  // namespace ceilmap_ros
