#include "app/recordings/video_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <opencv2/core.hpp>
#include <set>
#include <string_view>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

#include "app/recordings/bitrate.hpp"
#include "app/recordings/video_geometry.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

using Clock = std::chrono::steady_clock;

// FFmpeg's objects are released through a pointer to their pointer.
struct Release {
  void operator()(AVFormatContext* x) const { avformat_close_input(&x); }
  void operator()(AVCodecContext* x) const { avcodec_free_context(&x); }
  void operator()(AVFrame* x) const { av_frame_free(&x); }
  void operator()(AVPacket* x) const { av_packet_free(&x); }
};
template <typename T>
using Held = std::unique_ptr<T, Release>;

const char* WhyNotOpen(VideoReader::Input input) {
  return input == VideoReader::Input::kStream
             ? "the stream cannot be opened; check the address and the network"
             : "is not a video that can be decoded; is it complete?";
}

bool StandsAlone(AVCodecID codec) {
  const AVCodecDescriptor* const descriptor = avcodec_descriptor_get(codec);
  return descriptor != nullptr && (descriptor->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
}

}  // namespace

struct VideoReader::Decoder {
  bool Open(const std::string& name, Input input);
  /// Decodes the next valid image into `frame`; false at the end.
  bool Decode();
  /// The image of the last Decode.
  [[nodiscard]] const AVFrame& Decoded() const { return *frame_; }
  [[nodiscard]] FrameGeometry Geometry(const std::string& name) const {
    return GeometryOf(*format_, *stream_, *frame_, name);
  }
  [[nodiscard]] std::optional<double> Time() const;
  [[nodiscard]] cv::Size Size() const { return {codec_->width, codec_->height}; }
  [[nodiscard]] AVCodecID Codec() const { return codec_->codec_id; }

  std::optional<PixelRate> pixel_rate;  // after Open
  std::int64_t left_out = 0;
  bool source_failed = false;  // it ended by an error
  std::optional<std::int64_t> expected;
  std::optional<double> period_s;

 private:
  bool OpenStream(const std::string& name, Input input);
  void Describe();
  [[nodiscard]] std::int64_t PresentedFrames() const;
  [[nodiscard]] double DurationS() const {
    return static_cast<double>(format_->duration) / AV_TIME_BASE;
  }
  void ReviseEstimate();
  void Feed();
  void Receive();
  void Take();
  void Account();
  bool Release();
  bool Trusted(std::int64_t order);

  // A network without data for this time is down.
  static constexpr auto kPatience = std::chrono::seconds(10);
  static int GivesUp(void* decoder);
  Clock::time_point asked_ = Clock::now();

  Held<AVFormatContext> format_;
  Held<AVCodecContext> codec_;
  Held<AVFrame> frame_{av_frame_alloc()};
  Held<AVPacket> packet_{av_packet_alloc()};
  AVStream* stream_ = nullptr;
  bool ended_ = false;                // no more packets
  bool drained_ = false;              // ... nor images
  bool estimated_ = false;            // `expected`
  std::int64_t presented_ = 0;        // images so far
  double last_s_ = 0;                 // time of the last one
  std::multiset<std::int64_t> sent_;  // times of packets whose images were not returned yet

  // The decoder returns images in display order, but they depend on images that were sent before
  // them, some of which are displayed later. So an image waits until all images that were sent
  // before it are decoded.
  struct Image {
    Held<AVFrame> frame;
    std::int64_t order = 0;  // position in the order of sending
    bool alone = false;
  };
  std::deque<Image> waiting_;
  std::multiset<std::int64_t> awaited_;  // orders of packets whose images were not returned yet
  std::set<std::int64_t> damaged_;       // orders, as long as they are relevant
  std::int64_t last_alone_ = 0;  // order of the last released image that depends on no other
  std::int64_t latest_ = 0;      // order of the last packet
};

