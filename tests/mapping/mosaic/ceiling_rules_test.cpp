// Each rule by which CeilingExtent decides, on keyframes whose heights are made for it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "mapping/mosaic/ceiling_extent.hpp"
#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

using two_planes::Drive;

constexpr int kCellPx = 4;   // of the height fields: 0.04 m, as the raster of the extent
constexpr double kLow = 20;  // focal length, pixels: the ceiling is 0.2 m above the camera, so that
                             // gaps, islands and holes of its proportions are smaller than a cell
constexpr double kHigh = 120;  // 1.2 m

/// What a keyframe measures of a place of the reference plane that it shows.
using Measured = std::function<heights::HeightCell(const cv::Point2d& p_map)>;

const heights::HeightCell kLevel{1, 0.01F};

heights::HeightCell Everywhere(const cv::Point2d& /*p_map*/) {
  return kLevel;
}

heights::HeightCell Nowhere(const cv::Point2d& /*p_map*/) {
  return heights::kUnknown;
}

/// A wall, as a camera below x = 0 sees it. @param x  of the wall.
Measured WallAt(double x) {
  return [x](const cv::Point2d& p_map) {
    return heights::HeightCell{static_cast<float>(std::max(p_map.x / x, 1.0)), 0.01F};
  };
}
const Measured kWall = WallAt(0.5);

/// Keyframes that look straight up from the same heading.
class Views {
 public:
  /// @param cell_px  of the height fields.
  explicit Views(double focal_px, int cell_px = kCellPx) : drive_({}), cell_px_(cell_px) {
    drive_.metadata.view_focal_px = focal_px;
    drive_.metadata.view_principal_px = {0, 0};
    drive_.metadata.T_base_view = {};
  }

  store::MapMetadata& Metadata() { return drive_.metadata; }

  Views& Add(double x, double y, const Measured& measured) {
    Append(x, y);
    const ViewPlacement view = PlaceViews(drive_.keyframes, drive_.metadata).back();
    auto field = std::make_shared<heights::HeightField>();
    field->grid = two_planes::kViewSize / cell_px_;
    field->step_px = Eigen::Vector2d::Constant(cell_px_);
    field->first_px = Eigen::Vector2d(-79.5, -59.5).array() + 0.5 * (cell_px_ - 1);
    for (int i = 0; i < field->grid.area(); ++i) {
      const Eigen::Vector2d at = field->Centre(static_cast<std::size_t>(i));
      field->cells.push_back(measured(view.ToMap(at.x() + 79.5, at.y() + 59.5)));
    }
    drive_.keyframes.back().heights = field;
    return *this;
  }
  Views& AddWithoutHeights(double x, double y) {
    Append(x, y);
    return *this;
  }

  [[nodiscard]] CeilingExtent Extent() const {
    return {drive_.keyframes, drive_.metadata, HeightMap(drive_.keyframes, drive_.metadata)};
  }

 private:
  void Append(double x, double y) {
    graph::Keyframe keyframe;
    keyframe.id = static_cast<std::int64_t>(drive_.keyframes.size());
    keyframe.pose.T_map_base = {x, y, 0};
    drive_.keyframes.push_back(keyframe);
  }

  Drive drive_;
  int cell_px_;
};

bool IsCeiling(const CeilingExtent& extent, double x, double y) {
  const store::MosaicGrid pixel{x - 0.005, y + 0.005, 0.01, 1, 1};
  const cv::Mat mask = extent.Over({0, 0, 1, 1}, pixel);
  return !mask.empty() && mask.at<unsigned char>(0, 0) == 255;
}

bool IsIn(const cv::Rect2d& box, const cv::Point2d& p_map) {
  return box.contains(p_map);
}

