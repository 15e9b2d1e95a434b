#include "app/frame_reader.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <system_error>
#include <utility>

#include "app/pictures.hpp"
#include "calib/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

class PictureReader final : public FrameReader {
 public:
  PictureReader(std::vector<fs::path> files, Pixels pixels, std::vector<std::string> remarks = {})
      : files_(std::move(files)), pixels_(pixels), remarks_(std::move(remarks)) {}

  bool Next(cv::Mat& picture, std::optional<double>& time_s) override {
    if (next_ == files_.size()) return false;
    picture = ReadPicture(files_[next_++], pixels_);
    time_s.reset();
    return true;
  }
  [[nodiscard]] Kind GetKind() const override { return Kind::kPictures; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override {
    return static_cast<std::int64_t>(files_.size());
  }
  [[nodiscard]] std::vector<std::string> Remarks() const override { return remarks_; }

 private:
  std::vector<fs::path> files_;
  Pixels pixels_;
  std::vector<std::string> remarks_;
  std::size_t next_ = 0;
};

class VideoReader final : public FrameReader {
 public:
  enum class Input { kFile, kPipe, kCamera, kStream };

  VideoReader(std::string name, Input input, Pixels pixels)
      : name_(std::move(name)), input_(input), pixels_(pixels) {
    const int backend = input == Input::kCamera ? cv::CAP_V4L2 : cv::CAP_FFMPEG;
    bool open = false;
    try {
      open = capture_.open(name_, backend);
    } catch (const cv::Exception&) {
      open = false;
    }
    if (!open) throw calib::InputError(fmt::format("{}: {}", name_, WhyNotOpen(input)));
    // Before a frame is decoded: each would take that much memory.
    constexpr double kMaxSidePx = 16384;
    const double width_px = capture_.get(cv::CAP_PROP_FRAME_WIDTH);
    const double height_px = capture_.get(cv::CAP_PROP_FRAME_HEIGHT);
    if (width_px > kMaxSidePx || height_px > kMaxSidePx) {
      throw calib::InputError(
          fmt::format("{}: a video of {:.0f}x{:.0f} px, must have at most {:.0f} on a side",
                      name_,
                      width_px,
                      height_px,
                      kMaxSidePx));
    }
    // Unknown counts come as zero, negative or absurd numbers.
    constexpr double kMostFrames = 1e9;
    const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (count >= 1 && count < kMostFrames) expected_ = static_cast<std::int64_t>(count);
    constexpr double kHighestRate = 10000;  // FFmpeg answers with absurd ones where it knows none
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    if (rate > 0 && rate <= kHighestRate) period_s_ = 1 / rate;
  }

  bool Next(cv::Mat& picture, std::optional<double>& time_s) override {
    if (!capture_.read(picture_) || picture_.empty()) return false;
    ConvertTo(pixels_, picture_, picture, name_);
    // Frames without a time stamp come as zero (the last ones of a delayed decoder) or as absurd
    // numbers (raw streams).
    constexpr double kLatestSeconds = 1e10;
    const double position_s = capture_.get(cv::CAP_PROP_POS_MSEC) * 1e-3;
    const bool known = position_s < kLatestSeconds && (first_ ? position_s >= 0 : position_s > 0);
    time_s = known ? std::optional(position_s) : std::nullopt;
    first_ = false;
    return true;
  }
  [[nodiscard]] Kind GetKind() const override {
    // A stream with a known number of frames is a file on a server: it waits for its reader.
    const bool live = input_ == Input::kCamera || (input_ == Input::kStream && !expected_);
    return live ? Kind::kLive : Kind::kVideo;
  }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override { return expected_; }
  [[nodiscard]] std::optional<double> FramePeriod() const override { return period_s_; }
  [[nodiscard]] bool CanStall() const override { return input_ != Input::kFile; }

  bool Skip() { return capture_.grab(); }

 private:
  static const char* WhyNotOpen(Input input) {
    switch (input) {
      case Input::kCamera:
        return "the camera cannot be opened; is it connected, free, and readable for you?";
      case Input::kStream:
        return "the stream cannot be opened; check the address and the network";
      default:
        return "is not a video that can be decoded";
    }
  }

  std::string name_;
  Input input_;
  Pixels pixels_;
  cv::VideoCapture capture_;
  cv::Mat picture_;
  bool first_ = true;
  std::optional<std::int64_t> expected_;
  std::optional<double> period_s_;
};

VideoReader::Input InputKind(const std::string& source) {
  std::error_code ignored;
  if (source.starts_with("/dev/video")) return VideoReader::Input::kCamera;
  if (source.find("://") != std::string::npos) return VideoReader::Input::kStream;
  return fs::is_fifo(source, ignored) ? VideoReader::Input::kPipe : VideoReader::Input::kFile;
}

void CheckFile(const std::string& source) {
  std::error_code ignored;
  if (!fs::exists(source, ignored)) {
    throw calib::InputError(fmt::format("{}: no such file or folder", source));
  }
  if (access(source.c_str(), R_OK) != 0) {
    throw calib::InputError(fmt::format("{}: cannot be read; check its permissions", source));
  }
  if (fs::is_regular_file(source, ignored) && fs::file_size(source, ignored) == 0) {
    throw calib::InputError(fmt::format("{}: is empty", source));
  }
}

}  // namespace

std::unique_ptr<FrameReader> FrameReader::Open(const std::string& source, Pixels pixels) {
  using Input = VideoReader::Input;
  const Input input = InputKind(source);
  std::error_code ignored;
  if (input == Input::kStream) return std::make_unique<VideoReader>(source, input, pixels);
  if (!fs::exists(source, ignored) && IsPattern(source)) {
    PatternPictures pictures = ListPattern(source);
    std::vector<std::string> remarks;
    if (pictures.missing > 0) {
      remarks.push_back(fmt::format(
          "{}: {} numbers between the first and the last have no file", source, pictures.missing));
    }
    return std::make_unique<PictureReader>(std::move(pictures.files), pixels, std::move(remarks));
  }
  CheckFile(source);
  if (fs::is_directory(source, ignored)) {
    return std::make_unique<PictureReader>(ListFolder(source), pixels);
  }
  return std::make_unique<VideoReader>(source, input, pixels);
}

std::int64_t CountFrames(const std::string& source) {
  VideoReader reader(source, InputKind(source), Pixels::kGrey);
  std::int64_t count = 0;
  while (reader.Skip()) ++count;
  return count;
}

}  // namespace ceilmap::app
