#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/reports/map_report.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/mapper.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// A map that a recording is appended to (`map --append`), and what the two together are.
class Appending {
 public:
  /// @param file  the map. @param recording  what a map of the recording alone would say of itself.
  /// @param resolution  of the map from now on; unset: it stays.
  /// @throws InputError as MapReader, and when the recording cannot go into this map.
  Appending(const std::filesystem::path& file,
            const store::MapMetadata& recording,
            const std::optional<double>& resolution);

  [[nodiscard]] const store::MapMetadata& Metadata() const { return metadata_; }
  /// To be called when the map's name is held by its writer.
  /// @throws InputError when another has replaced the map since it was opened.
  void CheckCurrent() const;
  /// Of the recording's first keyframe in the map.
  [[nodiscard]] std::int64_t NextKeyframeId() const { return next_keyframe_id_; }

  /// Joins both and writes them to `writer`, without Commit.
  /// @param source  name of the recording, for messages. @param view  of its camera.
  /// @return frames of the recording, and what is known of the whole map.
  /// @throws RunError when the recording does not join the map.
  MapResult Finish(const std::string& source,
                   const calib::CeilingView& view,
                   mapping::Mapper& mapper,
                   store::MapWriter& writer) const;

 private:
  std::filesystem::path file_;
  store::MapReader map_;
  store::MapMetadata metadata_;
  std::int64_t next_keyframe_id_ = 0;
};

}  // namespace ceilmap::reports
