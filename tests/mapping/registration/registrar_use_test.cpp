// How the registrar is used: sizes, wrong arguments, memory, threads.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

TEST(Registrar, OtherSizes) {
  for (const cv::Size size :
       {cv::Size(320, 240), cv::Size(641, 479), cv::Size(1280, 720), cv::Size(300, 400)}) {
    Registrar registrar(size);
    const SyntheticCeiling ceiling({.tile_px = 70});
    const ImageMotion truth{17.25, -23.5, 0.8, 1};
    const FrameSpectrum a = registrar.Analyze(ceiling.Render(size));
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(size, truth));
    EXPECT_THAT(registrar.Register(a, b), IsMotion(truth, 0.02, 0.02)) << size;
  }
}

TEST(Registrar, ReleasedBlocksAreComputedAgain) {
  const cv::Size size(320, 240);
  Registrar registrar(size);
  const SyntheticCeiling ceiling({.tile_px = 70});
  FrameSpectrum a = registrar.Analyze(ceiling.Render(size));
  const FrameSpectrum b = registrar.Analyze(ceiling.Render(size, {17.25, -23.5, 0.8, 1}));
  const Registration before = registrar.Register(a, b);
  ASSERT_TRUE(before.ok());
  const FrameSpectrum shared = a;
  a.ReleaseBlocks();  // not while they are shared
  EXPECT_EQ(registrar.Register(shared, b).motion.tx_px, before.motion.tx_px);
  FrameSpectrum().ReleaseBlocks();
  FrameSpectrum alone = registrar.Analyze(ceiling.Render(size));
  for (int i = 0; i < 2; ++i) {
    const Registration after = registrar.Register(alone, b);
    EXPECT_EQ(after.motion.tx_px, before.motion.tx_px);
    EXPECT_EQ(after.motion.ty_px, before.motion.ty_px);
    EXPECT_EQ(after.inliers, before.inliers);
    alone.ReleaseBlocks();
  }
}

// A pixel of a small image covers more, so tiles and grooves are smaller.
CeilingParams SmallImageParams(std::uint32_t seed) {
  return {.seed = seed, .tile_px = 24.0 + seed % 17, .groove_grey = seed % 2 == 0 ? 20.0 : 35.0};
}

const std::vector<cv::Size>& SmallSizes() {
  static const std::vector<cv::Size> kSizes = {{160, 120}, {96, 96}, {400, 100}, {220, 220}};
  return kSizes;
}

TEST(Registrar, SmallImages) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const cv::Size size : SmallSizes()) {
    Registrar registrar(size);
    const double reach_px = 0.2 * std::min(size.width, size.height);
    int pairs = 0;
    int found = 0;
    for (std::uint32_t i = 0; i < 24; ++i) {
      const ImageMotion truth{
          reach_px * unit(random), reach_px * unit(random), kPi * unit(random), 1};
      if (OverlapOf(truth, size) < 0.7) continue;
      ++pairs;
      const SyntheticCeiling ceiling(SmallImageParams(i));
      const FrameSpectrum a = registrar.Analyze(ceiling.Render(size, {}, 2, i));
      const FrameSpectrum b = registrar.Analyze(ceiling.Render(size, truth, 2, i + 500));
      const Registration r = registrar.Register(a, b);
      if (!r.ok()) continue;
      ++found;
      EXPECT_LT(ShiftError(r.motion, truth), 0.35) << size << i;
      EXPECT_LT(AngleErrorDeg(r.motion, truth), 0.5) << size << i;
      EXPECT_LT(std::sqrt(r.covariance(0, 0)), 0.2) << size << i;
    }
    EXPECT_GE(pairs, 4) << size;
    EXPECT_GE(found, pairs - 1) << size;
  }
}

TEST(Registrar, SmallImagesOfOtherPlaces) {
  enum class There { kPlaster, kOtherTiles, kSameTiles };
  for (const cv::Size size : SmallSizes()) {
    Registrar registrar(size, WithScale());
    for (std::uint32_t i = 0; i < 36; ++i) {
      const auto kind = static_cast<There>(i % 3);
      CeilingParams here = SmallImageParams(i);
      if (kind == There::kPlaster) here.tile_px = 0;
      CeilingParams there = here;
      if (kind != There::kSameTiles) there.seed += 10000;
      if (kind == There::kOtherTiles) there.tile_px = 28 + i * 7 % 19;
      const ImageMotion far{4000.0 + 37 * i, -3000, 0.3 * i, 1};
      const FrameSpectrum a = registrar.Analyze(SyntheticCeiling(here).Render(size, {}, 2, i));
      const FrameSpectrum b =
          registrar.Analyze(SyntheticCeiling(there).Render(size, far, 2, i + 500));
      const Registration r = registrar.Register(a, b);
      EXPECT_FALSE(r.ok()) << size << i << ", peak " << r.peak << ", runner-up " << r.runner_up;
    }
  }
}

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST_F(RegistrarTest, RefusesOtherImages) {
  EXPECT_EQ(MessageOf([&] { (void)registrar_.Analyze(cv::Mat::zeros(kSize, CV_8UC3)); }),
            "image of 640x480 where 640x480 grey is expected");
  EXPECT_EQ(MessageOf([&] { (void)registrar_.Analyze(cv::Mat::zeros(480, 641, CV_8UC1)); }),
            "image of 641x480 where 640x480 grey is expected");
  EXPECT_THROW((void)registrar_.Analyze(cv::Mat()), InputError);
}

