#include "mapping/change/map_pruning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/field_check.hpp"
#include "calib/base/parallel.hpp"
#include "mapping/change/view_comparison.hpp"
#include "mapping/graph/keyframe_removal.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::change {
namespace {

/// Whether a text is a date, or the beginning of one that ends with the day.
bool IsDate(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00Z";
  constexpr std::size_t kDay = 10;
  if (text.size() != kForm.size() && text.size() != kDay) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool digit = std::isdigit(static_cast<unsigned char>(text[i])) != 0;
    if (kForm[i] == '0' ? !digit : text[i] != kForm[i]) return false;
  }
  const std::string month(text.substr(5, 2));
  const std::string day(text.substr(8, 2));
  return month >= "01" && month <= "12" && day >= "01" && day <= "31";
}

/// Of the cells of which an image tells something, the share that are as the mosaic shows them. An
/// image in another light is not worse.
double AgreementOf(const ViewComparison& compared) {
  if (compared.lamps_differ > compared.lamps_alike) return 1;
  int same = 0;
  int differ = 0;
  for (int row = 0; row < compared.states.rows; ++row) {
    const unsigned char* states = compared.states.ptr<unsigned char>(row);
    for (int col = 0; col < compared.states.cols; ++col) {
      const auto state = static_cast<CellState>(states[col]);
      same += state == CellState::kSame ? 1 : 0;
      differ += Differs(state) ? 1 : 0;
    }
  }
  return same + differ == 0 ? 1 : static_cast<double>(same) / (same + differ);
}

/// How well keyframes agree with the mosaic, 0..1, in the order of `which`.
std::vector<double> Agreements(const store::MapReader& map,
                               const std::vector<graph::Keyframe>& keyframes,
                               const std::vector<std::size_t>& which,
                               int threads) {
  std::vector<double> agreements(which.size(), 1);
  if (map.Grid().width_px == 0) return agreements;
  const store::MapMetadata& metadata = map.Metadata();
  const mosaic::HeightMap heights = HeightsOf(map, threads);
  const std::vector<mosaic::ViewPlacement> views = mosaic::PlaceViews(keyframes, metadata);
  const int workers = ThreadsFor(threads);
  std::atomic<std::size_t> next = 0;
  ParallelFor(workers, workers, [&](int /*worker*/) {
    ViewComparer comparer(map, heights);
    for (std::size_t i = next++; i < which.size(); i = next++) {
      agreements[i] = AgreementOf(comparer.Compare({map.ReadImage(keyframes[which[i]].id),
                                                    metadata.view_mask,
                                                    views[which[i]],
                                                    metadata.view_units_per_px}));
    }
  });
  return agreements;
}

/// The redundant keyframes, those that are retired first in front.
std::vector<std::size_t> RetirementOrder(const store::MapReader& map,
                                         const std::vector<graph::Keyframe>& keyframes,
                                         const KeyframeCover& cover,
                                         int threads) {
  // Above this share an image agrees with the mosaic.
  constexpr double kAgrees = 0.9;
  std::vector<std::size_t> redundant;
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    if (cover.IsRedundant(i)) redundant.push_back(i);
  }
  const std::vector<double> agreements = Agreements(map, keyframes, redundant, threads);
  std::vector<std::pair<double, std::size_t>> ranked;
  ranked.reserve(redundant.size());
  for (std::size_t i = 0; i < redundant.size(); ++i) {
    ranked.emplace_back(std::min(agreements[i], kAgrees), redundant[i]);
  }
  std::sort(ranked.begin(), ranked.end());
  for (std::size_t i = 0; i < redundant.size(); ++i) redundant[i] = ranked[i].second;
  return redundant;
}

}  // namespace

