#include "mapping/mosaic/ceiling_extent.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

using two_planes::Drive;

const cv::Rect2d kRoom(-0.9, -0.7, 2.2, 1.4);  // its walls, in the map

/// How far a place is outside of the room; negative inside.
double Outside(double x, double y) {
  return std::max(std::max(kRoom.x - x, x - kRoom.br().x), std::max(kRoom.y - y, y - kRoom.br().y));
}

/// Ratio of what a pixel shows: the ceiling, or the wall before it.
double RatioInRoom(const ViewPlacement& view, const cv::Point2d& pixel) {
  const cv::Point2d foot = view.Foot();
  const cv::Point2d way = view.ToMap(pixel.x, pixel.y) - foot;
  double part = 1;  // of the way to the ceiling, up to the wall
  if (way.x != 0) part = std::min(part, ((way.x > 0 ? kRoom.br().x : kRoom.x) - foot.x) / way.x);
  if (way.y != 0) part = std::min(part, ((way.y > 0 ? kRoom.br().y : kRoom.y) - foot.y) / way.y);
  return 1 / part;
}

constexpr int kStepPx = 4;  // of the heights

/// The keyframes of two_planes in a room without a plate.
Drive DriveInRoom() {
  Drive drive = two_planes::Rows();
  drive.metadata.view_focal_px = 120;  // the ceiling is 1.2 m above the camera
  for (std::size_t k = 0; k < drive.keyframes.size(); ++k) {
    auto field = std::make_shared<heights::HeightField>();
    field->grid = two_planes::kViewSize / kStepPx;
    field->step_px = {kStepPx, kStepPx};
    field->first_px = {-79.5 + 0.5 * (kStepPx - 1), -59.5 + 0.5 * (kStepPx - 1)};
    field->cells.resize(static_cast<std::size_t>(field->grid.area()));
    for (std::size_t i = 0; i < field->cells.size(); ++i) {
      const Eigen::Vector2d at = field->Centre(i) + Eigen::Vector2d(79.5, 59.5);
      const double rho = RatioInRoom(drive.views[k], {at.x(), at.y()});
      field->cells[i] = {static_cast<float>(rho), 0.01F};
    }
    drive.keyframes[k].heights = field;
  }
  return drive;
}

bool IsSeen(const Drive& drive, double x, double y) {
  const cv::Rect2d image(-0.5, -0.5, 160, 120);
  return std::any_of(drive.views.begin(), drive.views.end(), [&](const ViewPlacement& view) {
    return image.contains(view.ToPixel(x, y));
  });
}

CeilingExtent ExtentOf(const Drive& drive) {
  return {drive.keyframes, drive.metadata, HeightMap(drive.keyframes, drive.metadata)};
}

const store::MosaicGrid kGrid{-1.5, 1.3, 0.02, 180, 130};

cv::Mat MaskOf(const CeilingExtent& extent) {
  return extent.Over({0, 0, kGrid.width_px, kGrid.height_px}, kGrid);
}

TEST(CeilingExtent, IsEverythingWhereNoKeyframeHasHeights) {
  Drive drive = two_planes::Rows();
  for (graph::Keyframe& keyframe : drive.keyframes) keyframe.heights = nullptr;
  const CeilingExtent extent = ExtentOf(drive);
  EXPECT_TRUE(extent.empty());
  EXPECT_TRUE(MaskOf(extent).empty());
  EXPECT_TRUE(extent.LeftOutPlaces().empty());
}

TEST(CeilingExtent, EndsAtTheWalls) {
  const Drive drive = DriveInRoom();
  const CeilingExtent extent = ExtentOf(drive);
  const cv::Mat mask = MaskOf(extent);
  ASSERT_FALSE(mask.empty());
  const cv::Rect2d bounds = extent.Bounds();
  constexpr double kAround = 0.2;
  EXPECT_NEAR(bounds.x, kRoom.x, kAround);
  EXPECT_NEAR(bounds.y, kRoom.y, kAround);
  EXPECT_NEAR(bounds.br().x, kRoom.br().x, kAround);
  EXPECT_NEAR(bounds.br().y, kRoom.br().y, kAround);
  constexpr double kTolerance = 2 * kStepPx * two_planes::kUnitsPerPx;
  int wrong = 0;  // in the corners of the room
  int checked = 0;
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const double x = kGrid.min_x + (col + 0.5) * kGrid.resolution;
      const double y = kGrid.max_y - (row + 0.5) * kGrid.resolution;
      const double outside = Outside(x, y);
      if (std::abs(outside) < kTolerance || !IsSeen(drive, x, y)) continue;
      ++checked;
      if ((outside < 0) != (mask.at<unsigned char>(row, col) == 255)) ++wrong;
    }
  }
  EXPECT_LT(wrong, checked / 100);
}

TEST(CeilingExtent, StatesWhatIsLeftOut) {
  const Drive drive = DriveInRoom();
  const CeilingExtent extent = ExtentOf(drive);
  ASSERT_EQ(extent.LeftOutPlaces().size(), 1U);
  const store::LeftOut& walls = extent.LeftOutPlaces().front();
  EXPECT_EQ(walls.kind, store::LeftOut::Kind::kBelowCeiling);
  int seen = 0;  // outside of the room, on the reference plane
  for (double y = -1.49; y < 1.5; y += 0.02) {
    for (double x = -1.99; x < 2.5; x += 0.02) {
      if (Outside(x, y) < 0) continue;
      seen += static_cast<int>(IsSeen(drive, x, y));
    }
  }
  EXPECT_NEAR(walls.area, seen * 0.02 * 0.02, 0.2 * walls.area);
  EXPECT_FALSE(walls.polygons.empty());
}

TEST(CeilingExtent, ContainsWhatHangsBelowTheCeiling) {
  const Drive drive = two_planes::Rows();
  const cv::Mat mask = MaskOf(ExtentOf(drive));
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const cv::Point2d place(kGrid.min_x + (col + 0.5) * kGrid.resolution,
                              kGrid.max_y - (row + 0.5) * kGrid.resolution);
      if (std::abs(place.x - 0.4) > 0.9 || std::abs(place.y) > 0.6) continue;
      ASSERT_EQ(mask.at<unsigned char>(row, col), 255) << place;
    }
  }
}

TEST(CeilingExtent, AWindowHasTheValuesOfTheWhole) {
  const CeilingExtent extent = ExtentOf(DriveInRoom());
  const cv::Rect window(35, 20, 70, 90);
  EXPECT_EQ(cv::norm(extent.Over(window, kGrid), MaskOf(extent)(window), cv::NORM_INF), 0);
}

TEST(CeilingExtent, WhatMovesCoversAnArea) {
  CeilingExtent extent = ExtentOf(DriveInRoom());
  std::vector<cv::Point2d> places{{-0.5, 0.3}};  // one wrong measurement
  for (double y = -0.2; y < 0.2; y += 0.04) {
    for (double x = 0; x < 0.4; x += 0.04) places.emplace_back(x + 0.02, y + 0.02);
  }
  extent.AddMoving(places, 0.04);
  ASSERT_EQ(extent.LeftOutPlaces().size(), 2U);
  const store::LeftOut& moving = extent.LeftOutPlaces().back();
  EXPECT_EQ(moving.kind, store::LeftOut::Kind::kMoves);
  EXPECT_EQ(moving.polygons.size(), 1U);
  EXPECT_NEAR(moving.area, 0.16, 0.08);
  EXPECT_EQ(MaskOf(extent).at<unsigned char>(65, 85), 255);  // (0.21, -0.01): still drawn
}

}  // namespace
}  // namespace ceilmap::mosaic
