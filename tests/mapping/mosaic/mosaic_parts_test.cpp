#include "mapping/mosaic/mosaic_parts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "calib/base/error.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::mosaic {
namespace {

using store::synthetic::Same;
using testing::HasSubstr;
using testing::ThrowsMessage;

const cv::Size kView(120, 90);

/// Maps of one drive under a ceiling with a step, without their mosaics, and what is made of them.
/// Images have gains and, at one corner, a foreign object; the mosaic has six rows of tiles.
class MosaicPartsTest : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& provenance = "ceilmap solve") const {
    store::MapMetadata metadata = store::synthetic::Metadata(kView, 0.005);
    metadata.resolution = 0.001;
    metadata.provenance = provenance;
    graph::MapGraph graph = MapGraph();
    store::MapWriter writer(folder_ / name, metadata);
    const std::vector<ViewPlacement> views = PlaceViews(graph.keyframes, metadata);
    for (std::size_t k = 0; k < views.size(); ++k) {
      cv::Mat image = store::synthetic::Photograph(
          views[k], kView, store::synthetic::Brightness, [k](double q) {
            return std::exp(0.1 * std::sin(1.7 * static_cast<double>(k)) - 0.3 * q);
          });
      if (k == 5) image(cv::Rect(0, 0, 50, 40)).setTo(250);
      writer.AddImage(graph.keyframes[k].id, image);
      writer.AddDescriptors(graph.keyframes[k].id, cv::Mat(2, 3, CV_32FC1, cv::Scalar(1.0 / 3)));
    }
    writer.WriteGraph(graph);
    writer.Commit();
  }
  static graph::MapGraph MapGraph() {
    graph::MapGraph graph = store::synthetic::SmallMap().Graph();
    graph.keyframes = store::synthetic::Lawnmower(3, 4, 0.3);
    for (const std::size_t i : {1, 4}) {
      auto heights = std::make_shared<heights::HeightField>(*store::synthetic::Heights(0));
      heights->first_px = {-45, -30};
      heights->step_px = {30, 30};
      graph.keyframes[i].heights = heights;
    }
    return graph;
  }
  void DrawParts(const std::string& map, int parts) const {
    const store::MapReader reader(folder_ / map);
    const UndrawnMap undrawn(map, reader);
    for (int part = 1; part <= parts; ++part) {
      const MosaicRenderer renderer = undrawn.Renderer();
      store::MapWriter writer(folder_ / PartName(part, parts),
                              undrawn.MetadataOf(part, parts, renderer.Grid()));
      WritePart(renderer, part, parts, writer);
      writer.Commit();
    }
  }
  static std::string PartName(int part, int parts) {
    return std::to_string(part) + "of" + std::to_string(parts) + ".gpkg";
  }
  void Assemble(const std::string& map,
                const std::vector<std::string>& names,
                const std::string& output) const {
    const store::MapReader reader(folder_ / map);
    const UndrawnMap undrawn(map, reader);
    std::vector<MosaicParts::NamedPart> parts;
    parts.reserve(names.size());
    for (const std::string& name : names) {
      parts.push_back(
          {name, std::make_unique<store::MapReader>(folder_ / name, store::FileKind::kMosaicPart)});
    }
    const MosaicParts assembled(undrawn, std::move(parts));
    store::MapWriter writer(folder_ / output, reader.Metadata(), folder_ / map);
    assembled.WriteTo(writer);
    writer.Commit();
  }
  void ExpectRefused(const std::vector<std::string>& names, const std::string& message) const {
    EXPECT_THAT([&] { Assemble("map.gpkg", names, "x.gpkg"); },
                ThrowsMessage<InputError>(HasSubstr(message)));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.gpkg"));
  }

  support::TestFolder folder_;
};

void ExpectSameMosaic(const store::MapReader& a, const store::MapReader& b) {
  ASSERT_EQ(a.Grid().width_px, b.Grid().width_px);
  ASSERT_EQ(a.Grid().height_px, b.Grid().height_px);
  EXPECT_EQ(a.Grid().min_x, b.Grid().min_x);
  EXPECT_EQ(a.Grid().max_y, b.Grid().max_y);
  const cv::Rect all(0, 0, a.Grid().width_px, a.Grid().height_px);
  std::array<cv::Mat, 2> grey;
  std::array<cv::Mat, 2> alpha;
  a.ReadMosaic(all, grey[0], alpha[0]);
  b.ReadMosaic(all, grey[1], alpha[1]);
  EXPECT_GT(cv::countNonZero(alpha[0]), all.area() / 2);
  EXPECT_TRUE(Same(grey[0], grey[1]) && Same(alpha[0], alpha[1]));
  a.ReadOverview(200, grey[0], alpha[0]);
  b.ReadOverview(200, grey[1], alpha[1]);
  EXPECT_TRUE(Same(grey[0], grey[1]) && Same(alpha[0], alpha[1]));
}

