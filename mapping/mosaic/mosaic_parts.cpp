#include "mapping/mosaic/mosaic_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "calib/base/error.hpp"
#include "mapping/graph/fingerprint.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::mosaic {
namespace {

const store::MosaicPart& PartOf(const store::MapReader& file) {
  return *file.Metadata().part;
}

/// The grid of a band: that of its file.
store::MosaicGrid BandOf(const store::MosaicGrid& whole, const cv::Range& rows) {
  store::MosaicGrid band = whole;
  band.max_y = whole.max_y - rows.start * whole.resolution;
  band.height_px = rows.size();
  return band;
}

}  // namespace

cv::Range RowsOf(const store::MosaicGrid& whole, int part, int parts) {
  constexpr std::int64_t kTile = 256;  // side of the map file's tiles
  const std::int64_t tiles = (whole.height_px + kTile - 1) / kTile;
  const auto row = [&](std::int64_t before) {
    return static_cast<int>(
        std::min<std::int64_t>(tiles * before / parts * kTile, whole.height_px));
  };
  return {row(part - 1), row(part)};
}

UndrawnMap::UndrawnMap(std::string name, const store::MapReader& map)
    : name_(std::move(name)), map_(map), keyframes_(map.ReadKeyframes()) {
  if (map.Grid().width_px > 0) {
    throw InputError(fmt::format(
        "{}: has its mosaic already; 'ceilmap solve --no-mosaic' makes a map without", name_));
  }
  if (keyframes_.empty()) {
    throw InputError(fmt::format("{}: has no keyframes, of which a mosaic is drawn", name_));
  }
  fingerprint_ = graph::Fingerprint(keyframes_, map.ReadEdges());
}

MosaicRenderer UndrawnMap::Renderer() const {
  return MosaicRenderer(
      keyframes_,
      map_.Metadata(),
      [this](std::int64_t id) { return map_.ReadImage(id); },
      ParamsFor(map_.Metadata()));
}

store::MapMetadata UndrawnMap::MetadataOf(int part,
                                          int parts,
                                          const store::MosaicGrid& whole) const {
  store::MapMetadata metadata = map_.Metadata();
  metadata.part = {part, parts, whole, fingerprint_};
  return metadata;
}

void WritePart(const MosaicRenderer& renderer,
               int part,
               int parts,
               store::MapWriter& writer,
               const DrawingProgress& progress) {
  const cv::Range rows = RowsOf(renderer.Grid(), part, parts);
  writer.WriteLeftOut(renderer.LeftOutPlaces());
  writer.WriteMosaic(
      BandOf(renderer.Grid(), rows),
      [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
        renderer.Render(window + cv::Point(0, rows.start), grey, alpha);
      },
      progress);
}

MosaicParts::MosaicParts(const UndrawnMap& map, std::vector<NamedPart> parts)
    : parts_(std::move(parts)) {
  if (parts_.empty()) throw InputError("give the parts of the mosaic");
  for (const NamedPart& part : parts_) CheckPart(map, part);
  std::stable_sort(parts_.begin(), parts_.end(), [](const NamedPart& a, const NamedPart& b) {
    return PartOf(*a.file).part < PartOf(*b.file).part;
  });
  const int count = PartOf(*parts_.front().file).parts;
  int expected = 1;
  for (std::size_t i = 0; i <= parts_.size(); ++i, ++expected) {
    const int part = i < parts_.size() ? PartOf(*parts_[i].file).part : count + 1;
    if (part == expected) continue;
    if (part < expected) {
      throw InputError(fmt::format("{} and {} are the same part, {} of {}; give one of them",
                                   parts_[i - 1].name,
                                   parts_[i].name,
                                   part,
                                   count));
    }
    throw InputError(
        fmt::format("part {0} of {1} is missing; draw it by 'ceilmap mosaic {2} --part {0}/{1}'",
                    expected,
                    count,
                    map.Name()));
  }
}

void MosaicParts::CheckPart(const UndrawnMap& map, const NamedPart& named) const {
  const store::MosaicPart& part = PartOf(*named.file);
  const NamedPart& first = parts_.front();
  const store::MosaicPart& part_of_first = PartOf(*first.file);
  // Also when the map has only been made with other options.
  const store::MapMetadata expected = map.MetadataOf(part.part, part.parts, part.whole);
  if (store::ToRows(expected) != store::ToRows(named.file->Metadata())) {
    throw InputError(
        fmt::format("{0}: is a part of another map than {1}, or of an earlier version of it; draw "
                    "it by 'ceilmap mosaic {1} --part {2}/{3}'",
                    named.name,
                    map.Name(),
                    part.part,
                    part.parts));
  }
  if (part.parts != part_of_first.parts) {
    throw InputError(fmt::format("{} is one of {} parts, {} one of {}; give the parts of one set",
                                 first.name,
                                 part_of_first.parts,
                                 named.name,
                                 part.parts));
  }
  auto grid_of = [](const store::MapReader& file) { return store::ToRows(PartOf(file)); };
  auto rows = grid_of(*named.file);
  rows["part"] = grid_of(*first.file)["part"];
  const int height = RowsOf(part.whole, part.part, part.parts).size();
  const store::MosaicGrid& band = named.file->Grid();
  if (rows != grid_of(*first.file) || band.height_px != height ||
      (height > 0 && band.width_px != part.whole.width_px)) {
    throw InputError(
        fmt::format("{}: does not fit to {}; draw both again", named.name, first.name));
  }
}

const store::MosaicGrid& MosaicParts::Grid() const {
  return PartOf(*parts_.front().file).whole;
}

void MosaicParts::Read(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const {
  grey.create(window.size(), CV_8UC1);
  alpha.create(window.size(), CV_8UC1);
  for (const NamedPart& part : parts_) {
    const cv::Range rows = RowsOf(Grid(), PartOf(*part.file).part, static_cast<int>(parts_.size()));
    const cv::Rect shared = window & cv::Rect(0, rows.start, Grid().width_px, rows.size());
    if (shared.empty()) continue;
    cv::Mat grey_there = grey(shared - window.tl());
    cv::Mat alpha_there = alpha(shared - window.tl());
    part.file->ReadMosaic(shared - cv::Point(0, rows.start), grey_there, alpha_there);
  }
}

void MosaicParts::WriteTo(store::MapWriter& writer, const DrawingProgress& progress) const {
  writer.WriteLeftOut(parts_.front().file->ReadLeftOut());
  writer.WriteMosaic(
      Grid(),
      [this](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) { Read(window, grey, alpha); },
      progress);
}

}  // namespace ceilmap::mosaic
