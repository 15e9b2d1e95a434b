#include "mapping/registration/impulses.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

/// One pixel in this number is black or white.
cv::Mat Salted(const cv::Mat& image, int one_in, unsigned seed) {
  cv::Mat salted = image.clone();
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::size_t> place(0, salted.total() - 1);
  for (std::size_t i = 0; i < salted.total() / static_cast<std::size_t>(one_in); ++i) {
    salted.data[place(random)] = i % 2 == 0 ? 255 : 0;
  }
  return salted;
}

TEST(WithoutImpulses, LeavesAImageAsItIs) {
  cv::Mat buffer;
  const cv::Mat image = SyntheticCeiling().Render(kSize, {}, 4);
  EXPECT_EQ(WithoutImpulses(image, buffer).data, image.data);
  const cv::Mat few = Salted(image, 10000, 1);
  EXPECT_EQ(WithoutImpulses(few, buffer).data, few.data) << "not worth its grain";
}

TEST(WithoutImpulses, TakesThemOut) {
  cv::Mat buffer;
  const cv::Mat image = SyntheticCeiling().Render(kSize, {}, 1);
  const cv::Mat salted = Salted(image, 200, 1);
  const double before = cv::norm(salted, image, cv::NORM_L2);
  EXPECT_LT(cv::norm(WithoutImpulses(salted, buffer), image, cv::NORM_L2), 0.2 * before);
}

TEST_F(RegistrarTest, SaltedImages) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{14.3, -22.6, 0.21, 1};
  for (const int one_in : {500, 50}) {
    const Registration r = Register(Salted(ceiling.Render(kSize, {}, 2, 1), one_in, 1),
                                    Salted(ceiling.Render(kSize, truth, 2, 2), one_in, 2));
    ASSERT_TRUE(r.ok()) << one_in;
    EXPECT_LT(ShiftError(r.motion, truth), 0.1) << one_in;
  }
}

}  // namespace
}  // namespace ceilmap::registration
