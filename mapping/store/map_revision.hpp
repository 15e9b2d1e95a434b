#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_history.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::store {

/// A copy of a map in which parts are replaced: everything else stays as it is, byte by byte where
/// SQLite does not move it. Like MapWriter, the result appears complete or not at all; from the
/// start of the object no other writer can write to its name. Not thread-safe. All calls throw
/// RunError when the disk cannot be written.
class MapRevision {
 public:
  /// @param output  May be the map itself. @param provenance  Added to that of the map.
  /// @throws InputError as MapReader and AtomicFile, and for a map on a server.
  MapRevision(const std::filesystem::path& map,
              const std::filesystem::path& output,
              const std::string& provenance);
  ~MapRevision();
  MapRevision(const MapRevision&) = delete;
  MapRevision& operator=(const MapRevision&) = delete;

  /// The map as it was.
  [[nodiscard]] const MapReader& Map() const;

  /// Replaces a window of the mosaic, and what is made of it in the pyramid.
  /// @param grey, alpha  CV_8UC1 of the window's size, which lies inside the mosaic. Windows of
  /// whole tiles of 256 px are fastest.
  void WriteMosaic(const cv::Rect& window, const cv::Mat& grey, const cv::Mat& alpha);
  /// Another image of a keyframe, CV_8UC1 of the view's size, and its descriptors.
  struct NewImage {
    std::int64_t keyframe_id = 0;
    cv::Mat image;
    cv::Mat descriptors;
  };
  /// Replaces images of keyframes. They are compressed in parallel and written in their order.
  /// @throws InputError for an image of another size or type; then none is replaced.
  void ReplaceImages(const std::vector<NewImage>& images, int threads);
  /// Replaces the map's history.
  void SetHistory(const MapHistory& history);
  /// Bytes of the file that hold data, with what was replaced and removed so far: about its size
  /// after Shrink().
  [[nodiscard]] std::uint64_t UsedBytes() const;
  /// Removes a keyframe and all that is stored of it, except its edges: SetEdges must follow. The
  /// frames and weak spots that belong to it belong to another one from then on; their poses stay.
  void RemoveKeyframe(std::int64_t id, std::int64_t heir);
  /// Replaces all edges. Their keyframes are in the map.
  void SetEdges(const std::vector<graph::Edge>& edges);
  /// Lets Commit() give the space of what was removed back to the disk. It rewrites the file.
  void Shrink();
  /// Replaces the map's place in its building: metadata `site_*` and the layer `control_points`.
  /// @throws InputError for one that cannot be stored.
  void SetSiteFrame(const survey::SiteFrame& site);

  /// @throws InputError when the map was changed by another program since it was opened.
  void Commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::store
