#include "mapping/mosaic/image_cache.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace ceilmap::mosaic {
namespace {

TEST(ImageCache, LoadsOnceAndDropsTheLongestUnused) {
  std::vector<std::int64_t> loads;
  ImageCache cache(
      [&](std::int64_t id) {
        loads.push_back(id);
        return cv::Mat(1, 1, CV_8UC1, cv::Scalar(static_cast<double>(id)));
      },
      2);
  for (const int id : {1, 2, 1, 3, 1, 2}) EXPECT_EQ(cache.Get(id)->at<unsigned char>(0, 0), id);
  EXPECT_EQ(loads, (std::vector<std::int64_t>{1, 2, 3, 2}));
}

TEST(ImageCache, AFailedLoadIsTriedAgain) {
  int calls = 0;
  ImageCache cache(
      [&](std::int64_t) {
        if (++calls == 1) throw std::runtime_error("not yet");
        return cv::Mat(1, 1, CV_8UC1);
      },
      1);
  EXPECT_THROW((void)cache.Get(5), std::runtime_error);
  EXPECT_FALSE(cache.Get(5)->empty());
}

TEST(ImageCache, ThreadsShareOneLoad) {
  std::atomic<int> loads{0};
  std::atomic<int> wrong{0};
  ImageCache cache(
      [&](std::int64_t id) {
        ++loads;
        return cv::Mat(1, 1, CV_8UC1, cv::Scalar(static_cast<double>(id)));
      },
      8);
  {
    std::vector<std::jthread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 400; ++i) {
          if (cache.Get(i % 8)->at<unsigned char>(0, 0) != i % 8) ++wrong;
        }
      });
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(loads, 8);
}

}  // namespace
}  // namespace ceilmap::mosaic
