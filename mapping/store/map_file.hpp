#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_history.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::store {

/// Extent of a mosaic and position of its pixels in the map: pixel (col, row) of the full mosaic
/// has its CENTRE at
///   x = min_x + (col + 0.5) * resolution,  y = max_y - (row + 0.5) * resolution.
/// The mosaic is stored as seen from above: x right, y up, mirrored relative to an image from below
/// (mapping/README.md, "Pixels").
struct MosaicGrid {
  double min_x = 0;
  double max_y = 0;
  double resolution = 0;
  int width_px = 0;
  int height_px = 0;
};

/// A band of the rows of a map's mosaic, in a file of its own (mapping/mosaic/mosaic_parts.hpp).
struct MosaicPart {
  int part = 1;             ///< 1 to `parts`
  int parts = 1;            ///< in all
  MosaicGrid whole;         ///< of the mosaic of the map
  std::uint64_t graph = 0;  ///< graph::Fingerprint of the map
};

/// Metadata of a map.
struct MapMetadata {
  int format_version = 2;
  std::string unit = "m";       ///< "m", or "px" for a map without a rig
  double resolution = 0;        ///< mosaic: units per mosaic pixel, > 0
  double ceiling_height_m = 0;  ///< above the floor; 0 without a rig
  std::string rig_yaml;         ///< text of the rig file, empty without a rig
  std::string robot;
  cv::Size view_size;            ///< size of the keyframe images
  double view_units_per_px = 0;  ///< units on the ceiling per keyframe image pixel
  Pose2 T_base_view;             ///< CeilingView::T_base_view of the mapping camera
  /// CeilingView::FocalLength of the mapping camera; 0: not known, all heights are then relative.
  double view_focal_px = 0;
  /// Its principal point, from the centre ((W-1)/2, (H-1)/2) of the keyframe images, pixels.
  Eigen::Vector2d view_principal_px = Eigen::Vector2d::Zero();
  cv::Mat view_mask;  ///< CeilingView::Mask of the keyframe images; empty: none
  std::string program_version;
  std::string provenance;  ///< command line, source names, date; free text
  /// The map in the coordinates of its building; nothing: not aligned (survey::Align).
  std::optional<survey::SiteFrame> site;
  /// The file holds a part of the mosaic of the map that these metadata describe, and nothing else.
  std::optional<MosaicPart> part;
};

/// Height above the floor, metres, of a point of the ceiling with inverse height ratio `rho` > 0
/// (mapping/heights/height_field.hpp); nothing where the focal length or the height of the ceiling
/// is not known.
std::optional<double> HeightAboveFloor(const MapMetadata& metadata, double rho);

/// Place in the map of a pixel of the mosaic; (0, 0) is the centre of the first one.
Eigen::Vector2d PixelToMap(const MosaicGrid& grid, const Eigen::Vector2d& col_row);

/// Places that images of a map show, but that are not part of its mosaic.
struct LeftOut {
  enum class Kind {
    kBelowCeiling,  ///< only walls, windows and furniture are seen there, not the ceiling
    kMoves,         ///< a thing moves there (a fan); the mosaic shows what is behind it
  };
  Kind kind = Kind::kBelowCeiling;
  double area = 0;  ///< of the reference plane, map units^2
  Polygons polygons;
};
const char* ToString(LeftOut::Kind kind);

/// Fills a window of the mosaic: grey and alpha, both CV_8UC1 of the window's size (alpha 0:
/// unmapped).
using MosaicSource = std::function<void(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha)>;

class MapReader;

/// Writes NAME.gpkg: an OGC GeoPackage with the layers `mosaic` (raster tile pyramid, grey +
/// alpha), `keyframes`, `trajectory`, `edges`, `weak_spots`, `left_out`, `control_points` (vector)
/// and the tables `keyframe_pictures`, `place_descriptors`, `keyframe_heights`, `view_mask`,
/// `ceilmap_metadata`.
///
/// All data are written to a partial file beside the target (with a fixed name, so that the next
/// run replaces the partial file of a killed one); Commit() closes it, syncs it to disk and renames
/// it over the target: at any moment the target is the old map or the new one. Without Commit() the
/// destructor removes the partial file. Not thread-safe. All calls throw RunError when the disk
/// cannot be written (full, read-only).
class MapWriter {
 public:
  /// @throws InputError when the folder of `file` does not exist or cannot be written, or the name
  /// does not end in .gpkg.
  MapWriter(const std::filesystem::path& file, MapMetadata metadata);
  /// Begins with a copy of a map that has no mosaic yet: only WriteLeftOut and WriteMosaic are left
  /// to be called.
  /// @param metadata  of this map. @param map  a local file.
  MapWriter(const std::filesystem::path& file,
            MapMetadata metadata,
            const std::filesystem::path& map);
  ~MapWriter();
  MapWriter(const MapWriter&) = delete;
  MapWriter& operator=(const MapWriter&) = delete;

