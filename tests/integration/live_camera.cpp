#include "tests/integration/live_camera.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "app/terminal/clock.hpp"

extern "C" {
#include <libavformat/avformat.h>
}

namespace ceilmap::integration {
namespace {

constexpr int kTicks = 1000;  // of the time stamps, per image

std::vector<std::string> Encode(const std::vector<cv::Mat>& images) {
  std::vector<std::string> jpegs;
  for (const cv::Mat& image : images) {
    std::vector<uchar> code;
    cv::imencode(".jpg", image, code);
    jpegs.emplace_back(code.begin(), code.end());
  }
  return jpegs;
}

/// Puts JPEG images into NUT, a container that can be written and read image by image.
class NutWriter {
 public:
  explicit NutWriter(cv::Size size) {
    constexpr int kBuffer = 1 << 16;
    avformat_alloc_output_context2(&format_, nullptr, "nut", nullptr);
    auto* const buffer = static_cast<unsigned char*>(av_malloc(kBuffer));
    format_->pb = avio_alloc_context(buffer, kBuffer, 1, &bytes_, nullptr, Collect, nullptr);
    format_->pb->seekable = 0;
    AVStream* const stream = avformat_new_stream(format_, nullptr);
    stream->time_base = {1, static_cast<int>(LiveCamera::kRate) * kTicks};
    stream->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    stream->codecpar->codec_id = AV_CODEC_ID_MJPEG;
    stream->codecpar->format = AV_PIX_FMT_GRAY8;
    stream->codecpar->width = size.width;
    stream->codecpar->height = size.height;
    EXPECT_GE(avformat_write_header(format_, nullptr), 0);
  }
  ~NutWriter() {
    av_freep(&format_->pb->buffer);
    avio_context_free(&format_->pb);
    avformat_free_context(format_);
  }
  NutWriter(const NutWriter&) = delete;
  NutWriter& operator=(const NutWriter&) = delete;

  /// The bytes of the image with this number; the first time with the header before them.
  std::string Add(const std::string& jpeg, int number) {
    AVPacket* packet = av_packet_alloc();
    EXPECT_EQ(av_new_packet(packet, static_cast<int>(jpeg.size())), 0);
    std::copy(jpeg.begin(), jpeg.end(), packet->data);
    packet->flags |= AV_PKT_FLAG_KEY;
    packet->pts = packet->dts = av_rescale_q(
        number, {1, static_cast<int>(LiveCamera::kRate)}, format_->streams[0]->time_base);
    EXPECT_GE(av_write_frame(format_, packet), 0);
    av_packet_free(&packet);
    avio_flush(format_->pb);
    return std::exchange(bytes_, {});
  }
  std::string End() {
    av_write_trailer(format_);
    return std::exchange(bytes_, {});
  }

 private:
  static int Collect(void* bytes, unsigned char* data, int size) {
    static_cast<std::string*>(bytes)->append(reinterpret_cast<char*>(data),
                                             static_cast<std::size_t>(size));
    return size;
  }

  AVFormatContext* format_ = nullptr;
  std::string bytes_;
};

cv::Size SizeOf(const std::string& jpeg) {
  const std::vector<uchar> code(jpeg.begin(), jpeg.end());
  return cv::imdecode(code, cv::IMREAD_GRAYSCALE).size();
}

}  // namespace

LiveCamera::LiveCamera(const std::vector<cv::Mat>& images, int breaks_after)
    : jpegs_(Encode(images)), breaks_after_(breaks_after) {
  server_.Get("/up", [this](const httplib::Request&, httplib::Response& response) {
    response.set_chunked_content_provider(
        "video/x-nut", [this](std::size_t, httplib::DataSink& sink) { return Send(sink); });
  });
  server_.new_task_queue = [] { return new httplib::ThreadPool(1); };
  server_.set_keep_alive_max_count(1);
  port_ = server_.bind_to_any_port("127.0.0.1");
  thread_ = std::thread([this] { server_.listen_after_bind(); });
}

LiveCamera::~LiveCamera() {
  {
    const std::scoped_lock lock(stop_mutex_);
    stop_ = true;
  }
  stopped_.notify_all();
  server_.stop();
  thread_.join();
}

std::string LiveCamera::Url() const {
  return fmt::format("http://127.0.0.1:{}/up", port_);
}

// A camera has an image only after it was taken. False when the camera is switched off meanwhile.
bool LiveCamera::WaitUntilTaken(int image) {
  const double wait_s = start_s_ + image / kRate - terminal::SteadySeconds();
  std::unique_lock lock(stop_mutex_);
  return !stopped_.wait_for(lock, std::chrono::duration<double>(wait_s), [this] { return stop_; });
}

// After the last image the camera is there, but has nothing to send.
bool LiveCamera::Send(httplib::DataSink& sink) {
  if (connections_++ == 0) {
    start_s_ = terminal::SteadySeconds();
  } else {
    const double passed = (terminal::SteadySeconds() - start_s_) * kRate;
    next_ = std::max(next_, static_cast<int>(std::ceil(passed)));
  }
  int end = static_cast<int>(jpegs_.size());
  if (connections_ == 1) end = std::min(end, breaks_after_);
  NutWriter nut(SizeOf(jpegs_.front()));
  for (; next_ < end; ++next_) {
    if (!WaitUntilTaken(next_)) return false;
    const std::string bytes = nut.Add(jpegs_[static_cast<std::size_t>(next_)], next_);
    if (!sink.write(bytes.data(), bytes.size())) return false;
  }
  sink.done();
  return true;
}

void WriteNut(const std::string& file, const std::vector<cv::Mat>& images) {
  NutWriter nut(images.front().size());
  std::ofstream out(file, std::ios::binary);
  int number = 0;
  for (const std::string& jpeg : Encode(images)) out << nut.Add(jpeg, number++);
  out << nut.End();
}

}  // namespace ceilmap::integration
