#include "app/recordings/recording_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "app/recordings/mp4_rate.hpp"
#include "calib/base/atomic_file.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

[[noreturn]] void FailToWrite(const fs::path& target) {
  throw RunError(fmt::format("{}: cannot be written; is the disk full?", target.string()));
}

class VideoRecording final : public RecordingWriter {
 public:
  // OpenCV fixes the quality of H.264 (x264's crf 23) at a visual quality that removes the fine
  // texture of a ceiling. But x264 spends more bits on an image that is shown longer, up to a
  // second. So H.264 is encoded with one image a second, and the file gets its true rate at the
  // end.
  VideoRecording(
      const fs::path& target, bool lossless, cv::Size size, double rate_hz, bool is_colour)
      : file_(target, {target.extension().string()}),
        video_(file_.PartialPath()),
        encoded_hz_(lossless ? rate_hz : std::min(rate_hz, 1.0)),
        rate_hz_(rate_hz) {
    // OpenCV would cut off the last row or column without a message.
    if (size.width % 2 != 0 || size.height % 2 != 0) {
      throw InputError(
          fmt::format("{}: a video's width and height must be even, not {} x {} px; change the "
                      "camera, or write --pictures",
                      target.string(),
                      size.width,
                      size.height));
    }
    video_ += target.extension();  // determines OpenCV's container
    const int codec = lossless ? cv::VideoWriter::fourcc('F', 'F', 'V', '1')
                               : cv::VideoWriter::fourcc('a', 'v', 'c', '1');
    // Grey images are encoded as grey: with a conversion to colour H.264 loses 3 dB more.
    if (!writer_.open(video_.string(), cv::CAP_FFMPEG, codec, encoded_hz_, size, is_colour)) {
      throw RunError(
          fmt::format("{}: OpenCV has no encoder for it here; write --lossless or --pictures",
                      target.string()));
    }
  }

  void Write(const Prepared& image) override {
    writer_.write(image.pixels);
    ++frames_;
  }

  void Commit() override {
    writer_.release();
    CheckVideo();
    if (encoded_hz_ != rate_hz_) SpeedUpMp4(video_, rate_hz_ / encoded_hz_);
    std::error_code error;
    fs::rename(video_, file_.PartialPath(), error);
    if (error) FailToWrite(file_.Target());
    file_.Commit();
  }

 private:
  // OpenCV does not report a full disk; the file size shows it.
  void CheckVideo() const {
    const cv::VideoCapture video(video_.string(), cv::CAP_FFMPEG);
    const bool whole =
        video.isOpened() && std::llround(video.get(cv::CAP_PROP_FRAME_COUNT)) == frames_;
    if (!whole) FailToWrite(file_.Target());
  }

  AtomicFile file_;
  fs::path video_;
  double encoded_hz_;
  double rate_hz_;
  cv::VideoWriter writer_;
  std::int64_t frames_ = 0;
};

class ImageRecording final : public RecordingWriter {
 public:
  explicit ImageRecording(const fs::path& target)
      : target_(target),
        partial_(target.parent_path() / fmt::format(".{}.partial", target.filename().string())) {
    std::error_code error;
    fs::remove_all(partial_, error);  // of an aborted run
    if (!fs::create_directory(partial_, error)) {
      throw InputError(fmt::format(
          "{}: cannot be created ({}); give another name", target_.string(), error.message()));
    }
  }
  ~ImageRecording() override {
    std::error_code ignored;
    fs::remove_all(partial_, ignored);
  }

  [[nodiscard]] Prepared Prepare(cv::Mat pixels) const override {
    Prepared prepared{std::move(pixels), {}};
    cv::imencode(".png", prepared.pixels, prepared.code);
    return prepared;
  }

  void Write(const Prepared& image) override {
    std::ofstream stream(partial_ / fmt::format("{:06}.png", next_++), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(image.code.data()),
                 static_cast<std::streamsize>(image.code.size()));
    stream.close();
    if (!stream) FailToWrite(target_);
  }

  void Commit() override {
    std::error_code error;
    fs::remove_all(target_, error);
    if (!error) fs::rename(partial_, target_, error);
    if (error) FailToWrite(target_);
  }

 private:
  fs::path target_;
  fs::path partial_;
  std::int64_t next_ = 0;
};

}  // namespace

fs::path RecordingName(std::string_view camera, RecordingFormat format) {
  fs::path name(camera);
  if (format == RecordingFormat::kVideo) name += ".mp4";
  if (format == RecordingFormat::kLosslessVideo) name += ".mkv";
  return name;
}

RecordingWriter::Prepared RecordingWriter::Prepare(cv::Mat pixels) const {
  return {std::move(pixels), {}};
}

std::unique_ptr<RecordingWriter> RecordingWriter::Create(
    RecordingFormat format, const fs::path& target, cv::Size size, double rate_hz, bool is_colour) {
  switch (format) {
    case RecordingFormat::kVideo:
      return std::make_unique<VideoRecording>(target, false, size, rate_hz, is_colour);
    case RecordingFormat::kLosslessVideo:
      return std::make_unique<VideoRecording>(target, true, size, rate_hz, is_colour);
    case RecordingFormat::kImages:
      break;
  }
  return std::make_unique<ImageRecording>(target);
}

}  // namespace ceilmap::recordings