TEST_F(RegistrarTest, ARowStrideIsNoHindrance) {
  const SyntheticCeiling ceiling;
  cv::Mat wide(480, 700, CV_8UC1, cv::Scalar(0));
  const cv::Mat image = ceiling.Render(kSize, {12, 5, 0.1, 1});
  image.copyTo(wide(cv::Rect(30, 0, 640, 480)));
  const cv::Mat reference = ceiling.Render(kSize);
  const Registration dense = Register(reference, image);
  const Registration strided = Register(reference, wide(cv::Rect(30, 0, 640, 480)));
  EXPECT_EQ(dense.motion.tx_px, strided.motion.tx_px);
  EXPECT_EQ(dense.motion.theta_rad, strided.motion.theta_rad);
}

TEST(Registrar, RefusesSizes) {
  EXPECT_EQ(MessageOf([] {
              Registrar registrar({95, 480});
            }),
            "images of 95x480 cannot be registered; each side must have 96 to 16384 pixels");
  EXPECT_THROW(Registrar({640, 16385}), InputError);
  EXPECT_THROW(Registrar({0, 0}), InputError);
  EXPECT_NO_THROW(Registrar({96, 96}));
}

TEST_F(RegistrarTest, RefusesEmptySpectra) {
  const FrameSpectrum a = registrar_.Analyze(SyntheticCeiling().Render(kSize));
  EXPECT_TRUE(FrameSpectrum().empty());
  EXPECT_FALSE(a.empty());
  EXPECT_THROW((void)registrar_.Register(a, {}), std::invalid_argument);
  EXPECT_THROW((void)registrar_.Register({}, a), std::invalid_argument);
  EXPECT_THROW((void)registrar_.Refine({}, a, {}), std::invalid_argument);
}

void ExpectSame(const Registration& a, const Registration& b) {
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.motion.tx_px, b.motion.tx_px);
  EXPECT_EQ(a.motion.ty_px, b.motion.ty_px);
  EXPECT_EQ(a.motion.theta_rad, b.motion.theta_rad);
  EXPECT_EQ(a.motion.scale, b.motion.scale);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.peak, b.peak);
  EXPECT_EQ(a.runner_up, b.runner_up);
  EXPECT_EQ(a.blocks, b.blocks);
  EXPECT_EQ(a.inliers, b.inliers);
}

TEST_F(RegistrarTest, SameInputSameBits) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference = ceiling.Render(kSize, {}, 3, 1);
  const cv::Mat current = ceiling.Render(kSize, {-44, 61, 1.2, 1}, 3, 2);
  const cv::Mat other = ceiling.Render(kSize, {200, 5, 3, 1}, 3, 3);
  const Registration first = Register(reference, current);
  ASSERT_TRUE(first.ok());
  // Not even what the registrar did in between, or which registrar it is, matters.
  Register(other, current);
  ExpectSame(Register(reference, current), first);
  Registrar fresh(kSize);
  const FrameSpectrum a = fresh.Analyze(reference);
  ExpectSame(fresh.Register(a, fresh.Analyze(current)), first);
}

TEST_F(RegistrarTest, SpectraOutliveManyFramesThatCameAfter) {
  // Buffers are used again once no one holds them, and not before.
  const SyntheticCeiling ceiling;
  const ImageMotion truth{-44, 61, 1.2, 1};
  const FrameSpectrum reference = registrar_.Analyze(ceiling.Render(kSize));
  const FrameSpectrum current = registrar_.Analyze(ceiling.Render(kSize, truth));
  const Registration before = registrar_.Register(reference, current);
  const cv::Mat other = ceiling.Render(kSize, {500, 300, 0, 1});
  for (int i = 0; i < 20; ++i) {
    const FrameSpectrum passing = registrar_.Analyze(other);
    (void)registrar_.Register(passing, passing);
  }
  ExpectSame(registrar_.Register(reference, current), before);
}

TEST_F(RegistrarTest, TwoThreadsShareAReference) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference_image = ceiling.Render(kSize);
  constexpr std::size_t kFrames = 3;
  std::vector<cv::Mat> frames;
  for (std::size_t i = 0; i < 2 * kFrames; ++i) {
    const double step = static_cast<double>(i);
    frames.push_back(ceiling.Render(kSize, {15 * step - 40, 8 * step, 0.4 * step, 1}));
  }
  std::vector<Registration> alone;
  alone.reserve(frames.size());
  for (const cv::Mat& frame : frames) alone.push_back(Register(reference_image, frame));

  // Both threads make the shared reference ready, at about the same time.
  const FrameSpectrum reference = registrar_.Analyze(reference_image);
  std::vector<Registration> shared(frames.size());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 2; ++t) {
    threads.emplace_back([&, t] {
      Registrar registrar(kSize);
      for (std::size_t i = t * kFrames; i < (t + 1) * kFrames; ++i) {
        shared[i] = registrar.Register(reference, registrar.Analyze(frames[i]));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_TRUE(alone[i].ok()) << i;
    ExpectSame(shared[i], alone[i]);
  }
}

TEST_F(RegistrarTest, SpectraMayEndInAnotherThread) {
  const SyntheticCeiling ceiling;
  const cv::Mat image = ceiling.Render(kSize);
  const Registration expected = Register(image, image);
  std::vector<Registration> results(4);
  for (Registration& result : results) {
    const FrameSpectrum reference = registrar_.Analyze(image);
    std::thread user([&result, spectrum = reference] {
      Registrar registrar(kSize);
      result = registrar.Register(spectrum, spectrum);
    });
    FrameSpectrum meanwhile = registrar_.Analyze(image);
    user.join();
  }
  for (const Registration& result : results) ExpectSame(result, expected);
}

}  // namespace
}  // namespace ceilmap::registration