int VideoReader::Decoder::GivesUp(void* decoder) {
  const bool late = Clock::now() - static_cast<Decoder*>(decoder)->asked_ > kPatience;
  return late || terminal::Interrupted() ? 1 : 0;
}

bool VideoReader::Decoder::OpenStream(const std::string& name, Input input) {
  AVFormatContext* format = avformat_alloc_context();
  AVDictionary* options = nullptr;
  if (input == Input::kStream) {
    format->interrupt_callback = {GivesUp, this};
    av_dict_set(&options, "rtsp_transport", "tcp", 0);  // UDP would lose packets
  }
  // A file name is never interpreted as a protocol, even if it contains a colon.
  const std::string address = input == Input::kStream ? name : "file:" + name;
  const int error = avformat_open_input(&format, address.c_str(), nullptr, &options);
  av_dict_free(&options);
  if (error < 0) return false;  // `format` was released by this call
  format_.reset(format);
  // Of a stream that cannot be rewound FFmpeg would first read 20 frames, to measure its rate.
  const bool rewinds = format->pb != nullptr && (format->pb->seekable & AVIO_SEEKABLE_NORMAL) != 0;
  if (input == Input::kStream && !rewinds) format->fps_probe_size = 0;
  return avformat_find_stream_info(format, nullptr) >= 0;
}

bool VideoReader::Decoder::Open(const std::string& name, Input input) {
  av_log_set_level(AV_LOG_FATAL);  // damage is counted and reported in one line
  if (!OpenStream(name, input)) return false;
  const AVCodec* decoder = nullptr;
  const int index = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (index < 0 || decoder == nullptr) return false;
  stream_ = format_->streams[index];
  codec_.reset(avcodec_alloc_context3(decoder));
  if (avcodec_parameters_to_context(codec_.get(), stream_->codecpar) < 0) return false;
  codec_->pkt_timebase = stream_->time_base;
  // Sizes can change within a stream: the decoder asks before it allocates an image.
  codec_->max_pixels = std::int64_t{kMaxImageSidePx} * kMaxImageSidePx;
  // Threads that decode several frames at once would lose the damage reports.
  codec_->thread_count = 0;
  codec_->thread_type = FF_THREAD_SLICE;
  // Where each image has its own checksum, a damaged image is an error and is not returned. Not for
  // cameras' JPEGs, in which the decoder reports many harmless errors; damage stays within one
  // image, and the remaining content is at its correct position.
  if (StandsAlone(decoder->id) && decoder->id != AV_CODEC_ID_MJPEG) {
    codec_->err_recognition |= AV_EF_CRCCHECK | AV_EF_EXPLODE;
  }
  if (avcodec_open2(codec_.get(), decoder, nullptr) < 0) return false;
  Describe();
  pixel_rate.emplace(period_s, Size());
  return true;
}

// Frames by the container, 0: unknown. Those that the edit list of an MP4 file cuts off are stored
// with it, and some of them are decoded, but they are not presented.
std::int64_t VideoReader::Decoder::PresentedFrames() const {
  const int stored = avformat_index_get_entries_count(stream_);
  const bool has_edits = std::string_view(format_->iformat->name).starts_with("mov");
  if (!has_edits || stored == 0 || stream_->nb_frames == 0) return stream_->nb_frames;
  std::int64_t presented = 0;
  for (int i = 0; i < stored; ++i) {
    const AVIndexEntry* const entry = avformat_index_get_entry(stream_, i);
    if ((entry->flags & AVINDEX_DISCARD_FRAME) == 0) ++presented;
  }
  return presented;
}

// Unknown counts and rates are zero, negative or invalid numbers.
void VideoReader::Decoder::Describe() {
  constexpr double kMaxFrames = 1e9;
  constexpr double kHighestRate = 10000;
  const double rate = av_q2d(av_guess_frame_rate(format_.get(), stream_, nullptr));
  if (rate > 0 && rate <= kHighestRate) period_s = 1 / rate;
  auto count = static_cast<double>(PresentedFrames());
  estimated_ = count <= 0;
  if (estimated_ && period_s && format_->duration > 0) count = std::round(DurationS() * rate);
  if (count >= 1 && count < kMaxFrames) expected = static_cast<std::int64_t>(count);
  estimated_ = estimated_ && expected;
}