TEST(CeilingRules, CellsWithoutNeighboursShowNoSurface) {
  Views views(kHigh);
  int cell = 0;  // every seventh in both directions: none beside it is within the reach of a slope
  const auto lone = [&](const cv::Point2d& /*p_map*/) {
    const int width = two_planes::kViewSize.width / kCellPx;
    const int col = cell % width;
    const int row = cell / width % (two_planes::kViewSize.height / kCellPx);
    ++cell;
    return col % 7 == 3 && row % 7 == 3 ? kLevel : heights::kUnknown;
  };
  for (const double x : {0.0, 0.08, 0.16, 0.24}) {
    for (const double y : {0.0, 0.12, 0.2}) views.Add(x, y, lone);
  }
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(extent.empty()) << "no decision";
  EXPECT_TRUE(extent.LeftOutPlaces().empty());
}

TEST(CeilingRules, AFewCellsAloneAreNoCeiling) {
  const cv::Rect2d four(0.48, 0.0, 0.08, 0.08);
  Views views(kLow);
  views.Add(0, 0, [&](const cv::Point2d& p_map) {
    return p_map.x < 0 || IsIn(four, p_map) ? kLevel : heights::kUnknown;
  });
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, -0.3, 0.04));
  EXPECT_FALSE(IsCeiling(extent, 0.52, 0.04));
}

TEST(CeilingRules, ExtendsNoFurtherThanTheMeasurements) {
  Views views(kLow);
  views.Add(
      0, 0, [](const cv::Point2d& p_map) { return p_map.x < 0 ? kLevel : heights::kUnknown; });
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, -0.06, 0));
  EXPECT_FALSE(IsCeiling(extent, 0.12, 0));
}

/// What a camera measures of a plate that hangs from x = 0.2 to 0.9. @param foot  x below it.
Measured PlateSeenFrom(double foot) {
  return [foot](const cv::Point2d& p_map) {
    const double below = foot + (p_map.x - foot) / two_planes::kPlateRho;
    const bool plate = below > 0.2 && below < 0.9;
    return heights::HeightCell{plate ? static_cast<float>(two_planes::kPlateRho) : 1.0F, 0.01F};
  };
}

TEST(CeilingRules, WhatHangsBelowHidesNoCeiling) {
  Views views(kLow);
  // It hides deck behind it from the first one.
  for (const double foot : {0.1, 0.75}) views.Add(foot, 0, PlateSeenFrom(foot));
  const CeilingExtent extent = views.Extent();
  for (double x = 0.04; x < 1.3; x += 0.02) EXPECT_TRUE(IsCeiling(extent, x, 0)) << x;
}

TEST(CeilingRules, AFaceIsEvidenceAgainstWhatIsBehindItOnly) {
  Views views(kLow);
  // To the first one, which is far from it, the left border of the plate looks like a face.
  for (const double foot : {-0.3, 0.75}) views.Add(foot, 0, PlateSeenFrom(foot));
  const CeilingExtent extent = views.Extent();
  for (double x = 0.26; x < 0.8; x += 0.02) EXPECT_TRUE(IsCeiling(extent, x, 0)) << x;
  // The slope around the last cells before a wall, here 0.5 m, is that of a face.
  Views wall(kLow, 16);
  wall.Add(0, 0, Everywhere).Add(0, 0, WallAt(0.3));
  for (const double x : {0.0, 0.12, 0.24}) EXPECT_TRUE(IsCeiling(wall.Extent(), x, 0)) << x;
}

TEST(CeilingRules, ARayThatAWallEndsOutweighsASurfaceBehindIt) {
  Views views(kLow);
  // The first one measured something behind the wall, as at the edge of a window.
  views.Add(0, 0, Everywhere).Add(0, 0, kWall).Add(0, 0, kWall);
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, 0.3, 0));
  EXPECT_FALSE(IsCeiling(extent, 0.7, 0));
  Views one(kLow);
  one.Add(0, 0, Everywhere).Add(0, 0, kWall);
  EXPECT_FALSE(IsCeiling(one.Extent(), 0.7, 0));
}

TEST(CeilingRules, ThreeKeyframesThatSeeASurfaceOutweighAnyWall) {
  Views views(kLow);
  views.Add(0, 0, Everywhere).Add(0, 0, Everywhere).Add(0, 0, Everywhere);
  views.Add(0, 0, kWall).Add(0, 0, kWall);
  EXPECT_TRUE(IsCeiling(views.Extent(), 0.7, 0));
}

