#include "mapping/map_extension.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "calib/base/error.hpp"
#include "calib/base/result_date.hpp"
#include "mapping/common_view.hpp"
#include "mapping/history_union.hpp"
#include "mapping/map_union.hpp"

namespace ceilmap::mapping {

MapExtension::MapExtension(const std::filesystem::path& file,
                           const store::MapMetadata& recording,
                           const std::optional<double>& resolution,
                           HeldPoses held)
    : file_(file), map_(file), metadata_(map_.Metadata()), held_(held), robot_(recording.robot) {
  const std::string problem = Incompatibility(metadata_, recording);
  if (!problem.empty()) throw InputError(fmt::format("{}: {}", file.string(), problem));
  if (resolution) metadata_.resolution = *resolution;
  if (metadata_.view_focal_px == 0) {  // a map of an earlier version; the camera is of one kind
    metadata_.view_focal_px = recording.view_focal_px;
    metadata_.view_principal_px = recording.view_principal_px;
  }
  metadata_.provenance += "\n" + recording.provenance;
  metadata_.program_version = recording.program_version;
  for (const graph::Keyframe& keyframe : map_.ReadKeyframes()) {
    next_keyframe_id_ = keyframe.id + 1;
  }
}

void MapExtension::CheckCurrent() const {
  map_.CheckCurrent();
}

MappingResult MapExtension::Finish(const std::string& source,
                                   const calib::CeilingView& view,
                                   const MapperParams& params,
                                   Mapper& mapper,
                                   store::MapWriter& writer,
                                   const std::function<void(int, int)>& progress) const {
  mapper.Close();
  const MergeResult merged =
      AppendRecording(map_, mapper.Graph(), view, metadata_, params, writer, progress, held_);
  if (!merged.ok()) {
    throw RunError(fmt::format("{} cannot be joined with {}: {}; the map is not changed",
                               source,
                               file_.string(),
                               merged.results.back().reason));
  }
  MappingResult result;
  result.report = mapper.Report();
  result.weak_spots = merged.graph.weak_spots;
  for (const graph::FramePose& frame : merged.graph.trajectory) {
    if (frame.keyframe_id >= next_keyframe_id_) result.Add(frame);
  }
  result.report.grid = merged.grid;
  result.report.left_out = merged.left_out;
  result.report.quality = merged.graph.quality;
  result.report.keyframes = static_cast<std::int64_t>(merged.graph.keyframes.size());
  WriteHistory(source, result, merged.graph, writer);
  return result;
}

/// Also the recording is a session; what it saw of the map was not compared with it.
void MapExtension::WriteHistory(const std::string& source,
                                const MappingResult& result,
                                const graph::MapGraph& graph,
                                store::MapWriter& writer) const {
  const std::vector<graph::Keyframe> before = map_.ReadKeyframes();
  store::MapHistory history = map_.ReadHistory();
  std::vector<store::Look> looks =
      MoveLooks(history.looks, {map_.Grid(), before}, {result.report.grid, graph.keyframes});
  history = UniteHistories({{std::move(history), before}}, graph);
  history.looks = std::move(looks);
  if (held_ == HeldPoses::kFirstPart) {
    writer.WriteHistory(history);
    return;
  }
  store::Session session;
  session.id = history.sessions.empty() ? 1 : history.sessions.back().id + 1;
  session.date = ResultDate();
  session.source = std::filesystem::path(source).filename().string();
  session.robot = robot_;
  session.program_version = metadata_.program_version;
  session.frames = result.report.frames;
  session.placed = static_cast<std::int64_t>(result.frames.size());
  history.sessions.push_back(std::move(session));
  writer.WriteHistory(history);
}

}  // namespace ceilmap::mapping
