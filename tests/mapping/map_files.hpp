#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mapping/common_view.hpp"
#include "mapping/store/map_file.hpp"
#include "tests/mapping/synthetic_drive.hpp"
#include "tests/support/temp_folder.hpp"

/// Map files of synthetic drives.
namespace ceilmap::mapping::synthetic {

inline store::MapMetadata MetadataOf(const calib::CeilingView& view) {
  store::MapMetadata metadata;
  metadata.resolution = view.MetresPerPixel();
  metadata.ceiling_height_m = 2.6;
  metadata.view_size = view.Size();
  metadata.view_units_per_px = view.MetresPerPixel();
  metadata.T_base_view = view.T_base_view();
  metadata.view_focal_px = view.FocalLength();
  metadata.program_version = "0.1.0";
  return metadata;
}

/// A folder of map files that are open.
class MapFiles {
 public:
  /// A map of a graph alone, in the file NAME.gpkg. @return its index.
  std::size_t Add(const std::string& name,
                  const store::MapMetadata& metadata,
                  const graph::MapGraph& graph) {
    store::MapWriter writer(folder_ / (name + ".gpkg"), metadata);
    writer.WriteGraph(graph);
    writer.Commit();
    return Open(name);
  }
  /// A map of a drive, with images and descriptors.
  std::size_t Add(const std::string& name, const DriveUnder& drive) {
    store::MapWriter writer(folder_ / (name + ".gpkg"), MetadataOf(drive.view));
    for (const graph::Keyframe& keyframe : drive.graph.keyframes) {
      writer.AddImage(keyframe.id, drive.Image(keyframe.id));
      writer.AddDescriptors(keyframe.id, drive.Descriptors(keyframe.id));
    }
    writer.WriteGraph(drive.graph);
    writer.Commit();
    return Open(name);
  }

  [[nodiscard]] const std::vector<NamedMap>& Maps() const { return maps_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return folder_ / name;
  }

 private:
  std::size_t Open(const std::string& name) {
    readers_.push_back(std::make_unique<store::MapReader>(folder_ / (name + ".gpkg")));
    maps_.push_back({readers_.back().get(), name});
    return maps_.size() - 1;
  }

  support::TempFolder folder_;
  std::vector<std::unique_ptr<store::MapReader>> readers_;
  std::vector<NamedMap> maps_;
};

}  // namespace ceilmap::mapping::synthetic