TEST(CeilingRules, FacesAreThoseFromThePrincipalPoint) {
  Views views(kLow);
  views.Metadata().view_principal_px = {-60, 0};
  // The camera is below x = -0.6, and the wall is at x = -0.4.
  const auto wall = [](const cv::Point2d& p_map) {
    return heights::HeightCell{static_cast<float>(std::max((p_map.x + 0.6) / 0.2, 1.0)), 0.01F};
  };
  views.Add(0, 0, Everywhere).Add(0, 0, wall);
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, -0.6, 0));
  EXPECT_FALSE(IsCeiling(extent, -0.2, 0));
}

TEST(CeilingRules, AnImageWithoutHeightsShowsCeilingAboveTheCamera) {
  constexpr double kFocalPx = 40;  // 35 degrees are 0.28 m
  Views views(kFocalPx);
  views.Add(0, 0, Everywhere).AddWithoutHeights(3, 0);
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, 3, 0));
  EXPECT_TRUE(IsCeiling(extent, 3.2, 0));
  EXPECT_FALSE(IsCeiling(extent, 3.5, 0));
}

TEST(CeilingRules, ASmallIslandIsNone) {
  const auto side = [](double length) {
    Views views(kHigh);
    views.Add(0, 0, Everywhere);
    views.Add(3, 0, [length](const cv::Point2d& p_map) {
      return IsIn({3 - length / 2, -length / 2, length, length}, p_map) ? kLevel
                                                                        : heights::kUnknown;
    });
    return IsCeiling(views.Extent(), 3, 0);
  };
  EXPECT_FALSE(side(0.28));
  EXPECT_TRUE(side(0.48));
}

TEST(CeilingRules, AGapInTheMeasurementsIsFilled) {
  const auto middle_of = [](double width) {
    Views views(kHigh);
    views.Add(0, 0, [width](const cv::Point2d& p_map) {
      return std::abs(p_map.x) < width / 2 ? heights::kUnknown : kLevel;
    });
    return IsCeiling(views.Extent(), 0, 0);
  };
  EXPECT_TRUE(middle_of(0.4));
  EXPECT_FALSE(middle_of(0.8));
}

TEST(CeilingRules, ASpikeOfTheBorderIsCut) {
  const auto spike_of = [](double width) {
    Views views(kHigh);
    views.Add(0, 0, [width](const cv::Point2d& p_map) {
      return p_map.x < 0 || std::abs(p_map.y) < width / 2 ? kLevel : heights::kUnknown;
    });
    return IsCeiling(views.Extent(), 0.5, 0);
  };
  EXPECT_FALSE(spike_of(0.12));
  EXPECT_TRUE(spike_of(0.48));
}

TEST(CeilingRules, OnlySmallHolesAreFilled) {
  const auto hole_of = [](double radius) {
    const Measured around = [radius](const cv::Point2d& p_map) {
      return cv::norm(p_map) < radius ? heights::kUnknown : kLevel;
    };
    Views views(kHigh);
    for (const double y : {-0.5, 0.5}) views.Add(-0.6, y, around).Add(0.6, y, around);
    return IsCeiling(views.Extent(), 0, 0);
  };
  EXPECT_TRUE(hole_of(0.415)) << "too wide for a gap, small enough for a hole";
  EXPECT_FALSE(hole_of(0.55));
}

TEST(CeilingRules, AMissingCornerIsNoHole) {
  Views views(kHigh);
  views.Add(0, 0, [](const cv::Point2d& p_map) {
    return p_map.x > 0.35 && p_map.y > 0.1 ? heights::kUnknown : kLevel;
  });
  const CeilingExtent extent = views.Extent();
  EXPECT_TRUE(IsCeiling(extent, 0, 0));
  EXPECT_FALSE(IsCeiling(extent, 0.7, 0.5));
}

