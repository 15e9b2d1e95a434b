#include "app/video_reader.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libswscale/swscale.h>
}

#include "calib/error.hpp"

namespace ceilmap::app {
namespace {

using Clock = std::chrono::steady_clock;

// FFmpeg's objects are released through a pointer to their pointer.
struct Release {
  void operator()(AVFormatContext* x) const { avformat_close_input(&x); }
  void operator()(AVCodecContext* x) const { avcodec_free_context(&x); }
  void operator()(AVFrame* x) const { av_frame_free(&x); }
  void operator()(AVPacket* x) const { av_packet_free(&x); }
  void operator()(SwsContext* x) const { sws_freeContext(x); }
};
template <typename T>
using Held = std::unique_ptr<T, Release>;

const char* WhyNotOpen(VideoReader::Input input) {
  return input == VideoReader::Input::kStream
             ? "the stream cannot be opened; check the address and the network"
             : "is not a video that can be decoded";
}

bool StandsAlone(AVCodecID codec) {
  const AVCodecDescriptor* const descriptor = avcodec_descriptor_get(codec);
  return descriptor != nullptr && (descriptor->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
}

}  // namespace

struct VideoReader::Decoder {
  bool Open(const std::string& name, Input input);
  /// The next picture that can be trusted, in `frame`; false at the end.
  bool Decode();
  void Convert(cv::Mat& bgr);
  [[nodiscard]] std::optional<double> Time() const;
  [[nodiscard]] cv::Size Size() const { return {codec_->width, codec_->height}; }

  std::int64_t left_out = 0;
  std::optional<std::int64_t> expected;
  std::optional<double> period_s;

 private:
  bool OpenStream(const std::string& name, Input input);
  void Describe();
  void Feed();
  void Account();

  // A network that says nothing for so long is down.
  static constexpr auto kPatience = std::chrono::seconds(30);
  static int GivesUp(void* decoder);
  Clock::time_point asked_ = Clock::now();