// Sends the next packet to the decoder, or the end of the stream.
void VideoReader::Decoder::Feed() {
  asked_ = Clock::now();
  do {
    av_packet_unref(packet_.get());
    if (const int error = av_read_frame(format_.get(), packet_.get()); error < 0) {
      ended_ = true;
      // Some demuxers return other errors at the end.
      const AVIOContext* const io = format_->pb;
      const bool closed = io != nullptr && io->eof_reached != 0 && io->error == 0;
      source_failed = error != AVERROR_EOF && !closed;
      (void)avcodec_send_packet(codec_.get(), nullptr);
      return;
    }
  } while (packet_->stream_index != stream_->index);
  const bool wanted = (packet_->flags & AV_PKT_FLAG_DISCARD) == 0;
  if (wanted && packet_->pts != AV_NOPTS_VALUE) sent_.insert(packet_->pts);
  if (wanted) pixel_rate->Add(packet_->size);
  // Streams have no positions: their images count in display order.
  const bool in_file = packet_->pos >= 0;
  latest_ = in_file ? packet_->pos : latest_ + 1;
  if (wanted && in_file) awaited_.insert(latest_);
  if ((packet_->flags & AV_PKT_FLAG_CORRUPT) != 0) damaged_.insert(latest_);
  if (avcodec_send_packet(codec_.get(), packet_.get()) >= 0) return;
  damaged_.insert(latest_);
  if (const auto failed = awaited_.find(latest_); failed != awaited_.end()) awaited_.erase(failed);
  if (packet_->pts == AV_NOPTS_VALUE) ++left_out;
}

// Images are returned in the order of their times: an earlier one will not come any more.
void VideoReader::Decoder::Account() {
  if (frame_->pts == AV_NOPTS_VALUE) return;
  const auto here = sent_.lower_bound(frame_->pts);
  left_out += std::distance(sent_.begin(), here);
  sent_.erase(sent_.begin(), sent_.upper_bound(frame_->pts));
}

