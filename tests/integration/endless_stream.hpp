#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>
#include <vector>

namespace ceilmap::integration {

/// Endless Motion JPEG into a pipe, to and fro through the images, until the reader stops.
class EndlessStream {
 public:
  EndlessStream(const std::filesystem::path& pipe, const std::vector<cv::Mat>& images) {
    signal(SIGPIPE, SIG_IGN);
    EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const cv::Mat& image : images) {
      std::vector<uchar> code;
      cv::imencode(".jpg", image, code);
      images_.push_back(std::move(code));
    }
    const std::vector<std::vector<uchar>> there = images_;
    images_.insert(images_.end(), there.rbegin(), there.rend());
    writer_ = std::thread([this, pipe] {
      std::ofstream stream(pipe, std::ios::binary);
      for (std::size_t i = 0; stream; i = (i + 1) % images_.size()) {
        const std::vector<uchar>& code = images_[i];
        stream.write(reinterpret_cast<const char*>(code.data()),
                     static_cast<std::streamsize>(code.size()));
      }
    });
  }
  ~EndlessStream() { writer_.join(); }
  EndlessStream(const EndlessStream&) = delete;
  EndlessStream& operator=(const EndlessStream&) = delete;

 private:
  std::vector<std::vector<uchar>> images_;
  std::thread writer_;
};

}  // namespace ceilmap::integration
