#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

namespace ceilmap::support {

/// A ceiling with texture at several scales, the same at every call.
inline cv::Mat SyntheticCeiling(cv::Size size) {
  constexpr std::uint64_t kSeed = 20100417;
  cv::RNG random(kSeed);
  cv::Mat ceiling(size, CV_32F, cv::Scalar(0));
  for (const int cell : {64, 16, 6}) {
    cv::Mat noise(size.height / cell + 2, size.width / cell + 2, CV_32F);
    random.fill(noise, cv::RNG::NORMAL, 0, 1);
    cv::Mat layer;
    cv::resize(noise, layer, size, 0, 0, cv::INTER_CUBIC);
    ceiling += layer;
  }
  cv::Mat grey;
  cv::normalize(ceiling, grey, 20, 235, cv::NORM_MINMAX, CV_8U);
  return grey;
}

/// Images of `size` cut out of the ceiling, each `step` further: whole pixels, so the motion is
/// known exactly. The camera moves by `step`, the content by its opposite.
inline std::vector<cv::Mat> CropAlong(const cv::Mat& ceiling,
                                      cv::Size size,
                                      cv::Point step,
                                      int count) {
  std::vector<cv::Mat> images;
  images.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    images.push_back(ceiling(cv::Rect(cv::Point(10, 10) + i * step, size)).clone());
  }
  return images;
}

/// `frame0.png`, `frame1.png`, ... in a folder that is made.
inline void WriteImages(const std::filesystem::path& folder, const std::vector<cv::Mat>& images) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < images.size(); ++i) {
    cv::imwrite((folder / fmt::format("frame{}.png", i)).string(), images[i]);
  }
}

/// Motion JPEG in an AVI file.
inline void WriteVideo(const std::filesystem::path& file,
                       const std::vector<cv::Mat>& images,
                       double frames_per_s) {
  cv::VideoWriter writer(file.string(),
                         cv::CAP_OPENCV_MJPEG,
                         cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                         frames_per_s,
                         images.front().size(),
                         true);
  writer.set(cv::VIDEOWRITER_PROP_QUALITY, 95);
  for (const cv::Mat& image : images) {
    cv::Mat colour;
    cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
    writer.write(colour);
  }
}

inline std::string StampsCsv(int count, double first_s, double period_s) {
  std::string text = "index,timestamp\n";
  for (int i = 0; i < count; ++i) text += fmt::format("{},{:.6f}\n", i, first_s + i * period_s);
  return text;
}

}  // namespace ceilmap::support
