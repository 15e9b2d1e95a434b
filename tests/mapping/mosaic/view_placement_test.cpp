#include "mapping/mosaic/view_placement.hpp"

#include <gtest/gtest.h>

namespace ceilmap::mosaic {
namespace {

constexpr double kExact = 1e-12;

TEST(ViewPlacement, ANearerPointIsSeenFartherFromThePrincipalPoint) {
  // Pixels of 0.01; centre at (50, 40), principal point at (53, 38). The camera is below the map's
  // origin.
  const ViewPlacement view({-0.03, 0.02, 0}, {101, 81}, 0.01, {3, -2});
  EXPECT_NEAR(view.Foot().x, 0, kExact);
  EXPECT_NEAR(view.Foot().y, 0, kExact);
  const cv::Point2d plane = view.ToPixel(0.1, 0.2, 1);
  EXPECT_NEAR(plane.x, 63, kExact);
  EXPECT_NEAR(plane.y, 58, kExact);
  const cv::Point2d nearer = view.ToPixel(0.1, 0.2, 1.5);
  EXPECT_NEAR(nearer.x, 68, kExact);
  EXPECT_NEAR(nearer.y, 68, kExact);
}

TEST(ViewPlacement, PixelAndPlaceOfOneRatioAreInverse) {
  const ViewPlacement view({1.5, -0.7, 0.9}, {160, 120}, 0.013, {4.5, -7.25});
  const cv::Point2d place = view.ToMap(20, 100, 1.3);
  const cv::Point2d pixel = view.ToPixel(place.x, place.y, 1.3);
  EXPECT_NEAR(pixel.x, 20, 1e-9);
  EXPECT_NEAR(pixel.y, 100, 1e-9);
}

TEST(ViewPlacement, OnTheReferencePlaneThePrincipalPointHasNoEffect) {
  const ViewPlacement view({1.5, -0.7, 0.9}, {160, 120}, 0.013, {4.5, -7.25});
  const ViewPlacement centred({1.5, -0.7, 0.9}, {160, 120}, 0.013);
  EXPECT_EQ(view.ToPixel(1, 2), centred.ToPixel(1, 2));
  EXPECT_NEAR(cv::norm(view.ToPixel(1, 2, 1) - centred.ToPixel(1, 2)), 0, 1e-9);
  EXPECT_EQ(view.Bounds(), centred.Bounds());
}

TEST(ViewPlacement, BoundsOfANearPlaneAreSmaller) {
  const ViewPlacement view({}, {100, 80}, 0.01);
  EXPECT_NEAR(view.Bounds(2).width, 0.5, kExact);
  EXPECT_NEAR(view.Bounds(2).height, 0.4, kExact);
}

}  // namespace
}  // namespace ceilmap::mosaic
