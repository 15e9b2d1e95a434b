#include "tests/support/encoded_video.hpp"

#include <cstring>
#include <memory>
#include <stdexcept>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

namespace ceilmap::support {
namespace {

constexpr AVRational kTenths = {1, 10};

void Check(int result, const std::string& what) {
  if (result < 0) throw std::runtime_error("FFmpeg: " + what);
}

class Writer {
 public:
  Writer(const std::filesystem::path& file, const Encoding& encoding, cv::Size size);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void Write(const cv::Mat& image, std::int64_t time);
  void Finish();

 private:
  void OpenEncoder(const Encoding& encoding, cv::Size size);
  void Drain();

  bool interlaced_;
  AVFormatContext* format_ = nullptr;
  AVCodecContext* codec_ = nullptr;
  AVStream* stream_ = nullptr;
  AVFrame* frame_ = av_frame_alloc();
  AVPacket* packet_ = av_packet_alloc();
};

Writer::Writer(const std::filesystem::path& file, const Encoding& encoding, cv::Size size)
    : interlaced_(encoding.interlaced) {
  av_log_set_level(AV_LOG_ERROR);
  Check(avformat_alloc_output_context2(&format_, nullptr, nullptr, file.c_str()), "container");
  OpenEncoder(encoding, size);
  stream_ = avformat_new_stream(format_, nullptr);
  stream_->time_base = kTenths;
  stream_->sample_aspect_ratio = encoding.sample_aspect;
  Check(avcodec_parameters_from_context(stream_->codecpar, codec_), "parameters");
  if (encoding.wrong_field_order) stream_->codecpar->field_order = AV_FIELD_TT;
  if (encoding.display_matrix) {
    constexpr std::size_t kBytes = 9 * sizeof(std::int32_t);
    std::uint8_t* const data = av_stream_new_side_data(stream_, AV_PKT_DATA_DISPLAYMATRIX, kBytes);
    std::memcpy(data, encoding.display_matrix->data(), kBytes);
  }
  Check(avio_open(&format_->pb, file.c_str(), AVIO_FLAG_WRITE), "file");
  Check(avformat_write_header(format_, nullptr), "header");
}

void Writer::OpenEncoder(const Encoding& encoding, cv::Size size) {
  const AVCodec* const encoder = avcodec_find_encoder_by_name(encoding.codec.c_str());
  if (encoder == nullptr) throw std::runtime_error("FFmpeg: no encoder " + encoding.codec);
  codec_ = avcodec_alloc_context3(encoder);
  codec_->width = size.width;
  codec_->height = size.height;
  codec_->pix_fmt = encoding.format;
  codec_->time_base = kTenths;
  codec_->sample_aspect_ratio = encoding.sample_aspect;
  codec_->thread_count = 1;
  if (encoding.interlaced)
    codec_->flags |= AV_CODEC_FLAG_INTERLACED_DCT | AV_CODEC_FLAG_INTERLACED_ME;
  if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
    codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  }
  AVDictionary* options = nullptr;
  for (const auto& [name, value] : encoding.options) {
    av_dict_set(&options, name.c_str(), value.c_str(), 0);
  }
  const int opened = avcodec_open2(codec_, encoder, &options);
  av_dict_free(&options);
  Check(opened, "encoder");
}

Writer::~Writer() {
  av_packet_free(&packet_);
  av_frame_free(&frame_);
  avcodec_free_context(&codec_);
  if (format_ != nullptr) avio_closep(&format_->pb);
  avformat_free_context(format_);
}

void Writer::Write(const cv::Mat& image, std::int64_t time) {
  constexpr int kNeutral = 128;
  frame_->format = codec_->pix_fmt;
  frame_->width = codec_->width;
  frame_->height = codec_->height;
  Check(av_frame_get_buffer(frame_, 0), "memory");
  for (const AVBufferRef* const buffer : frame_->buf) {
    if (buffer != nullptr) std::memset(buffer->data, kNeutral, buffer->size);
  }
  for (int v = 0; v < image.rows; ++v) {
    std::memcpy(frame_->data[0] + v * frame_->linesize[0], image.ptr(v), image.cols);
  }
  frame_->pts = time;
  frame_->interlaced_frame = interlaced_ ? 1 : 0;
  frame_->top_field_first = interlaced_ ? 1 : 0;
  Check(avcodec_send_frame(codec_, frame_), "image");
  av_frame_unref(frame_);
  Drain();
}

void Writer::Drain() {
  while (avcodec_receive_packet(codec_, packet_) >= 0) {
    if (packet_->duration == 0) packet_->duration = 1;
    av_packet_rescale_ts(packet_, codec_->time_base, stream_->time_base);
    packet_->stream_index = stream_->index;
    Check(av_interleaved_write_frame(format_, packet_), "packet");
  }
}

void Writer::Finish() {
  Check(avcodec_send_frame(codec_, nullptr), "end");
  Drain();
  Check(av_write_trailer(format_), "trailer");
}

}  // namespace

void WriteEncoded(const std::filesystem::path& file,
                  const Encoding& encoding,
                  const std::vector<cv::Mat>& images) {
  Writer writer(file, encoding, images.front().size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto index = static_cast<std::int64_t>(i);
    writer.Write(images[i], encoding.times.empty() ? index : encoding.times[i]);
  }
  writer.Finish();
}

}  // namespace ceilmap::support