TEST(CeilingRules, WhereImagesHaveNoContentNothingIsLeftOut) {
  const auto left_out = [](bool masked) {
    Views views(kHigh);
    views.Add(
        0, 0, [](const cv::Point2d& p_map) { return p_map.x < 0 ? heights::kUnknown : kLevel; });
    if (masked) {
      views.Metadata().view_mask = cv::Mat(two_planes::kViewSize, CV_8UC1, cv::Scalar(255));
      views.Metadata().view_mask.colRange(0, 80).setTo(0);
    }
    const CeilingExtent extent = views.Extent();
    double area = 0;
    for (const store::LeftOut& places : extent.LeftOutPlaces()) area += places.area;
    return area;
  };
  EXPECT_NEAR(left_out(false), 0.8 * 1.2, 0.1);
  EXPECT_LT(left_out(true), 0.1);
}

TEST(CeilingRules, TheOutlineOfWhatSurroundsTheCeilingHasAHole) {
  const cv::Rect2d room(-0.5, -0.36, 1, 0.72);
  const CeilingExtent extent = Views(kHigh)
                                   .Add(0,
                                        0,
                                        [&](const cv::Point2d& p_map) {
                                          return IsIn(room, p_map) ? kLevel : heights::kUnknown;
                                        })
                                   .Extent();
  ASSERT_EQ(extent.LeftOutPlaces().size(), 1);
  const store::LeftOut& around = extent.LeftOutPlaces().front();
  EXPECT_NEAR(around.area, 1.6 * 1.2 - room.area(), 0.25);
  ASSERT_EQ(around.polygons.size(), 1);
  ASSERT_EQ(around.polygons[0].size(), 2) << "the border and one hole";
  for (const cv::Point2d& at : around.polygons[0][1]) {
    EXPECT_LT(std::abs(at.x), 0.65);
    EXPECT_LT(std::abs(at.y), 0.5);
  }
}

TEST(CeilingRules, WithoutMeasurementsThereIsNoDecision) {
  const CeilingExtent extent = Views(kHigh).Add(0, 0, Nowhere).Extent();
  EXPECT_TRUE(extent.empty());
  EXPECT_EQ(extent.Bounds(), cv::Rect2d());
}

TEST(CeilingRules, OnlyAreasOfTheCeilingMove) {
  constexpr double kSpacing = 0.04;
  const auto moving = [](const std::vector<cv::Point2d>& places) {
    CeilingExtent extent =
        Views(kHigh)
            .Add(
                0, 0, [](const cv::Point2d& at) { return at.x < 0.3 ? kLevel : heights::kUnknown; })
            .Extent();
    extent.AddMoving(places, kSpacing);
    const std::vector<store::LeftOut>& all = extent.LeftOutPlaces();
    return std::count_if(all.begin(), all.end(), [](const store::LeftOut& left_out) {
      return left_out.kind == store::LeftOut::Kind::kMoves;
    });
  };
  const auto block = [](const cv::Point2d& first, int cells) {
    std::vector<cv::Point2d> places;
    for (int row = 0; row < cells; ++row) {
      for (int col = 0; col < cells; ++col) {
        places.emplace_back(first.x + (col + 0.5) * kSpacing, first.y + (row + 0.5) * kSpacing);
      }
    }
    return places;
  };
  std::vector<cv::Point2d> lines;
  for (int row = 0; row < 4; ++row) {
    for (int col = 0; col < 20; ++col) {
      lines.emplace_back((col - 14 + 0.5) * kSpacing, (6 * row - 12 + 0.5) * kSpacing);
    }
  }
  EXPECT_EQ(moving(block({-0.2, -0.2}, 10)), 1);
  EXPECT_EQ(moving(block({0.36, -0.2}, 10)), 0) << "not ceiling";
  EXPECT_EQ(moving(block({2, 2}, 10)), 0) << "outside";
  EXPECT_EQ(moving(block({0, 0}, 4)), 0) << "too small";
  EXPECT_EQ(moving(lines), 0) << "too sparse";
}

}  // namespace
}  // namespace ceilmap::mosaic
