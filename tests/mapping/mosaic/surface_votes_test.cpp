#include "mapping/mosaic/surface_votes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::mosaic {
namespace {

/// Votes at one pixel.
class AtOnePixel {
 public:
  AtOnePixel& Add(float rho, int count = 1, float weight = 1) {
    for (int i = 0; i < count; ++i) votes_.Add({10, 20, 4, rho, weight});
    return *this;
  }
  [[nodiscard]] float Elected() const { return votes_.Elect({10, 20, 1, 1})(0, 0); }

 private:
  SurfaceVotes votes_;
};

TEST(SurfaceVotes, TheNearestSurfaceWithAThirdOfTheVotesCovers) {
  EXPECT_EQ(AtOnePixel().Add(1, 10).Add(1.25F, 4).Elected(), 1.25F);
  EXPECT_EQ(AtOnePixel().Add(1, 10).Add(1.25F, 3).Elected(), 1);
  EXPECT_EQ(AtOnePixel().Add(1, 3).Add(1.25F, 10).Elected(), 1.25F);
  EXPECT_EQ(AtOnePixel().Add(1, 9).Add(1.25F, 4).Add(1.5F, 4).Elected(), 1.5F);
}

TEST(SurfaceVotes, ASurfaceHasTheMedianOfItsVotes) {
  EXPECT_EQ(AtOnePixel().Add(1.01F).Add(1.0F).Add(0.995F).Elected(), 1.0F);
  // Others do not pull it.
  EXPECT_EQ(AtOnePixel().Add(1.01F, 3).Add(1.0F, 5).Add(0.99F, 3).Add(1.6F, 1).Elected(), 1.0F);
}

TEST(SurfaceVotes, WeightsCountNotNumbers) {
  EXPECT_EQ(AtOnePixel().Add(1, 10, 0.1F).Add(1.25F).Elected(), 1.25F);
  EXPECT_EQ(AtOnePixel().Add(1).Add(1.25F, 10, 0.03F).Elected(), 1);
}

TEST(SurfaceVotes, TooFewAreNone) {
  EXPECT_EQ(AtOnePixel().Elected(), 0);
  EXPECT_EQ(AtOnePixel().Add(1.2F, 1, 0.05F).Elected(), 0);
  EXPECT_EQ(AtOnePixel().Add(1.2F, 3, 0.05F).Elected(), 1.2F);
}

TEST(SurfaceVotes, AVoteReachesItsRadius) {
  SurfaceVotes votes;
  votes.Add({-30.4F, 31.8F, 5, 1.3F, 1});  // near the corner of four squares
  const cv::Rect window(-45, 15, 40, 40);
  const cv::Mat_<float> elected = votes.Elect(window);
  int known = 0;
  for (int row = 0; row < window.height; ++row) {
    for (int col = 0; col < window.width; ++col) {
      const double away = std::hypot(window.x + col + 30.4, window.y + row - 31.8);
      if (elected(row, col) == 0) {
        EXPECT_GT(away, 4);
        continue;
      }
      EXPECT_EQ(elected(row, col), 1.3F);
      EXPECT_LT(away, 4.2) << "the weight falls to 0.1 at 0.83 of the radius";
      ++known;
    }
  }
  EXPECT_NEAR(known, 54, 6);
}

TEST(SurfaceVotes, AnyWindowHasTheValuesOfTheWhole) {
  SurfaceVotes votes;
  cv::RNG rng(7);
  for (int i = 0; i < 400; ++i) {
    votes.Add({rng.uniform(-60.0F, 60.0F),
               rng.uniform(-60.0F, 60.0F),
               rng.uniform(2.0F, SurfaceVotes::kMaxRadius),
               rng.uniform(1.0F, 1.5F),
               rng.uniform(0.1F, 1.0F)});
  }
  const cv::Mat_<float> whole = votes.Elect({-70, -70, 140, 140});
  for (const cv::Rect& part : {cv::Rect(-9, 23, 31, 20), cv::Rect(4, 36, 20, 20)}) {
    const cv::Mat_<float> cut = whole(part + cv::Point(70, 70));
    EXPECT_EQ(cv::norm(votes.Elect(part), cut, cv::NORM_INF), 0) << part;
  }
}

}  // namespace
}  // namespace ceilmap::mosaic
