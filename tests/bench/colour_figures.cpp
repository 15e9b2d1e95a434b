#include "tests/bench/colour_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "app/recordings/compass_frames.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/colour_model_file.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/scan_lines.hpp"
#include "localization/compass/colour/white_balance.hpp"

namespace ceilmap::bench {
namespace {

namespace fs = std::filesystem;

recordings::ForwardFrames Open(const fs::path& folder) {
  recordings::ForwardOptions options;
  options.rig = folder / "rig.yaml";
  options.forward = (folder / "forward.mp4").string();
  options.stamps = folder / "frames.csv";
  return recordings::ForwardFrames(options);
}

cv::Vec3b ColourOf(const colour::ColourClass& colour_class) {
  const auto& [y, u, v] = colour_class.mean;
  const cv::Mat yuv(1, 1, CV_32FC3, cv::Scalar(y / 255, u / 255, v / 255));
  cv::Mat bgr;
  cv::cvtColor(yuv, bgr, cv::COLOR_YUV2BGR);
  cv::Vec3b colour;
  for (int c = 0; c < 3; ++c) {
    colour[c] = cv::saturate_cast<std::uint8_t>(255 * bgr.at<cv::Vec3f>(0, 0)[c]);
  }
  return colour;
}

struct TransitionLine {
  cv::Mat image;
  double azimuth_rad = 0;
  Eigen::RowVectorXf transitions;
  std::int64_t different = 0;
};

/// Of all scan lines of a recording of a level robot.
TransitionLine RichestLine(recordings::ForwardFrames& frames,
                           const colour::ColourClasses& classes) {
  const colour::ScanLines lines(frames.Camera());
  TransitionLine best;
  cv::Mat samples;
  colour::LineFeatures features;
  while (frames.Read()) {
    lines.Sample(frames.Current().image, samples);
    CountTransitions(samples, lines, classes, features);
    for (Eigen::Index i = 0; i < features.rows(); ++i) {
      const std::int64_t different = (features.row(i).array() > 0).count();
      if (different <= best.different) continue;
      best = {frames.Current().image.clone(),
              lines.Azimuths()[static_cast<std::size_t>(i)],
              features.row(i),
              different};
    }
  }
  if (best.different == 0) throw InputError("no scan line has a transition between colour classes");
  return best;
}

/// White lines to either side of a scan line, from the horizon up.
void MarkLine(const calib::MountedCamera& forward, double azimuth_rad, cv::Mat& image) {
  constexpr int kAside = 4;  // px
  constexpr double kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    const double elevation = i / kSteps;
    const Eigen::Vector3d p_base(std::cos(azimuth_rad), std::sin(azimuth_rad), std::tan(elevation));
    const auto at = forward.camera.Project(forward.T_base_cam.linear().transpose() * p_base);
    if (!at || at->y() < 0) return;
    for (const int side : {-kAside, kAside}) {
      const cv::Point pixel(static_cast<int>(std::lround(at->x())) + side,
                            static_cast<int>(std::lround(at->y())));
      if (cv::Rect({0, 0}, image.size()).contains(pixel)) {
        image.at<cv::Vec3b>(pixel) = {255, 255, 255};
      }
    }
  }
}

constexpr int kValues = 64;  // of four grey levels each

/// Frequencies of the values of Y, U and V.
using Histograms = std::array<std::array<double, kValues>, 3>;

void Count(const cv::Mat& bgr, Histograms& histograms) {
  cv::Mat yuv;
  cv::cvtColor(bgr, yuv, cv::COLOR_BGR2YUV);
  yuv.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int* /*at*/) { pixel /= 256 / kValues; });
  for (int v = 0; v < yuv.rows; ++v) {
    for (int u = 0; u < yuv.cols; ++u) {
      for (std::size_t c = 0; c < 3; ++c) {
        ++histograms[c][yuv.at<cv::Vec3b>(v, u)[static_cast<int>(c)]];
      }
    }
  }
}

std::vector<cv::Mat> ReadImages(const fs::path& folder,
                                const colour::ColourModel& model,
                                colour::ChannelGains& gains) {
  recordings::ForwardFrames frames = Open(folder);
  const colour::ScanLines lines(frames.Camera());
  colour::WhiteBalance balance(model.classes);
  std::vector<cv::Mat> images;
  cv::Mat samples;
  while (frames.Read()) {
    images.push_back(frames.Current().image.clone());
    lines.Sample(images.back(), samples);
    balance.Add(samples, lines);
  }
  if (images.empty()) throw InputError(folder.string() + ": has no images");
  gains = balance.Gains();
  return images;
}

}  // namespace

void PrintTransitions(const fs::path& model, const fs::path& folder, const fs::path& picture) {
  const colour::ColourClasses classes(colour::ReadColourModel(model).classes);
  recordings::ForwardFrames frames = Open(folder);
  TransitionLine line = RichestLine(frames, classes);
  std::vector<cv::Vec3b> colours;
  fmt::print("kind,from,to,value\n");
  for (const colour::ColourClass& colour_class : classes.Classes()) {
    const cv::Vec3b bgr = ColourOf(colour_class);
    fmt::print("class,{},,{}\n", colours.size(), bgr[2] << 16 | bgr[1] << 8 | bgr[0]);
    colours.push_back(bgr);
  }
  for (int i = 0; i < line.transitions.size(); ++i) {
    fmt::print(
        "transition,{},{},{:.5f}\n", i / classes.Count(), i % classes.Count(), line.transitions[i]);
  }
  line.image.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* /*at*/) {
    const std::uint8_t found = classes.Of(&pixel[0]);
    pixel = found == colour::kNoClass ? cv::Vec3b(255, 0, 255) : colours[found];
  });
  MarkLine(frames.Camera(), line.azimuth_rad, line.image);
  if (!cv::imwrite(picture.string(), line.image)) {
    throw InputError(picture.string() + ": cannot be written");
  }
}

void PrintHistograms(const fs::path& model, const std::vector<fs::path>& folders) {
  const colour::ColourModel learned = colour::ReadColourModel(model);
  fmt::print("folder,channel,value,frequency,balanced\n");
  for (const fs::path& folder : folders) {
    colour::ChannelGains gains{};
    Histograms seen{};
    Histograms balanced{};
    double pixels = 0;
    for (cv::Mat& image : ReadImages(folder, learned, gains)) {
      pixels += static_cast<double>(image.total());
      Count(image, seen);
      colour::Apply(gains, image);
      Count(image, balanced);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t value = 0; value < kValues; ++value) {
        fmt::print("{},{},{},{:.6f},{:.6f}\n",
                   folder.filename().string(),
                   "YUV"[c],
                   value * (256 / kValues),
                   seen[c][value] / pixels,
                   balanced[c][value] / pixels);
      }
    }
  }
}

}  // namespace ceilmap::bench
