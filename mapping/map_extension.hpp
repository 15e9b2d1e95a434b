#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mapping {

/// A recording that extends an existing map. It may begin anywhere on the map; without an overlap
/// the map is not changed.
class MapExtension {
 public:
  /// @param file  the map. @param recording  metadata of a map of the recording alone.
  /// @param resolution  of the map from now on, map units per pixel; unset: it stays.
  /// @param held  kFirstPart: the map's keyframes stay where they are, to the last bit, and the
  /// recording is a session of the map already.
  /// @throws InputError as store::MapReader, and when the recording cannot go into this map.
  MapExtension(const std::filesystem::path& file,
               const store::MapMetadata& recording,
               const std::optional<double>& resolution,
               HeldPoses held = HeldPoses::kFirstKeyframe);

  [[nodiscard]] const store::MapMetadata& Metadata() const { return metadata_; }
  /// To be called once the writer holds the map's name.
  /// @throws InputError when the map has been replaced since it was opened.
  void CheckCurrent() const;
  /// Of the recording's first keyframe in the map (MapperParams::first_keyframe_id).
  [[nodiscard]] std::int64_t NextKeyframeId() const { return next_keyframe_id_; }

  /// Joins both and writes them to `writer`, with the history of the map, to which the recording is
  /// added as a session; looks in another light are kept; without Commit.
  /// @param source  name of the recording, for messages. @param view  of its camera.
  /// @param params  see MergeMaps.
  /// @param progress  done, total tiles of the mosaic.
  /// @throws RunError when the recording does not join the map.
  MappingResult Finish(const std::string& source,
                       const calib::CeilingView& view,
                       const MapperParams& params,
                       Mapper& mapper,
                       store::MapWriter& writer,
                       const std::function<void(int, int)>& progress = {}) const;

 private:
  void WriteHistory(const std::string& source,
                    const MappingResult& result,
                    const graph::MapGraph& graph,
                    store::MapWriter& writer) const;

  std::filesystem::path file_;
  store::MapReader map_;
  store::MapMetadata metadata_;
  HeldPoses held_;
  std::string robot_;  // of the recording
  std::int64_t next_keyframe_id_ = 0;
};

}  // namespace ceilmap::mapping
