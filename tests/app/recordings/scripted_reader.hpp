#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "app/recordings/frame_reader.hpp"

namespace ceilmap::recordings {

/// A live source that delivers flat images, by their brightness and their time.
class ScriptedReader : public FrameReader {
 public:
  struct Image {
    int brightness = 0;
    std::optional<double> time_s;
    cv::Size size = {4, 4};
  };

  explicit ScriptedReader(std::vector<Image> images, bool fails = false)
      : images_(std::move(images)), fails_(fails) {}

  bool Next(cv::Mat& image, std::optional<double>& time_s) override {
    if (next_ == images_.size()) return false;
    const Image& next = images_[next_++];
    image = cv::Mat(next.size, CV_8UC1, cv::Scalar(next.brightness));
    time_s = next.time_s;
    return true;
  }
  [[nodiscard]] Kind GetKind() const override { return Kind::kLive; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override { return std::nullopt; }
  [[nodiscard]] std::int64_t LeftOut() const override { return left_out; }
  [[nodiscard]] bool Failed() const override { return fails_; }

  std::int64_t left_out = 0;

 private:
  std::vector<Image> images_;
  bool fails_;
  std::size_t next_ = 0;
};

}  // namespace ceilmap::recordings
