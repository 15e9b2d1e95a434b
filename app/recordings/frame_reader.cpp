#include "app/recordings/frame_reader.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <system_error>
#include <utility>

#include "app/recordings/bag_frames.hpp"
#include "app/recordings/images.hpp"
#include "app/recordings/stream_reader.hpp"
#include "app/recordings/video_reader.hpp"
#include "app/terminal/clock.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

class ImageReader final : public FrameReader {
 public:
  ImageReader(std::vector<fs::path> files, Pixels pixels, std::vector<std::string> remarks = {})
      : files_(std::move(files)), pixels_(pixels), remarks_(std::move(remarks)) {}

  bool Next(cv::Mat& image, std::optional<double>& time_s) override {
    if (next_ == files_.size()) return false;
    image = ReadImage(files_[next_++], pixels_);
    time_s.reset();
    return true;
  }
  [[nodiscard]] Kind GetKind() const override { return Kind::kImages; }
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

/// A camera of this machine.
class CameraReader final : public FrameReader {
 public:
  CameraReader(std::string name, Pixels pixels) : name_(std::move(name)), pixels_(pixels) {
    bool open = false;
    try {
      open = capture_.open(name_, cv::CAP_V4L2);
    } catch (const cv::Exception&) {
      open = false;
    }
    if (!open) {
      throw InputError(fmt::format(
          "{}: the camera cannot be opened; is it connected, free, and readable for this user?",
          name_));
    }
    constexpr double kHighestRate = 10000;
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    if (rate > 0 && rate <= kHighestRate) period_s_ = 1 / rate;
  }

  bool Next(cv::Mat& image, std::optional<double>& time_s) override {
    failed_ = true;
    if (!capture_.read(image_) || image_.empty()) return false;
    ConvertTo(pixels_, image_, image, name_);
    time_s = BufferTime();
    failed_ = false;
    return true;
  }
  [[nodiscard]] Kind GetKind() const override { return Kind::kLive; }
  [[nodiscard]] std::optional<std::int64_t> ExpectedFrames() const override { return {}; }
  [[nodiscard]] std::optional<double> FramePeriod() const override { return period_s_; }
  [[nodiscard]] bool CanStall() const override { return true; }
  [[nodiscard]] bool Failed() const override { return failed_; }
  [[nodiscard]] bool OnSteadyClock() const override { return true; }

 private:
  // The driver's time of the image, by most drivers on the steady clock; others are not used.
  [[nodiscard]] std::optional<double> BufferTime() const {
    constexpr double kOldestS = 1;
    const double time_s = 1e-3 * capture_.get(cv::CAP_PROP_POS_MSEC);
    const double age_s = terminal::SteadySeconds() - time_s;
    return age_s >= 0 && age_s < kOldestS ? std::optional(time_s) : std::nullopt;
  }

  std::string name_;
  Pixels pixels_;
  bool failed_ = false;
  cv::VideoCapture capture_;
  cv::Mat image_;
  std::optional<double> period_s_;
};

// The kind of a stream is known when it is open: a file on a server has an end.
std::unique_ptr<FrameReader> OpenStream(const std::string& url, Pixels pixels) {
  const auto open = [url, pixels] {
    return std::make_unique<VideoReader>(url, VideoReader::Input::kStream, pixels);
  };
  std::unique_ptr<FrameReader> first = open();
  if (first->GetKind() != FrameReader::Kind::kLive) return first;
  return std::make_unique<StreamReader>(url, std::move(first), open);
}

std::unique_ptr<FrameReader> OpenCamera(const std::string& name, Pixels pixels) {
  const auto open = [name, pixels] { return std::make_unique<CameraReader>(name, pixels); };
  return std::make_unique<StreamReader>(name, open(), open);
}

VideoReader::Input InputKind(const std::string& source) {
  std::error_code ignored;
  if (source.find("://") != std::string::npos) return VideoReader::Input::kStream;
  return fs::is_fifo(source, ignored) ? VideoReader::Input::kPipe : VideoReader::Input::kFile;
}

void CheckFile(const std::string& source) {
  std::error_code ignored;
  if (!fs::exists(source, ignored)) {
    throw InputError(fmt::format("{}: no such file or folder", source));
  }
  if (access(source.c_str(), R_OK) != 0) {
    throw InputError(fmt::format("{}: cannot be read; check its permissions", source));
  }
  if (fs::is_regular_file(source, ignored) && fs::file_size(source, ignored) == 0) {
    throw InputError(fmt::format("{}: is empty", source));
  }
}

}  // namespace

std::unique_ptr<FrameReader> FrameReader::Open(const std::string& source,
                                               Pixels pixels,
                                               const BagTopic& bag) {
  using Input = VideoReader::Input;
  if (IsBag(source)) return OpenBagFrames(source, bag, pixels);
  if (source.starts_with("/dev/video")) return OpenCamera(source, pixels);
  const Input input = InputKind(source);
  std::error_code ignored;
  if (input == Input::kStream) return OpenStream(source, pixels);
  if (!fs::exists(source, ignored) && IsPattern(source)) {
    PatternImages images = ListPattern(source);
    std::vector<std::string> remarks;
    if (images.missing > 0) {
      remarks.push_back(fmt::format(
          "{}: {} numbers between the first and the last have no file", source, images.missing));
    }
    return std::make_unique<ImageReader>(std::move(images.files), pixels, std::move(remarks));
  }
  CheckFile(source);
  if (fs::is_directory(source, ignored)) {
    return std::make_unique<ImageReader>(ListFolder(source), pixels);
  }
  return std::make_unique<VideoReader>(source, input, pixels);
}

std::int64_t CountFrames(const std::string& source) {
  VideoReader reader(source, InputKind(source), Pixels::kGrey);
  std::int64_t count = 0;
  while (reader.Skip()) ++count;
  return count + reader.LeftOut();
}

}  // namespace ceilmap::recordings
