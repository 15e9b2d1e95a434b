#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mapping/mosaic/mosaic.hpp"
#include "mapping/store/map_file.hpp"

/// A mosaic drawn by several jobs: each draws a band of its rows into a file, and the bands are
/// assembled. The result has the pixels of a mosaic that is drawn at once, whatever the number of
/// parts, because the value of a point does not depend on the window.
namespace ceilmap::mosaic {

/// Done, total windows; may be empty.
using DrawingProgress = std::function<void(int, int)>;

/// The rows of a part, whole rows of tiles of the map file; none where there are more parts than
/// rows of tiles.
/// @param part  1 to `parts`.
cv::Range RowsOf(const store::MosaicGrid& whole, int part, int parts);

/// A map without a mosaic, of which it is drawn.
class UndrawnMap {
 public:
  /// @param name  for messages. @param map  must outlive this.
  /// @throws InputError when it has a mosaic already, or no keyframes.
  UndrawnMap(std::string name, const store::MapReader& map);

  [[nodiscard]] MosaicRenderer Renderer() const;
  /// What a part's file has as metadata: those of the map, so that parts of another one, or of an
  /// earlier version of this one, are found.
  [[nodiscard]] store::MapMetadata MetadataOf(int part,
                                              int parts,
                                              const store::MosaicGrid& whole) const;
  [[nodiscard]] const std::string& Name() const { return name_; }
  [[nodiscard]] std::size_t KeyframeCount() const { return keyframes_.size(); }

 private:
  std::string name_;
  const store::MapReader& map_;
  std::vector<graph::Keyframe> keyframes_;
  std::uint64_t fingerprint_ = 0;
};

/// Writes a part (without Commit).
/// @param writer  made with UndrawnMap::MetadataOf the part.
void WritePart(const MosaicRenderer& renderer,
               int part,
               int parts,
               store::MapWriter& writer,
               const DrawingProgress& progress = {});

/// All parts of the mosaic of one map.
class MosaicParts {
 public:
  struct NamedPart {
    std::string name;  ///< for messages
    std::unique_ptr<store::MapReader> file;
  };

  /// @param parts  in any order.
  /// @throws InputError when one is missing or there twice, or they do not belong to the map.
  MosaicParts(const UndrawnMap& map, std::vector<NamedPart> parts);

  /// Writes the mosaic, and what it leaves out (without Commit).
  void WriteTo(store::MapWriter& writer, const DrawingProgress& progress = {}) const;
  [[nodiscard]] const store::MosaicGrid& Grid() const;

 private:
  void CheckPart(const UndrawnMap& map, const NamedPart& part) const;
  void Read(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const;

  std::vector<NamedPart> parts_;  // in their order
};

}  // namespace ceilmap::mosaic
