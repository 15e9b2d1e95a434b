#include "mapping/map_links.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ceilmap::mapping {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kSpan = 3;

/// True poses of five maps in the building.
const std::vector<Pose2> kMapPlaces = {{0, 0, 0}, {10, 0, 1}, {10, 8, -2}, {0, 8, 3}, {20, 4, 0.5}};

MapLink Link(std::size_t a, std::size_t b, std::size_t edges, const Pose2& error = {}) {
  MapLink link{a, b, edges, kMapPlaces[a].Inverse() * kMapPlaces[b] * error, {}};
  for (int i = 0; i < 3; ++i) {
    const Pose2 T_b_here{1.0 * i, -0.5 * i, 0.3 * i};
    link.samples.push_back({link.T_a_b * T_b_here, T_b_here});
  }
  return link;
}

std::vector<LinkedMap> Maps() {
  return {{100, 12}, {100, 12}, {100, 12}, {100, 12}, {300, 12}};
}

TEST(ChooseLinks, PlacesTheMapsOfAGroup) {
  const std::vector<MapLink> links = {Link(1, 2, 20), Link(2, 3, 10), Link(1, 3, 30)};
  const LinkChoice choice = ChooseLinks(Maps(), links, {}, kSpan);
  EXPECT_THAT(choice.contradicting, IsEmpty());
  EXPECT_THAT(choice.group.maps, ElementsAre(1, 2, 3));
  EXPECT_THAT(choice.group.links, ElementsAre(0, 1, 2));
  for (std::size_t i = 0; i < choice.group.maps.size(); ++i) {
    const Pose2 expected = kMapPlaces[1].Inverse() * kMapPlaces[choice.group.maps[i]];
    const Pose2 off = expected.Inverse() * choice.group.T_first_map[i];
    EXPECT_LT(off.Translation().norm(), 1e-9);
    EXPECT_LT(std::abs(off.yaw), 1e-9);
  }
}

TEST(ChooseLinks, TheGroupWithMostKeyframesCounts) {
  const std::vector<MapLink> links = {Link(0, 1, 20), Link(2, 3, 10)};
  std::vector<LinkedMap> maps = Maps();
  EXPECT_THAT(ChooseLinks(maps, links, {}, kSpan).group.maps, ElementsAre(0, 1));
  maps[2].keyframes = 150;
  EXPECT_THAT(ChooseLinks(maps, links, {}, kSpan).group.maps, ElementsAre(2, 3))
      << "and not the large map that is alone";
  EXPECT_THAT(ChooseLinks(maps, links, {1}, kSpan).group.maps, ElementsAre(0, 1));
}

TEST(ChooseLinks, ACycleThatDoesNotCloseLosesItsWeakestLink) {
  const std::vector<MapLink> links = {Link(0, 1, 20), Link(1, 2, 5, {8, 0, 0}), Link(0, 2, 10)};
  const LinkChoice choice = ChooseLinks(Maps(), links, {}, kSpan);
  EXPECT_THAT(choice.contradicting, ElementsAre(1));
  EXPECT_THAT(choice.group.maps, ElementsAre(0, 1, 2));
  EXPECT_THAT(choice.group.links, ElementsAre(0, 2));
}

// One wrong link with most edges of all contradicts two cycles of right ones.
TEST(ChooseLinks, TheMajorityOutweighsOneStrongLink) {
  const std::vector<MapLink> links = {
      Link(0, 1, 12, {0, 0, 1.5}), Link(1, 2, 10), Link(0, 2, 10), Link(1, 3, 10), Link(0, 3, 10)};
  const LinkChoice choice = ChooseLinks(Maps(), links, {}, kSpan);
  EXPECT_THAT(choice.contradicting, ElementsAre(0));
  EXPECT_THAT(choice.group.maps, ElementsAre(0, 1, 2, 3));
}

TEST(ChooseLinks, SmallGapsAreLeftToTheOptimization) {
  const std::vector<MapLink> links = {
      Link(0, 1, 20), Link(1, 2, 5, {0.5 * kSpan, 0, 0.05}), Link(0, 2, 10)};
  EXPECT_THAT(ChooseLinks(Maps(), links, {}, kSpan).contradicting, IsEmpty());
}

TEST(ChooseLinks, WithoutLinksAMapIsAlone) {
  EXPECT_THAT(ChooseLinks(Maps(), {}, {}, kSpan).group.maps, ElementsAre(4));
}

}  // namespace
}  // namespace ceilmap::mapping
