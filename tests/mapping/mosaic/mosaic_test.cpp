#include "mapping/mosaic/mosaic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "calib/base/error.hpp"
#include "mapping/store/map_metadata.hpp"
#include "tests/mapping/store/synthetic_map.hpp"

namespace ceilmap::mosaic {
namespace {

using store::synthetic::Brightness;
using store::synthetic::SlowBrightness;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kUnitsPerPx = 0.005;
const cv::Size kViewSize(160, 120);

double NoGain(double /*q*/) {
  return 1;
}

/// Images of a texture from a lawnmower path, and the mosaic made of them.
struct Survey {
  store::MapMetadata metadata = store::synthetic::Metadata(kViewSize, kUnitsPerPx);
  std::vector<graph::Keyframe> keyframes = store::synthetic::Lawnmower(6, 4, 0.24);
  std::vector<cv::Mat> images;

  /// @param gain(k, q)  of keyframe k at squared radius q.
  template <typename Texture, typename Gain>
  Survey(Texture texture, Gain gain) {
    const std::vector<ViewPlacement> views = PlaceViews(keyframes, metadata);
    for (std::size_t k = 0; k < views.size(); ++k) {
      images.push_back(store::synthetic::Photograph(
          views[k], kViewSize, texture, [&](double q) { return gain(k, q); }));
    }
  }
  [[nodiscard]] graph::ImageLoader Loader() const {
    return [this](std::int64_t id) { return images.at(static_cast<std::size_t>(id)); };
  }
  [[nodiscard]] MosaicRenderer Renderer(const MosaicParams& params = {}) const {
    return {keyframes, metadata, Loader(), params};
  }
};

struct Rendered {
  store::MosaicGrid grid;
  cv::Mat grey;
  cv::Mat alpha;

  explicit Rendered(const MosaicRenderer& renderer) : grid(renderer.Grid()) {
    renderer.Render({0, 0, grid.width_px, grid.height_px}, grey, alpha);
  }

