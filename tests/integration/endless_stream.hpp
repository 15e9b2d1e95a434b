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

/// Endless Motion JPEG into a pipe, to and fro through the pictures, until nobody reads any more.
class EndlessStream {
 public:
  EndlessStream(const std::filesystem::path& pipe, const std::vector<cv::Mat>& pictures) {
    signal(SIGPIPE, SIG_IGN);
    EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const cv::Mat& picture : pictures) {
      std::vector<uchar> code;
      cv::imencode(".jpg", picture, code);
      pictures_.push_back(std::move(code));
    }
    const std::vector<std::vector<uchar>> there = pictures_;
    pictures_.insert(pictures_.end(), there.rbegin(), there.rend());
    writer_ = std::thread([this, pipe] {
      std::ofstream stream(pipe, std::ios::binary);
      for (std::size_t i = 0; stream; i = (i + 1) % pictures_.size()) {
        const std::vector<uchar>& code = pictures_[i];
        stream.write(reinterpret_cast<const char*>(code.data()),
                     static_cast<std::streamsize>(code.size()));
      }
    });
  }
  ~EndlessStream() { writer_.join(); }
  EndlessStream(const EndlessStream&) = delete;
  EndlessStream& operator=(const EndlessStream&) = delete;

 private:
  std::vector<std::vector<uchar>> pictures_;
  std::thread writer_;
};

}  // namespace ceilmap::integration