// As a map that is written at once, from memory; the heights have steps, so that places are left
// out.
TEST_F(MosaicPartsTest, GiveTheMosaicThatIsDrawnAtOnce) {
  Write("map.gpkg");
  const store::MapReader map(folder_ / "map.gpkg");
  {
    store::MapWriter writer(folder_ / "whole.gpkg", map.Metadata());
    const graph::MapGraph graph = MapGraph();
    for (const graph::Keyframe& keyframe : graph.keyframes) {
      writer.CopyImage(map, keyframe.id, keyframe.id);
    }
    WriteMap(graph, map.Metadata(), ParamsFor(map.Metadata()), writer);
    writer.Commit();
  }
  const store::MapReader whole(folder_ / "whole.gpkg");
  ASSERT_GT(whole.Grid().height_px, 5 * 256);
  for (const int parts : {2, 7}) {  // of seven, some have no rows
    DrawParts("map.gpkg", parts);
    std::vector<std::string> names;
    names.reserve(static_cast<std::size_t>(parts));
    for (int part = parts; part >= 1; --part) names.push_back(PartName(part, parts));
    Assemble("map.gpkg", names, "site.gpkg");
    const store::MapReader site(folder_ / "site.gpkg");
    ExpectSameMosaic(site, whole);
    EXPECT_EQ(site.ReadLeftOut().size(), whole.ReadLeftOut().size());
    EXPECT_EQ(site.ReadKeyframes().size(), whole.ReadKeyframes().size());
    EXPECT_FALSE(site.Metadata().part);
  }
}

TEST_F(MosaicPartsTest, RowsAreThoseOfTilesAndCoverAll) {
  const store::MosaicGrid grid{0, 0, 1, 100, 1300};  // six rows of tiles
  EXPECT_EQ(RowsOf(grid, 1, 1), cv::Range(0, 1300));
  EXPECT_EQ(RowsOf(grid, 1, 4), cv::Range(0, 256));
  EXPECT_EQ(RowsOf(grid, 2, 4), cv::Range(256, 768));
  EXPECT_EQ(RowsOf(grid, 4, 4), cv::Range(1024, 1300));
  int end = 0;
  for (int part = 1; part <= 50; ++part) {
    const cv::Range rows = RowsOf(grid, part, 50);
    EXPECT_EQ(rows.start, end);
    end = rows.end;
  }
  EXPECT_EQ(end, 1300);
}

TEST_F(MosaicPartsTest, RefuseASetThatIsNotThatOfTheMap) {
  Write("map.gpkg");
  Write("other.gpkg", "ceilmap solve --resolution 0.001");
  DrawParts("other.gpkg", 1);
  DrawParts("map.gpkg", 3);
  DrawParts("map.gpkg", 2);
  ExpectRefused({"1of3.gpkg", "3of3.gpkg"},
                "part 2 of 3 is missing; draw it by 'ceilmap mosaic map.gpkg --part 2/3'");
  ExpectRefused({"2of3.gpkg", "1of3.gpkg"}, "part 3 of 3 is missing");
  ExpectRefused({"1of3.gpkg", "2of3.gpkg", "2of3.gpkg"},
                "2of3.gpkg and 2of3.gpkg are the same part, 2 of 3; give one of them");
  ExpectRefused({"1of3.gpkg", "2of2.gpkg"},
                "1of3.gpkg is one of 3 parts, 2of2.gpkg one of 2; give the parts of one set");
  ExpectRefused({"1of1.gpkg"},
                "1of1.gpkg: is a part of another map than map.gpkg, or of an earlier version of "
                "it; draw it by 'ceilmap mosaic map.gpkg --part 1/1'");
  ExpectRefused({}, "give the parts of the mosaic");
  ExpectRefused({"map.gpkg"}, "map.gpkg: is a map; give files of 'ceilmap mosaic MAP --part'");
}

TEST_F(MosaicPartsTest, APartIsNoMap) {
  Write("map.gpkg");
  DrawParts("map.gpkg", 1);
  EXPECT_THAT([&] { store::MapReader(folder_ / "1of1.gpkg"); },
              ThrowsMessage<InputError>(HasSubstr(
                  "is a part of a mosaic; 'ceilmap mosaic MAP --assemble' makes a map of all")));
}

TEST_F(MosaicPartsTest, AMapThatHasAMosaicIsNotDrawnAgain) {
  store::synthetic::SmallMap().Write(folder_ / "small.gpkg");
  const store::MapReader map(folder_ / "small.gpkg");
  EXPECT_THAT([&] { UndrawnMap("small.gpkg", map); },
              ThrowsMessage<InputError>(HasSubstr("small.gpkg: has its mosaic already; 'ceilmap "
                                                  "solve --no-mosaic' makes a map without")));
}

}  // namespace
}  // namespace ceilmap::mosaic