// Adds the image in `frame_` to the waiting ones.
void VideoReader::Decoder::Take() {
  Account();
  // H.264 delays a limited number of images; an older packet has no image.
  constexpr std::size_t kMaxReordered = 16;
  Image image{Held<AVFrame>(av_frame_clone(frame_.get())), latest_};
  if (frame_->pkt_pos >= 0) image.order = frame_->pkt_pos;
  const auto sent = awaited_.find(image.order);
  if (sent != awaited_.end()) awaited_.erase(sent);
  if (waiting_.size() >= kMaxReordered && !awaited_.empty()) awaited_.erase(awaited_.begin());
  image.alone = frame_->key_frame != 0 || StandsAlone(codec_->codec_id);
  const bool corrupt = (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0;
  if (corrupt || frame_->decode_error_flags != 0) damaged_.insert(image.order);
  waiting_.push_back(std::move(image));
}

void VideoReader::Decoder::Receive() {
  const int error = avcodec_receive_frame(codec_.get(), frame_.get());
  if (error == AVERROR(EAGAIN)) {
    Feed();
  } else if (error == AVERROR_EOF || (error < 0 && ended_)) {
    left_out += static_cast<std::int64_t>(sent_.size());
    sent_.clear();
    drained_ = true;
  } else if (error < 0) {
    damaged_.insert(latest_);
  } else {
    Take();
  }
}

// True when no image that it may depend on is damaged.
bool VideoReader::Decoder::Trusted(std::int64_t order) {
  damaged_.erase(damaged_.begin(), damaged_.lower_bound(last_alone_));
  return damaged_.empty() || *damaged_.begin() > order;
}

// Moves the next valid image to `frame_`; false when it must wait.
bool VideoReader::Decoder::Release() {
  while (!waiting_.empty()) {
    Image& next = waiting_.front();
    if (!drained_ && !awaited_.empty() && *awaited_.begin() < next.order) return false;
    if (next.alone) last_alone_ = next.order;
    const bool trusted = Trusted(next.order);
    av_frame_unref(frame_.get());
    av_frame_move_ref(frame_.get(), next.frame.get());
    waiting_.pop_front();
    if (trusted) return true;
    ++left_out;
  }
  return false;
}

bool VideoReader::Decoder::Decode() {
  while (!Release()) {
    if (drained_) {
      ReviseEstimate();
      return false;
    }
    Receive();
  }
  ++presented_;
  last_s_ = Time().value_or(last_s_);
  return true;
}

// A video whose rate varies has fewer frames than its duration and rate give.
void VideoReader::Decoder::ReviseEstimate() {
  constexpr double kMaxMissingS = 0.5;
  if (!estimated_ || last_s_ + kMaxMissingS < DurationS()) return;
  expected = std::min(*expected, presented_ + left_out);
}

std::optional<double> VideoReader::Decoder::Time() const {
  // Of containers without time stamps, FFmpeg counts the frames at a rate that it assumes.
  const bool counted = (format_->iformat->flags & AVFMT_NOTIMESTAMPS) != 0;
  if (counted || frame_->best_effort_timestamp == AV_NOPTS_VALUE) return std::nullopt;
  const std::int64_t start = stream_->start_time == AV_NOPTS_VALUE ? 0 : stream_->start_time;
  const double time_s =
      static_cast<double>(frame_->best_effort_timestamp - start) * av_q2d(stream_->time_base);
  constexpr double kLatestSeconds = 1e10;
  // A stream may begin anew with earlier times.
  const bool early = time_s < 0 && format_->interrupt_callback.callback == nullptr;
  if (early || !(std::abs(time_s) < kLatestSeconds)) return std::nullopt;
  return time_s;
}

VideoReader::VideoReader(std::string name, Input input, Pixels pixels)
    : name_(std::move(name)),
      input_(input),
      pixels_(name_, pixels),
      decoder_(std::make_unique<Decoder>()) {
  if (!decoder_->Open(name_, input_)) {
    throw InputError(fmt::format("{}: {}", name_, WhyNotOpen(input_)));
  }
  CheckImageSize(decoder_->Size(), name_);
}

VideoReader::~VideoReader() = default;

bool VideoReader::Next(cv::Mat& image, std::optional<double>& time_s) {
  constexpr int kCheckedFrames = 25;  // the first ones of a mixed video can be progressive
  if (!decoder_->Decode()) return false;
  const AVFrame& frame = decoder_->Decoded();
  if (checked_frames_ < kCheckedFrames) {
    ++checked_frames_;
    CheckProgressive(frame, name_);
  }
  pixels_.Convert(frame, decoder_->Geometry(name_), image);
  CheckImageSize(image.size(), name_);
  time_s = decoder_->Time();
  return true;
}

bool VideoReader::Skip() {
  return decoder_->Decode();
}

registration::Encoding VideoReader::GetEncoding() const {
  // HEVC predicts too, but its images keep noise where they are coarse: it does not tell how
  // coarse.
  constexpr AVCodecID kCodecs[] = {
      AV_CODEC_ID_H264, AV_CODEC_ID_VP8, AV_CODEC_ID_VP9, AV_CODEC_ID_AV1};
  const bool predicted = std::ranges::find(kCodecs, decoder_->Codec()) != std::end(kCodecs);
  return {.predicted = predicted, .pixel_rate_bit_s = decoder_->pixel_rate->BitsPerSecond()};
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
bool VideoReader::Failed() const {
  return decoder_->source_failed;
}
std::int64_t VideoReader::LeftOut() const {
  return decoder_->left_out;
}

}  // namespace ceilmap::recordings