  Held<AVFormatContext> format_;
  Held<AVCodecContext> codec_;
  Held<AVFrame> frame_{av_frame_alloc()};
  Held<AVPacket> packet_{av_packet_alloc()};
  Held<SwsContext> scaler_;
  cv::Mat padded_;
  AVStream* stream_ = nullptr;
  bool ended_ = false;
  bool damaged_ = false;              // since the last picture that stands on its own
  std::multiset<std::int64_t> sent_;  // times of packets whose pictures have not come yet
};

int VideoReader::Decoder::GivesUp(void* decoder) {
  return Clock::now() - static_cast<Decoder*>(decoder)->asked_ > kPatience ? 1 : 0;
}

bool VideoReader::Decoder::OpenStream(const std::string& name, Input input) {
  AVFormatContext* format = avformat_alloc_context();
  AVDictionary* options = nullptr;
  if (input == Input::kStream) {
    format->interrupt_callback = {GivesUp, this};
    av_dict_set(&options, "rtsp_transport", "tcp", 0);  // UDP would lose packets
  }
  // A file's name is never taken for a protocol, whatever stands before a colon in it.
  const std::string address = input == Input::kStream ? name : "file:" + name;
  const int error = avformat_open_input(&format, address.c_str(), nullptr, &options);
  av_dict_free(&options);
  if (error < 0) return false;  // which has released `format`
  format_.reset(format);
  return avformat_find_stream_info(format, nullptr) >= 0;
}

bool VideoReader::Decoder::Open(const std::string& name, Input input) {
  if (!OpenStream(name, input)) return false;
  const AVCodec* decoder = nullptr;
  const int index = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (index < 0 || decoder == nullptr) return false;
  stream_ = format_->streams[index];
  codec_.reset(avcodec_alloc_context3(decoder));
  if (avcodec_parameters_to_context(codec_.get(), stream_->codecpar) < 0) return false;
  codec_->pkt_timebase = stream_->time_base;
  // Sizes can change within a stream: the decoder asks before it makes room for a picture.
  codec_->max_pixels = std::int64_t{kMaxPictureSidePx} * kMaxPictureSidePx;
  // Threads that work on several frames at once lose what is said about damage.
  codec_->thread_count = 0;
  codec_->thread_type = FF_THREAD_SLICE;
  // Where each picture has its own checksum or end, a damaged one is an error and none comes.
  if (StandsAlone(decoder->id)) codec_->err_recognition |= AV_EF_CRCCHECK | AV_EF_EXPLODE;
  if (avcodec_open2(codec_.get(), decoder, nullptr) < 0) return false;
  Describe();
  return true;
}

// Unknown counts and rates come as zero, negative or absurd numbers.
void VideoReader::Decoder::Describe() {
  constexpr double kMostFrames = 1e9;
  constexpr double kHighestRate = 10000;
  const double rate = av_q2d(av_guess_frame_rate(format_.get(), stream_, nullptr));
  if (rate > 0 && rate <= kHighestRate) period_s = 1 / rate;
  auto count = static_cast<double>(stream_->nb_frames);
  if (count <= 0 && period_s && format_->duration > 0) {
    count = std::round(static_cast<double>(format_->duration) / AV_TIME_BASE * rate);
  }
  if (count >= 1 && count < kMostFrames) expected = static_cast<std::int64_t>(count);
}

// Gives the decoder the next packet, or tells it that there are no more.
void VideoReader::Decoder::Feed() {
  asked_ = Clock::now();
  do {
    av_packet_unref(packet_.get());
    if (av_read_frame(format_.get(), packet_.get()) < 0) {
      ended_ = true;
      (void)avcodec_send_packet(codec_.get(), nullptr);
      return;
    }
  } while (packet_->stream_index != stream_->index);
  const bool wanted = (packet_->flags & AV_PKT_FLAG_DISCARD) == 0;
  if (wanted && packet_->pts != AV_NOPTS_VALUE) sent_.insert(packet_->pts);
  if ((packet_->flags & AV_PKT_FLAG_CORRUPT) != 0) damaged_ = true;
  if (avcodec_send_packet(codec_.get(), packet_.get()) >= 0) return;
  damaged_ = true;
  if (packet_->pts == AV_NOPTS_VALUE) ++left_out;
}

// Pictures come in the order of their times: an earlier one that has not come never will.
void VideoReader::Decoder::Account() {
  if (frame_->pts == AV_NOPTS_VALUE) return;
  const auto here = sent_.lower_bound(frame_->pts);
  left_out += std::distance(sent_.begin(), here);
  sent_.erase(sent_.begin(), sent_.upper_bound(frame_->pts));
}

bool VideoReader::Decoder::Decode() {
  for (;;) {
    const int error = avcodec_receive_frame(codec_.get(), frame_.get());
    if (error == AVERROR(EAGAIN)) {
      Feed();
    } else if (error == AVERROR_EOF || (error < 0 && ended_)) {
      left_out += static_cast<std::int64_t>(sent_.size());
      sent_.clear();
      return false;
    } else if (error < 0) {
      damaged_ = true;
    } else {
      Account();
      const bool alone = frame_->key_frame != 0 || StandsAlone(codec_->codec_id);
      if (alone) damaged_ = false;
      const bool corrupt = (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0;
      if (corrupt || frame_->decode_error_flags != 0) damaged_ = true;
      if (!damaged_) return true;
      ++left_out;
    }
  }
}

// To what OpenCV calls BGR. The rows are padded: the scaler may write beyond their ends.
void VideoReader::Decoder::Convert(cv::Mat& bgr) {
  constexpr int kPadding = 64;
  const int width = frame_->width;
  const int height = frame_->height;
  scaler_.reset(sws_getCachedContext(scaler_.release(),
                                     width,
                                     height,
                                     static_cast<AVPixelFormat>(frame_->format),
                                     width,
                                     height,
                                     AV_PIX_FMT_BGR24,
                                     SWS_BICUBIC,
                                     nullptr,
                                     nullptr,
                                     nullptr));
  if (!scaler_) throw calib::InputError("its pixels are of a kind that cannot be converted");
  padded_.create(height + 1, (width + kPadding) / kPadding * kPadding, CV_8UC3);
  uint8_t* const rows = padded_.data;
  const int step = static_cast<int>(padded_.step);
  sws_scale(scaler_.get(), frame_->data, frame_->linesize, 0, height, &rows, &step);
  bgr = padded_(cv::Rect(0, 0, width, height));
}

std::optional<double> VideoReader::Decoder::Time() const {
  if (frame_->best_effort_timestamp == AV_NOPTS_VALUE) return std::nullopt;
  const std::int64_t start = stream_->start_time == AV_NOPTS_VALUE ? 0 : stream_->start_time;
  const double time_s =
      static_cast<double>(frame_->best_effort_timestamp - start) * av_q2d(stream_->time_base);
  constexpr double kLatestSeconds = 1e10;
  if (!(time_s >= 0 && time_s < kLatestSeconds)) return std::nullopt;
  return time_s;
}

VideoReader::VideoReader(std::string name, Input input, Pixels pixels)
    : name_(std::move(name)),
      input_(input),
      pixels_(pixels),
      decoder_(std::make_unique<Decoder>()) {
  if (!decoder_->Open(name_, input_)) {
    throw calib::InputError(fmt::format("{}: {}", name_, WhyNotOpen(input_)));
  }
  CheckPictureSize(decoder_->Size(), name_);
}

VideoReader::~VideoReader() = default;

bool VideoReader::Next(cv::Mat& picture, std::optional<double>& time_s) {
  if (!decoder_->Decode()) return false;
  cv::Mat bgr;
  decoder_->Convert(bgr);
  ConvertTo(pixels_, bgr, picture, name_);
  time_s = decoder_->Time();
  return true;
}

bool VideoReader::Skip() {
  return decoder_->Decode();
}

FrameReader::Kind VideoReader::GetKind() const {
  const bool live = input_ == Input::kStream && !decoder_->expected;
  return live ? Kind::kLive : Kind::kVideo;
}
std::optional<std::int64_t> VideoReader::ExpectedFrames() const {
  return decoder_->expected;
}
std::optional<double> VideoReader::FramePeriod() const {
  return decoder_->period_s;
}
std::int64_t VideoReader::LeftOut() const {
  return decoder_->left_out;
}

}  // namespace ceilmap::app
