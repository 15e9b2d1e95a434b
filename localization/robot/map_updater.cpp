#include "localization/robot/map_updater.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/stage_timer.hpp"
#include "mapping/change/change_evidence.hpp"
#include "mapping/change/change_regions.hpp"
#include "mapping/change/history_update.hpp"
#include "mapping/change/light_looks.hpp"
#include "mapping/change/map_refresh.hpp"
#include "mapping/change/view_comparison.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/store/map_revision.hpp"

namespace ceilmap::robot {
namespace {

// A robot that is lost for fewer frames has not left the map; the first search takes longer.
constexpr std::int64_t kMinLost = 3;
constexpr std::int64_t kMinSearch = 10;

/// Whether a pose is exact enough for pixels to be compared.
bool IsExact(const Estimate& estimate, const localization::SeenCeiling& seen) {
  constexpr double kMaxSigmaPx = 2;
  const Eigen::Matrix3d& covariance = estimate.pose.covariance;
  const double half_diagonal = 0.5 * std::hypot(seen.grey.cols, seen.grey.rows);
  return std::sqrt(covariance(0, 0) + covariance(1, 1)) < kMaxSigmaPx * seen.m_per_px &&
         std::sqrt(covariance(2, 2)) * half_diagonal < kMaxSigmaPx;
}

mosaic::ViewPlacement PlacementOf(const localization::SeenCeiling& seen) {
  return {seen.T_map_view,
          seen.grey.size(),
          seen.m_per_px,
          {seen.principal_px.x(), seen.principal_px.y()}};
}

}  // namespace

void MapUpdaterOptions::Validate() const {
  const FieldCheck require("map updater");
  require(min_step > 0, "min_step", min_step, "> 0");
  require(min_turn_rad > 0, "min_turn_rad", min_turn_rad, "> 0");
  require(min_placed >= 0 && min_placed <= 1, "min_placed", min_placed, "in [0, 1]");
  require(max_changed >= 0 && max_changed <= 1, "max_changed", max_changed, "in [0, 1]");
  require(threads >= 0, "threads", threads, "at least 0");
}

struct MapUpdater::Impl {
  Impl(const std::filesystem::path& map,
       const std::filesystem::path& output,
       const std::string& provenance,
       const MapUpdaterOptions& update_options)
      : options(update_options),
        name(map),
        revision(map, output, provenance),
        heights(change::HeightsOf(revision.Map(), update_options.threads)),
        comparer(revision.Map(), heights),
        evidence(change::CellsOf(revision.Map().Grid())) {}

  [[nodiscard]] bool IsDue(const localization::SeenCeiling& seen) const;
  [[nodiscard]] bool LeftMap(const std::optional<mosaic::ViewPlacement>& next) const;
  [[nodiscard]] bool IsAtBorder(const mosaic::ViewPlacement& view) const;
  void NotePlaced(const localization::SeenCeiling& seen);
  void Compare(const localization::SeenCeiling& seen);
  void AwaitComparison();
  void CheckBelongs(const change::SessionOutcome& outcome) const;

  MapUpdaterOptions options;
  std::filesystem::path name;
  store::MapRevision revision;
  mosaic::HeightMap heights;
  change::ViewComparer comparer;
  change::ChangeEvidence evidence;
  std::optional<Pose2> last;  // view that was compared last
  std::int64_t frames = 0;
  std::int64_t placed = 0;
  std::int64_t unplaced_run = 0;                     // frames since the last one that was placed
  std::optional<mosaic::ViewPlacement> last_placed;  // its view
  cv::Size view_size;
  MapUpdateReport report;
  std::future<void> comparison;  // the latest; last, so that it ends before what it uses
};

bool MapUpdater::Impl::IsDue(const localization::SeenCeiling& seen) const {
  if (!last) return true;
  const double shorter = std::min(seen.grey.cols, seen.grey.rows) * seen.m_per_px;
  const double travel = (seen.T_map_view.Translation() - last->Translation()).norm();
  return travel > options.min_step * shorter ||
         std::abs(WrapAngle(seen.T_map_view.yaw - last->yaw)) > options.min_turn_rad;
}

/// Whether much of a view lies beyond the mosaic.
bool MapUpdater::Impl::IsAtBorder(const mosaic::ViewPlacement& view) const {
  constexpr int kSteps = 8;
  constexpr double kMinInside = 0.75;
  const store::MosaicGrid& grid = revision.Map().Grid();
  const cv::Rect all(0, 0, grid.width_px, grid.height_px);
  int inside = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const int column = i % kSteps;
    const int row = i / kSteps;
    const double u = (column + 0.5) / kSteps * view_size.width;
    const double v = (row + 0.5) / kSteps * view_size.height;
    const cv::Point2d p = view.ToMap(u, v);
    const cv::Point pixel(cvFloor((p.x - grid.min_x) / grid.resolution),
                          cvFloor((grid.max_y - p.y) / grid.resolution));
    if (!all.contains(pixel)) continue;
    cv::Mat grey;
    cv::Mat alpha;
    revision.Map().ReadMosaic({pixel, cv::Size(1, 1)}, grey, alpha);
    inside += alpha.ptr(0)[0] == 255 ? 1 : 0;
  }
  return inside < kMinInside * kSteps * kSteps;
}

