#include "ceilmap_ros/logic/localization_logic.hpp"

#include <utility>

#include "calib/base/error.hpp"
#include "ceilmap_ros/logic/start_pose.hpp"

namespace ceilmap_ros {

LocalizationLogic::LocalizationLogic(const ceilmap::calib::Rig& rig,
                                     const LocalizationOptions& params)
    : params_(params), inbox_(params.inbox), rig_(rig, params.camera_from_info), shared_rig_(rig) {
  params.transform.Validate();
  if (params.mosaic_max_px < 1) throw ceilmap::InputError("mosaic_max_px must be >= 1");
}

LocalizationLogic::~LocalizationLogic() = default;

std::unique_ptr<LocalizationLogic::Localizer> LocalizationLogic::MakeLocalizer(
    const std::filesystem::path& map, const ceilmap::calib::Rig& rig) const {
  return std::make_unique<Localizer>(map, rig, params_.localizer);
}

CeilingGrid LocalizationLogic::LoadMap(const std::filesystem::path& map) {
  Loaded loaded;
  loaded.map = map;
  ceilmap::calib::Rig rig;
  {
    const std::scoped_lock lock(mutex_);
    rig = shared_rig_;
    loaded.rig_revision = rig_revision_;
  }
  try {
    loaded.localizer = MakeLocalizer(map, rig);
    CeilingGrid grid = ReadCeilingGrid(loaded.localizer->Map(), params_.mosaic_max_px);
    const std::scoped_lock lock(mutex_);
    loaded_ = std::move(loaded);
    return grid;
  } catch (const std::exception& error) {
    health_.SetMapError(error.what());
    throw;
  }
}

void LocalizationLogic::TakeLoaded() {
  Loaded loaded;
  {
    const std::scoped_lock lock(mutex_);
    if (!loaded_.localizer) return;
    loaded = std::exchange(loaded_, {});
  }
  health_.SetMap(loaded.map.string());
  current_ = std::move(loaded);
}

void LocalizationLogic::UpdateRig(const Batch& batch) {
  const bool changed = rig_.Update(batch);
  health_.SetCamera(rig_.Ready(), rig_.CameraMismatch());
  if (!changed) return;
  const std::scoped_lock lock(mutex_);
  shared_rig_ = rig_.Get();
  ++rig_revision_;
}

void LocalizationLogic::TakeStart(const Batch& batch) {
  if (batch.start) start_ = WaitingStart{*batch.start, batch.odometry_at_start};
  if (!start_) return;
  current_.localizer->Restart(
      StartAtFrame(start_->request, start_->odometry, batch.odometry_at_frame));
  start_.reset();
}

std::optional<Fix> LocalizationLogic::Locate(const Batch& batch) {
  if (batch.clock_reset) {
    timeline_.Restart(EarliestStamp(batch));
    if (current_.localizer) current_.localizer->Restart();
  }
  UpdateRig(batch);
  if (!rig_.Ready() || !current_.localizer) {
    if (batch.start) start_ = WaitingStart{*batch.start, batch.odometry_at_start};
    return std::nullopt;
  }
  const int revision = [this] {
    const std::scoped_lock lock(mutex_);
    return rig_revision_;
  }();
  if (current_.rig_revision != revision) {
    current_.localizer = MakeLocalizer(current_.map, rig_.Get());
    current_.rig_revision = revision;
  }
  TakeStart(batch);
  AddSensors(batch, timeline_, *current_.localizer);
  const robot::Estimate estimate =
      current_.localizer->AddCeiling({batch.frame.grey, timeline_.At(batch.frame.stamp), index_++});
  return MakeFix(batch, estimate, params_.transform);
}

std::optional<Fix> LocalizationLogic::Step(Stamp now) {
  TakeLoaded();
  const std::optional<Batch> batch = inbox_.Take(now);
  if (!batch) return std::nullopt;
  try {
    std::optional<Fix> fix = Locate(*batch);
    health_.Note(fix, now);
    return fix;
  } catch (const std::exception& error) {
    // The node goes on: the next image may be right.
    health_.NoteError(error.what());
    return std::nullopt;
  }
}

Health LocalizationLogic::Diagnose(Stamp now) const {
  return health_.Judge(inbox_.Counts(), now);
}

}  // namespace ceilmap_ros
