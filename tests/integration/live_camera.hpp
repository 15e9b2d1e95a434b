#pragma once

#include <httplib.h>

#include <condition_variable>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <vector>

namespace ceilmap::integration {

/// A network camera at 127.0.0.1: Motion JPEG with time stamps in NUT over HTTP, 30 images a second
/// from the first request on. A client that comes later gets the images from then on.
class LiveCamera {
 public:
  static constexpr double kRate = 30;

  /// @param breaks_after  The first connection is closed after that many images.
  explicit LiveCamera(const std::vector<cv::Mat>& images, int breaks_after = 1 << 30);
  ~LiveCamera();
  LiveCamera(const LiveCamera&) = delete;
  LiveCamera& operator=(const LiveCamera&) = delete;

  [[nodiscard]] std::string Url() const;

 private:
  bool Send(httplib::DataSink& sink);
  bool WaitUntilTaken(int image);

  std::vector<std::string> jpegs_;
  int breaks_after_;
  int connections_ = 0;
  int next_ = 0;  // image
  double start_s_ = 0;
  std::mutex stop_mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

/// The same images with the same times as a file. The folder must exist.
void WriteNut(const std::string& file, const std::vector<cv::Mat>& images);

}  // namespace ceilmap::integration
