#include "mapping/mosaic/height_refinement.hpp"

#include <gtest/gtest.h>

#include "mapping/mosaic/padded_image.hpp"
#include "mapping/mosaic/photo_cost.hpp"
#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr float kNear = 1.3F;

/// Two surfaces: near at columns >= edge. Columns < plain have no texture.
class Wall : public RatioCost {
 public:
  Wall(int edge, int plain) : edge_(edge), plain_(plain) {}
  void Select(int col, int /*row*/, float /*rho*/) override { col_ = col; }
  [[nodiscard]] float Cost(float rho) const override {
    if (col_ < plain_) return 0;
    return std::min(1.0F, 20 * std::abs(rho - (col_ >= edge_ ? kNear : 1)));
  }

 private:
  int edge_;
  int plain_;
  int col_ = 0;
};

cv::Mat TwoSurfaces(int edge) {
  cv::Mat ratios(20, 40, CV_32FC1, cv::Scalar(1));
  ratios.colRange(edge, 40).setTo(kNear);
  return ratios;
}

TEST(RefineRatios, MovesTheEdgeToWhereTheImagesShowIt) {
  for (const int measured : {15, 20, 25}) {
    cv::Mat ratios = TwoSurfaces(measured);
    Wall wall(20, 0);
    RefineRatios(ratios, {0, 0}, wall);
    EXPECT_EQ(cv::norm(ratios, TwoSurfaces(20), cv::NORM_INF), 0) << measured;
  }
}

TEST(RefineRatios, PlacesWithoutTextureTakeTheRatioAroundThem) {
  cv::Mat ratios = TwoSurfaces(20);
  ratios.at<float>(10, 5) = 1.1F;
  Wall wall(20, 10);
  RefineRatios(ratios, {0, 0}, wall);
  EXPECT_EQ(cv::norm(ratios, TwoSurfaces(20), cv::NORM_INF), 0);
}

TEST(RefineRatios, UnknownStaysUnknown) {
  cv::Mat ratios(8, 8, CV_32FC1, cv::Scalar(0));
  Wall wall(0, 0);
  RefineRatios(ratios, {0, 0}, wall);
  EXPECT_EQ(cv::countNonZero(ratios), 0);
}

TEST(RefineRatios, AnyPartGivesTheSameAsTheWhole) {
  cv::Mat whole(40, 60, CV_32FC1);
  cv::RNG rng(3);
  rng.fill(whole, cv::RNG::UNIFORM, 0.9, 1.4);
  const cv::Rect part(9, 10, 29, 24);
  const cv::Rect inner(part.x + kRefinementReach, part.y + kRefinementReach, 9, 4);
  cv::Mat piece = whole(part).clone();
  Wall wall(20, 5);
  RefineRatios(whole, {0, 0}, wall);
  RefineRatios(piece, part.tl(), wall);
  EXPECT_EQ(cv::norm(whole(inner), piece(inner - part.tl()), cv::NORM_INF), 0);
}

TEST(PhotoCost, IsLeastAtTheTrueRatio) {
  const two_planes::Drive drive = two_planes::Rows();
  std::vector<PhotoView> photos;
  for (std::size_t k = 0; k < drive.views.size(); ++k) {
    auto padded = std::make_shared<cv::Mat>();
    cv::copyMakeBorder(
        drive.images[k], *padded, kPadding, kPadding, kPadding, kPadding, cv::BORDER_REPLICATE);
    photos.push_back({&drive.views[k], padded, 1});
  }
  const store::MosaicGrid grid{-1, 1, 0.02, 100, 100};
  PhotoCost cost(photos, grid, two_planes::kViewSize, two_planes::kUnitsPerPx);
  const auto check = [&](int col, int row, float rho, float other) {
    cost.Select(col, row, other);
    EXPECT_LT(cost.Cost(rho), 0.1) << col << ' ' << row;
    EXPECT_GT(cost.Cost(other), 2 * cost.Cost(rho)) << col << ' ' << row;
    EXPECT_GT(cost.Cost(rho * 1.04F), cost.Cost(rho)) << col << ' ' << row;
    EXPECT_GT(cost.Cost(rho * 0.96F), cost.Cost(rho)) << col << ' ' << row;
  };
  check(77, 50, two_planes::kPlateRho, 1);  // x = 0.55, y = -0.01
  check(40, 45, 1, two_planes::kPlateRho);  // x = -0.19, y = 0.09
}

TEST(PhotoCost, OneImageProvesNothing) {
  PhotoCost cost({}, {-1, 1, 0.02, 100, 100}, two_planes::kViewSize, two_planes::kUnitsPerPx);
  cost.Select(10, 10, 1);
  EXPECT_EQ(cost.Cost(1), cost.Cost(1.3F));
}

}  // namespace
}  // namespace ceilmap::mosaic