/// A robot that was lost beside the border of the map had left it, or comes from outside.
/// @param next  the view with which it was found again.
bool MapUpdater::Impl::LeftMap(const std::optional<mosaic::ViewPlacement>& next) const {
  if (unplaced_run < (last_placed ? kMinLost : kMinSearch)) return false;
  return (last_placed && IsAtBorder(*last_placed)) || (next && IsAtBorder(*next));
}

void MapUpdater::Impl::NotePlaced(const localization::SeenCeiling& seen) {
  const mosaic::ViewPlacement view = PlacementOf(seen);
  view_size = seen.grey.size();
  if (unplaced_run > 0) AwaitComparison();
  report.left_map = report.left_map || LeftMap(view);
  unplaced_run = 0;
  last_placed.emplace(view);
}

/// A recording of another building must not change the map.
void MapUpdater::Impl::CheckBelongs(const change::SessionOutcome& outcome) const {
  const auto refuse = [&](const std::string& what) {
    throw RunError(
        fmt::format("{}; the recording is not of the ceiling of {}, and nothing was changed",
                    what,
                    name.string()));
  };
  if (static_cast<double>(placed) < options.min_placed * static_cast<double>(frames)) {
    refuse(fmt::format("only {} of {} frames were placed", placed, frames));
  }
  const double differs = outcome.changed_area + outcome.candidate_area;
  if (differs > options.max_changed * outcome.seen_area) {
    refuse(fmt::format("{:.0f} % of what was seen differs", 100 * differs / outcome.seen_area));
  }
}

MapUpdater::MapUpdater(const std::filesystem::path& map,
                       const std::filesystem::path& output,
                       const std::string& provenance,
                       const MapUpdaterOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>(map, output, provenance, options);
  if (impl_->revision.Map().Grid().width_px == 0) {
    throw InputError(map.string() + ": has no mosaic to compare a recording with");
  }
}
MapUpdater::~MapUpdater() = default;

void MapUpdater::Add(const Estimate& estimate) {
  Impl& me = *impl_;
  ++me.frames;
  if (!estimate.HasPose()) {
    ++me.unplaced_run;
    return;
  }
  ++me.placed;
  if (estimate.seen) me.NotePlaced(*estimate.seen);
  if (!estimate.seen || !IsExact(estimate, *estimate.seen) || !me.IsDue(*estimate.seen)) return;
  me.last = estimate.seen->T_map_view;
  me.Compare(*estimate.seen);
}

/// While the next frame is localized, on another core. One comparison at a time: their order, and
/// with it the map, does not depend on threads.
void MapUpdater::Impl::Compare(const localization::SeenCeiling& seen) {
  AwaitComparison();
  localization::SeenCeiling kept = seen;
  kept.grey = seen.grey.clone();  // the next frame uses its memory again
  comparison = std::async(
      options.threads == 1 ? std::launch::deferred : std::launch::async,
      [this, kept = std::move(kept)] {
        const StageTimer timer(report.compare_ms);
        evidence.Add(comparer.Compare({kept.grey, kept.mask, PlacementOf(kept), kept.m_per_px}));
      });
}

void MapUpdater::Impl::AwaitComparison() {
  if (comparison.valid()) comparison.get();
}

MapUpdateReport MapUpdater::Finish(store::Session session) {
  Impl& me = *impl_;
  me.AwaitComparison();
  std::optional<StageTimer> timer(std::in_place, me.report.refresh_ms);
  session.frames = me.frames;
  session.placed = me.placed;
  const store::MapReader& map = me.revision.Map();
  const std::vector<change::ChangedRegion> regions = change::FindChanges(me.evidence);
  change::SessionOutcome outcome = change::DecideChanges(
      me.evidence, regions, map.Grid(), map.ReadHistory(), std::move(session), me.options.at_once);
  me.CheckBelongs(outcome);
  me.report.left_map = me.report.left_map || me.LeftMap(std::nullopt);
  me.report.views = me.evidence.Views();
  me.report.confirmed = outcome.confirmed;
  me.report.candidates = outcome.candidates;
  me.report.session = outcome.history.sessions.back();
  me.report.keyframes =
      change::RefreshMap(me.evidence, outcome.fresh, me.heights, me.revision, me.options.threads)
          .keyframes;
  outcome.history.looks = change::UpdateLooks(
      std::move(outcome.history.looks), me.evidence, regions, outcome.fresh, me.report.session.id);
  me.revision.SetHistory(outcome.history);
  if (me.options.max_bytes) {
    me.report.retirement =
        change::RetireKeyframes(me.revision, me.options.max_bytes, {}, me.options.threads);
  }
  me.revision.Commit();
  timer.reset();
  return me.report;
}

}  // namespace ceilmap::robot