  /// Stores the image losslessly; its pose is added later by WriteKeyframes. Memory is bounded: the
  /// image is not kept.
  void AddImage(std::int64_t keyframe_id, const cv::Mat& image);
  /// Copies a keyframe's image and descriptors from another map, whose views have the same size and
  /// scale.
  void CopyImage(const MapReader& from, std::int64_t id_there, std::int64_t keyframe_id);
  /// Removes the image and descriptors of a keyframe that will not be in the map.
  void RemoveImage(std::int64_t keyframe_id);
  /// Stores the place descriptors of a keyframe for global localization and joining, see
  /// PlaceDescriber.
  void AddDescriptors(std::int64_t keyframe_id, const cv::Mat& descriptors);
  [[nodiscard]] cv::Mat ReadDescriptors(std::int64_t keyframe_id) const;  ///< as ReadImage
  /// Reads a stored image (for loop closing and for rendering the mosaic). Thread-safe, also while
  /// WriteMosaic runs.
  [[nodiscard]] cv::Mat ReadImage(std::int64_t keyframe_id) const;

  /// Writes everything except images and mosaic, once, before Commit.
  /// @throws InputError for an edge whose keyframes are not in the graph.
  void WriteGraph(const graph::MapGraph& graph);
  /// Adds places that are not part of the mosaic.
  void WriteLeftOut(const std::vector<LeftOut>& places);
  /// Writes the map's history, at most once; nothing of an empty one.
  void WriteHistory(const MapHistory& history);
  /// Renders the mosaic by windows (aligned to tiles) and builds its pyramid.
  /// @param grid  Without pixels: the map has no mosaic.
  /// @param source  Called for one window at a time, from another thread: the next window is
  /// rendered while this one is written.
  /// @param progress  Called with done/total windows; may be empty.
  void WriteMosaic(const MosaicGrid& grid,
                   const MosaicSource& source,
                   const std::function<void(int, int)>& progress = {});
  void Commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a GeoPackage of ceilmap holds.
enum class FileKind { kMap, kMosaicPart };

/// Reads a map. @throws InputError when the file is missing, no GeoPackage, no ceilmap map,
/// damaged, or of another format version (with a solution in each message). Thread-safe.
///
/// A map may stand on a server: https://HOST/MAP.gpkg, http://..., /vsicurl/URL, /vsis3/BUCKET/KEY
/// (IsRemoteName). Then only the parts that are asked for are read, once: they are kept in memory
/// and in a cache on disk (README.md). All calls also throw RunError when the server does not
/// answer for about half a minute, or has another version of the map than the one that was opened.
class MapReader {
 public:
  /// @param file  a local file, or a name for which IsRemoteName. @param kind  any other is
  /// refused.
  explicit MapReader(const std::filesystem::path& file, FileKind kind = FileKind::kMap);
  ~MapReader();
  MapReader(const MapReader&) = delete;
  MapReader& operator=(const MapReader&) = delete;

  /// Checks that the file was not changed. A program that replaces this map by a new one calls it
  /// after the MapWriter has locked the name, so that changes by others are not lost.
  /// @throws InputError unless the file's name still refers to the file that this object reads,
  /// unchanged; RunError of a map on a server.
  void CheckCurrent() const;

  [[nodiscard]] bool IsRemote() const;            ///< on a server
  [[nodiscard]] std::uint64_t FileBytes() const;  ///< size of the file

  [[nodiscard]] const MapMetadata& Metadata() const;
  [[nodiscard]] const MosaicGrid& Grid() const;  ///< of 0 x 0 pixels when the map has no mosaic
  /// By id, with heights, without images.
  [[nodiscard]] std::vector<graph::Keyframe> ReadKeyframes() const;
  /// Whether any keyframe has heights.
  [[nodiscard]] bool HasHeights() const;
  [[nodiscard]] cv::Mat ReadImage(std::int64_t keyframe_id) const;
  /// CV_32FC1 as returned by PlaceDescriber.
  [[nodiscard]] cv::Mat ReadDescriptors(std::int64_t keyframe_id) const;
  /// The stored image, PNG.
  [[nodiscard]] std::vector<unsigned char> ReadPng(std::int64_t keyframe_id) const;
  [[nodiscard]] std::vector<graph::FramePose> ReadTrajectory() const;
  [[nodiscard]] std::vector<graph::Edge> ReadEdges() const;
  [[nodiscard]] std::vector<graph::WeakSpot> ReadWeakSpots() const;
  /// Empty in maps of earlier versions.
  [[nodiscard]] std::vector<LeftOut> ReadLeftOut() const;
  /// Empty for a map that was never updated.
  [[nodiscard]] MapHistory ReadHistory() const;
  /// Of the history: the looks in another light.
  [[nodiscard]] std::vector<Look> ReadLooks() const;
  [[nodiscard]] const graph::MapQuality& Quality() const;
  /// All of these. @throws InputError also when they are inconsistent (an edge or a frame refers to
  /// a missing keyframe).
  [[nodiscard]] graph::MapGraph ReadGraph() const;
  /// A window of the mosaic at full resolution; must lie inside the grid.
  void ReadMosaic(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const;
  /// The whole mosaic, each pixel the mean of n x n pixels, n the smallest power of two with which
  /// no side has more than max_px; up to n - 1 pixels at the right and the lower edge are left out.
  /// Fast and small for maps of any size, because the pyramid is read.
  /// @param max_px  >= 1.
  /// @return the extent of the image; 0 x 0 pixels, and empty images, when the map has no mosaic.
  MosaicGrid ReadOverview(int max_px, cv::Mat& grey, cv::Mat& alpha) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::store