void PruneOptions::Validate() const {
  cover.Validate();
  const FieldCheck require("pruning");
  require(threads >= 0, "threads", threads, "at least 0");
  require(!max_bytes || *max_bytes > 0, "max_bytes", 0, "> 0");
  if (before && !IsDate(*before)) {
    throw InputError(
        fmt::format("'{}' is no date; give YYYY-MM-DD, or YYYY-MM-DDThh:mm:ssZ in UTC", *before));
  }
}

store::MapHistory HistorySince(const store::MapHistory& history, const std::string& before) {
  std::set<std::int64_t> old;
  for (const store::Session& session : history.sessions) {
    if (!session.date.empty() && session.date < before) old.insert(session.id);
  }
  store::MapHistory kept;
  std::set<std::int64_t> needed;
  if (!history.sessions.empty()) needed.insert(history.sessions.back().id);
  for (const store::Change& change : history.changes) {
    if (change.state == store::Change::State::kReplaced && old.contains(change.last_session)) {
      continue;
    }
    needed.insert({change.first_session, change.last_session});
    kept.changes.push_back(change);
  }
  // Looks are what the ceiling is like in another light, not what it was.
  kept.looks = history.looks;
  for (const store::Look& look : kept.looks) needed.insert(look.session);
  for (const store::Session& session : history.sessions) {
    if (!old.contains(session.id) || needed.contains(session.id)) kept.sessions.push_back(session);
  }
  return kept;
}

RetirementReport RetireKeyframes(store::MapRevision& revision,
                                 const std::optional<std::uint64_t>& max_bytes,
                                 const KeyframeCoverOptions& cover_options,
                                 int threads,
                                 std::int64_t first_id) {
  RetirementReport report;
  revision.Shrink();
  const store::MapReader& map = revision.Map();
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  report.keyframes = static_cast<std::int64_t>(keyframes.size());
  const auto fits = [&] { return max_bytes && revision.UsedBytes() <= *max_bytes; };
  if (fits()) return report;
  KeyframeCover cover(
      keyframes,
      map.Metadata(),
      [&map](std::int64_t id) { return map.ReadImage(id); },
      cover_options);
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose.T_map_base;
  graph::EdgeReduction edges(map.ReadEdges(), std::move(poses));
  for (const std::size_t i : RetirementOrder(map, keyframes, cover, threads)) {
    if (fits()) break;
    if (keyframes[i].id < first_id || !cover.IsRedundant(i)) continue;
    const std::optional<std::int64_t> heir = edges.Remove(keyframes[i].id);
    if (!heir) continue;
    cover.Retire(i);
    revision.RemoveKeyframe(keyframes[i].id, *heir);
    ++report.retired;
  }
  if (report.retired > 0) revision.SetEdges(edges.Edges());
  report.within_budget = !max_bytes || revision.UsedBytes() <= *max_bytes;
  return report;
}

PruneReport PruneMap(const std::filesystem::path& map,
                     const std::filesystem::path& output,
                     const std::string& provenance,
                     const PruneOptions& options) {
  options.Validate();
  store::MapRevision revision(map, output, provenance);
  PruneReport report;
  report.bytes_before = revision.Map().FileBytes();
  const store::MapHistory history = revision.Map().ReadHistory();
  if (options.before && !history.sessions.empty()) {
    const store::MapHistory kept = HistorySince(history, *options.before);
    report.sessions = static_cast<std::int64_t>(history.sessions.size() - kept.sessions.size());
    report.changes = static_cast<std::int64_t>(history.changes.size() - kept.changes.size());
    revision.SetHistory(kept);
  }
  revision.Shrink();
  if (options.redundant || options.max_bytes) {
    // All that are redundant include those that a budget would choose.
    report.keyframes = RetireKeyframes(revision,
                                       options.redundant ? std::nullopt : options.max_bytes,
                                       options.cover,
                                       options.threads);
  }
  revision.Commit();
  report.bytes_after = std::filesystem::file_size(output);
  if (options.max_bytes) report.keyframes.within_budget = report.bytes_after <= *options.max_bytes;
  return report;
}

}  // namespace ceilmap::change