  /// Root mean square of grey minus the texture times `scale`, moved by (dx, dy), where the ceiling
  /// was seen.
  template <typename Texture>
  [[nodiscard]] double Rms(Texture texture, double dx = 0, double dy = 0, double scale = 1) const {
    double sum = 0;
    int count = 0;
    for (int row = 0; row < grid.height_px; ++row) {
      for (int col = 0; col < grid.width_px; ++col) {
        if (alpha.at<unsigned char>(row, col) == 0) continue;
        const double x = grid.min_x + (col + 0.5) * grid.resolution;
        const double y = grid.max_y - (row + 0.5) * grid.resolution;
        const double error = grey.at<unsigned char>(row, col) - scale * texture(x + dx, y + dy);
        sum += error * error;
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }

  /// Mean grey over mean texture: what the gauge (mean log gain 0) leaves open.
  template <typename Texture>
  [[nodiscard]] double Scale(Texture texture) const {
    double grey_sum = 0;
    double texture_sum = 0;
    for (int row = 0; row < grid.height_px; ++row) {
      for (int col = 0; col < grid.width_px; ++col) {
        if (alpha.at<unsigned char>(row, col) == 0) continue;
        grey_sum += grey.at<unsigned char>(row, col);
        texture_sum += texture(grid.min_x + (col + 0.5) * grid.resolution,
                               grid.max_y - (row + 0.5) * grid.resolution);
      }
    }
    return grey_sum / texture_sum;
  }
};

MosaicParams Plain() {
  MosaicParams params;
  params.level_exposure = false;
  return params;
}

TEST(Mosaic, OneImageAtTheOriginIsCopiedPixelByPixel) {
  store::MapMetadata metadata = store::synthetic::Metadata({64, 48}, 0.5);
  metadata.T_base_view = {};
  // In keyframe images black is 1, and 0 no content.
  cv::Mat image = cv::max(store::synthetic::Image(1, metadata.view_size), 1);
  const MosaicRenderer renderer(
      {graph::Keyframe{}}, metadata, [&](std::int64_t) { return image; }, Plain());
  const Rendered mosaic(renderer);
  EXPECT_EQ(mosaic.grid.width_px, 64);
  EXPECT_EQ(mosaic.grid.height_px, 48);
  EXPECT_DOUBLE_EQ(mosaic.grid.min_x, -16);
  EXPECT_DOUBLE_EQ(mosaic.grid.max_y, 12);
  EXPECT_EQ(cv::countNonZero(mosaic.alpha), 64 * 48);
  // The image's v grows with y of the view, here of the map; the mosaic's rows run against y.
  cv::Mat expected;
  cv::flip(image, expected, 0);
  EXPECT_EQ(cv::norm(mosaic.grey, expected, cv::NORM_INF), 0);
}

TEST(Mosaic, ShowsTheTextureWhereItBelongs) {
  const Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  const Rendered mosaic(survey.Renderer(Plain()));
  EXPECT_LT(mosaic.Rms(Brightness), 1.5);
  // Moved by a tenth of a pixel in any direction it fits worse: placed to well below a pixel.
  for (const auto& [dx, dy] :
       {std::pair{0.1, 0.0}, std::pair{-0.1, 0.0}, std::pair{0.0, 0.1}, std::pair{0.0, -0.1}}) {
    EXPECT_GT(mosaic.Rms(Brightness, dx * kUnitsPerPx, dy * kUnitsPerPx), mosaic.Rms(Brightness))
        << dx << ' ' << dy;
  }
}

TEST(Mosaic, LevelsGainsAndVignetting) {
  const Survey survey(SlowBrightness, [](std::size_t k, double q) {
    return std::exp(0.15 * std::sin(1.7 * static_cast<double>(k)) - 0.35 * q + 0.1 * q * q);
  });
  const Rendered levelled(survey.Renderer());
  const Rendered plain(survey.Renderer(Plain()));
  EXPECT_LT(levelled.Rms(SlowBrightness, 0, 0, levelled.Scale(SlowBrightness)), 0.8);
  EXPECT_GT(plain.Rms(SlowBrightness, 0, 0, plain.Scale(SlowBrightness)), 5);
  EXPECT_NEAR(levelled.Scale(SlowBrightness), 1, 0.1);
}

TEST(Mosaic, LevellingChangesLittleWhereNothingNeedsIt) {
  const Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  const Rendered mosaic(survey.Renderer());
  EXPECT_LT(mosaic.Rms(Brightness), 1.7);
}

TEST(Mosaic, SaturatedLampsStayWhite) {
  const auto lamps = [](double x, double y) {
    return std::abs(x - 0.6) < 0.15 && std::abs(y - 0.3) < 0.1 ? 400.0 : SlowBrightness(x, y);
  };
  const Survey survey(lamps, [](std::size_t k, double q) {
    return std::exp((k % 2 == 0 ? 0.12 : -0.12) - 0.3 * q);
  });
  const Rendered mosaic(survey.Renderer());
  int lamp_pixels = 0;
  for (int row = 0; row < mosaic.grid.height_px; ++row) {
    for (int col = 0; col < mosaic.grid.width_px; ++col) {
      const double x = mosaic.grid.min_x + (col + 0.5) * mosaic.grid.resolution;
      const double y = mosaic.grid.max_y - (row + 0.5) * mosaic.grid.resolution;
      if (std::abs(x - 0.6) > 0.14 || std::abs(y - 0.3) > 0.09) continue;
      ++lamp_pixels;
      EXPECT_GE(mosaic.grey.at<unsigned char>(row, col), 254) << row << ' ' << col;
    }
  }
  EXPECT_GT(lamp_pixels, 1000);
}

TEST(Mosaic, LeavesOutWhatOnlyOneImageShows) {
  Survey survey(SlowBrightness, [](std::size_t, double q) { return NoGain(q); });
  // In the middle of the survey, where at least three images see each point.
  cv::rectangle(survey.images[8], {50, 40, 50, 40}, cv::Scalar(235), cv::FILLED);
  const Rendered mosaic(survey.Renderer());
  EXPECT_LT(mosaic.Rms(SlowBrightness), 1);
  MosaicParams params;
  params.reject_outliers = false;
  EXPECT_GT(Rendered(survey.Renderer(params)).Rms(SlowBrightness), 4);
}

TEST(Mosaic, SharpImagesCountMoreThanBlurredOnes) {
  Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  for (std::size_t k = 0; k < survey.images.size(); k += 3) {
    cv::GaussianBlur(survey.images[k], survey.images[k], {}, 4);
  }
  MosaicParams params = Plain();
  params.reject_outliers = false;
  params.sharpness_power = 0;
  const double equal_weights = Rendered(survey.Renderer(params)).Rms(Brightness);
  params.sharpness_power = MosaicParams().sharpness_power;
  const Rendered weighted(survey.Renderer(params));
  EXPECT_LT(weighted.Rms(Brightness), 0.6 * equal_weights);
  // Places that only a blurred image shows are there all the same.
  params.sharpness_power = 0;
  EXPECT_EQ(cv::countNonZero(weighted.alpha),
            cv::countNonZero(Rendered(survey.Renderer(params)).alpha));
}

TEST(Mosaic, AnyWindowShowsTheSameAsTheWhole) {
  const Survey survey(Brightness, [](std::size_t k, double q) {
    return 1 - 0.1 * q + 0.01 * static_cast<double>(k % 5);
  });
  MosaicParams params;
  params.cache_images = 2;
  const MosaicRenderer renderer = survey.Renderer(params);
  const Rendered whole(renderer);
  for (const cv::Rect& window :
       {cv::Rect(13, 7, 201, 99), cv::Rect(255, 100, 2, 60), cv::Rect(100, 0, 1, 1)}) {
    cv::Mat grey;
    cv::Mat alpha;
    renderer.Render(window, grey, alpha);
    EXPECT_EQ(cv::norm(grey, whole.grey(window), cv::NORM_INF), 0) << window;
    EXPECT_EQ(cv::norm(alpha, whole.alpha(window), cv::NORM_INF), 0) << window;
  }
  cv::Mat grey;
  cv::Mat alpha;
  EXPECT_THROW(renderer.Render({0, 0, 100000, 1}, grey, alpha), InputError);
}

TEST(Mosaic, RenderMayBeCalledFromSeveralThreads) {
  const Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  MosaicParams params;
  params.cache_images = 3;
  params.threads = 2;
  const MosaicRenderer renderer = survey.Renderer(params);
  const Rendered whole(renderer);
  std::vector<double> differences(4, -1);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < differences.size(); ++t) {
      threads.emplace_back([&, t] {
        const cv::Rect window(static_cast<int>(20 * t), 10, 250, 150);
        cv::Mat grey;
        cv::Mat alpha;
        renderer.Render(window, grey, alpha);
        differences[t] = cv::norm(grey, whole.grey(window), cv::NORM_INF);
      });
    }
  }
  EXPECT_EQ(differences, std::vector<double>(4, 0.0));
}

TEST(Mosaic, CoarserMosaicAveragesInsteadOfSkipping) {
  // A checkerboard of single pixels must turn grey, not into an arbitrary pattern.
  const Survey survey(
      [](double x, double y) { return 128 + 100 * std::sin(600 * x) * std::sin(600 * y); },
      [](std::size_t, double q) { return NoGain(q); });
  MosaicParams params = Plain();
  params.resolution = 4 * kUnitsPerPx;
  const Rendered mosaic(survey.Renderer(params));
  EXPECT_DOUBLE_EQ(mosaic.grid.resolution, 0.02);
  EXPECT_LT(mosaic.Rms([](double, double) { return 128.0; }), 8);
}

TEST(Mosaic, MaskedPixelsAreNotPartOfTheMosaic) {
  store::MapMetadata metadata = store::synthetic::Metadata({64, 48}, 0.5);
  metadata.T_base_view = {};
  MosaicParams params = Plain();
  params.view_mask = cv::Mat(48, 64, CV_8UC1, cv::Scalar(255));
  params.view_mask(cv::Rect(0, 0, 10, 48)).setTo(0);
  cv::Mat image(48, 64, CV_8UC1, cv::Scalar(99));
  const Rendered mosaic(MosaicRenderer(
      {graph::Keyframe{}}, metadata, [&](std::int64_t) { return image; }, params));
  EXPECT_EQ(cv::countNonZero(mosaic.alpha), 54 * 48);
  EXPECT_EQ(cv::countNonZero(mosaic.alpha(cv::Rect(0, 0, 10, 48))), 0);
}

// Images of a tilted robot end at slanting borders, beyond which they are 0.
TEST(Mosaic, BlankBordersLeaveNoDarkSeam) {
  Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  const Rendered before(survey.Renderer());
  for (const std::size_t k : {7U, 8U, 14U}) {
    const std::vector<cv::Point> wedge = {{0, 0}, {159, 0}, {159, 20}, {0, 45}};
    cv::fillConvexPoly(survey.images[k], wedge, cv::Scalar(0));
    survey.images[k].col(159).setTo(0);
  }
  for (const MosaicParams& params : {MosaicParams{}, Plain()}) {
    const Rendered mosaic(survey.Renderer(params));
    EXPECT_LT(mosaic.Rms(Brightness), 1.15 * before.Rms(Brightness) + 0.1);
    cv::Mat dark = mosaic.grey < 50;  // no texture is
    EXPECT_EQ(cv::countNonZero(dark & mosaic.alpha), 0);
    // Others see what those images do not.
    EXPECT_EQ(cv::countNonZero(mosaic.alpha), cv::countNonZero(before.alpha));
  }
}

TEST(Mosaic, PixelsWithoutContentAreTransparent) {
  store::MapMetadata metadata = store::synthetic::Metadata({64, 48}, 0.5);
  metadata.T_base_view = {};
  cv::Mat image(48, 64, CV_8UC1, cv::Scalar(99));
  image(cv::Rect(0, 0, 10, 48)).setTo(0);
  image.at<unsigned char>(20, 40) = 0;
  const Rendered mosaic(MosaicRenderer(
      {graph::Keyframe{}}, metadata, [&](std::int64_t) { return image; }, Plain()));
  EXPECT_EQ(cv::countNonZero(mosaic.alpha(cv::Rect(0, 0, 10, 48))), 0);
  EXPECT_EQ(cv::countNonZero(mosaic.alpha(cv::Rect(11, 0, 20, 48))), 20 * 48);
}

TEST(Mosaic, GridCoversAllImagesOnMultiplesOfTheResolution) {
  const Survey survey(Brightness, [](std::size_t, double q) { return NoGain(q); });
  const store::MosaicGrid grid = survey.Renderer().Grid();
  EXPECT_NEAR(grid.min_x / grid.resolution, std::round(grid.min_x / grid.resolution), 1e-6);
  EXPECT_NEAR(grid.max_y / grid.resolution, std::round(grid.max_y / grid.resolution), 1e-6);
  for (const ViewPlacement& view : PlaceViews(survey.keyframes, survey.metadata)) {
    const cv::Rect2d box = view.Bounds();
    EXPECT_GE(box.x, grid.min_x - 1e-9);
    EXPECT_LE(box.br().y, grid.max_y + 1e-9);
    EXPECT_LE(box.br().x, grid.min_x + grid.width_px * grid.resolution + 1e-9);
    EXPECT_GE(box.y, grid.max_y - grid.height_px * grid.resolution - 1e-9);
  }
}

TEST(Mosaic, BecomesCoarserWhereItWouldBeTooLarge) {
  const store::MapMetadata metadata = store::synthetic::Metadata({64, 48}, 0.5);
  cv::Mat image = store::synthetic::Image(1, metadata.view_size);
  std::vector<graph::Keyframe> far(2);
  far[1].id = 1;
  far[1].pose.T_map_base.x = 1e8;
  const MosaicRenderer renderer(far, metadata, [&](std::int64_t) { return image; });
  const store::MosaicGrid grid = renderer.Grid();
  EXPECT_EQ(store::Problem(grid), "");
  EXPECT_GE(grid.width_px * grid.resolution, 1e8);
  EXPECT_EQ(std::exp2(std::round(std::log2(grid.resolution / 0.5))) * 0.5, grid.resolution);
}

TEST(Mosaic, RefusesWrongInput) {
  const store::MapMetadata metadata = store::synthetic::Metadata({64, 48}, 0.5);
  const graph::ImageLoader no_image = [](std::int64_t) { return cv::Mat(); };
  EXPECT_THROW(MosaicRenderer({}, metadata, no_image), InputError);
  EXPECT_THAT(([&] { const MosaicRenderer renderer({graph::Keyframe{}}, metadata, no_image); }),
              ThrowsMessage<RunError>(HasSubstr("image of keyframe 0")));
  MosaicParams params;
  params.sharpness_power = -1;
  EXPECT_THAT([&] { params.Validate(); },
              ThrowsMessage<InputError>(HasSubstr("sharpness_power = -1")));
  params = {};
  params.resolution = std::nan("");
  EXPECT_THROW(params.Validate(), InputError);
  params = {};
  params.cache_images = 0;
  EXPECT_THROW(params.Validate(), InputError);
  params = {};
  params.threads = -1;
  EXPECT_THROW(params.Validate(), InputError);
}

}  // namespace
}  // namespace ceilmap::mosaic
