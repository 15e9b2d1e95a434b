#include "app/recordings/board_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/recordings/frame_reader.hpp"
#include "app/recordings/images.hpp"
#include "app/recordings/ordered_work.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

using calibration::BoardView;

constexpr std::int64_t kMaxOfVideo = 300;

int ThreadCount() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

struct NamedImage {
  std::string name;
  cv::Mat image;
  std::optional<BoardView> view;
};

// Takes images in order.
class Collector {
 public:
  explicit Collector(std::string name) { found_.name = std::move(name); }

  void CheckSize(const std::string& name, cv::Size size) {
    if (found_.size.empty()) found_.size = size;
    if (size == found_.size) return;
    throw InputError(
        fmt::format("{}: is {}x{} px, those before it {}x{}; calibrate with images of one size",
                    name,
                    size.width,
                    size.height,
                    found_.size.width,
                    found_.size.height));
  }

  void Take(NamedImage image) {
    CheckSize(image.name, image.image.size());
    ++found_.images;
    if (!image.view) {
      constexpr std::size_t kMaxUnseen = 12;
      found_.without_board.push_back(std::move(image.name));
      if (found_.unseen.size() < kMaxUnseen) found_.unseen.push_back(image.image);
      return;
    }
    const std::vector<cv::Point2f> corners(image.view->corners_px.begin(),
                                           image.view->corners_px.end());
    const double area = cv::minAreaRect(corners).size.area();
    if (area > sample_area_) {
      sample_area_ = area;
      found_.sample = image.image;
    }
    image.view->name = std::move(image.name);
    found_.views.push_back(std::move(*image.view));
  }

  calibration::BoardImages Finish() { return std::move(found_); }

 private:
  calibration::BoardImages found_;
  double sample_area_ = 0;
};

std::vector<fs::path> ListImages(const std::vector<std::string>& sources) {
  std::vector<fs::path> files;
  for (const std::string& source : sources) {
    std::error_code ignored;
    if (fs::is_directory(source, ignored)) {
      for (fs::path& file : ListFolder(source)) files.push_back(std::move(file));
    } else if (!fs::exists(source, ignored) && IsPattern(source)) {
      for (fs::path& file : ListPattern(source).files) files.push_back(std::move(file));
    } else if (IsImageName(source) || sources.size() > 1) {
      files.emplace_back(source);
    }
  }
  return files;
}

void ObserveImages(const std::vector<fs::path>& files,
                   const calibration::Board& board,
                   Collector& collector) {
  const auto process = [&](std::int64_t index) {
    const fs::path& file = files[static_cast<std::size_t>(index)];
    NamedImage result{file.filename().string(), ReadGreyImage(file), {}};
    result.view = calibration::DetectBoard(result.image, board);
    return result;
  };
  const auto count = static_cast<std::int64_t>(files.size());
  OrderedWork<NamedImage> work(count, ThreadCount(), process);
  terminal::Progress progress("boards", "images", count);
  for (std::int64_t done = 1; !terminal::Interrupted(); ++done) {
    std::optional<NamedImage> image = work.Next();
    if (!image) return;
    collector.Take(std::move(*image));
    progress.Update(done);
  }
}

// The variance of second derivatives; comparable between neighbouring images of a video.
double Sharpness(const cv::Mat& grey) {
  cv::Mat curvature;
  cv::Laplacian(grey, curvature, CV_16S);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(curvature, mean, deviation);
  return deviation[0];
}

// The sharpest image of each interval of a video.
class Stretches {
 public:
  Stretches(FrameReader& reader, std::int64_t length) : reader_(reader), length_(length) {}

  bool Next(NamedImage& sharpest) {
    double best = -1;
    for (std::int64_t i = 0; i < length_ && !terminal::Interrupted(); ++i) {
      std::optional<double> time_s;
      if (!reader_.Next(frame_, time_s)) break;
      const double sharpness = Sharpness(frame_);
      if (sharpness > best) {
        best = sharpness;
        sharpest.name = fmt::format("frame {}", frame_number_);
        frame_.copyTo(sharpest.image);
      }
      ++frame_number_;
    }
    return best >= 0;
  }
  [[nodiscard]] std::int64_t Frames() const { return frame_number_; }

 private:
  FrameReader& reader_;
  std::int64_t length_;
  std::int64_t frame_number_ = 0;
  cv::Mat frame_;
};

void ObserveVideo(FrameReader& reader, const calibration::Board& board, Collector& collector) {
  constexpr std::int64_t kUnknownLength = 5 * kMaxOfVideo;
  const std::int64_t frames = reader.ExpectedFrames().value_or(kUnknownLength);
  Stretches stretches(reader, (frames + kMaxOfVideo - 1) / kMaxOfVideo);
  terminal::Progress progress("boards", "frames", reader.ExpectedFrames());
  const auto batch = 4 * static_cast<std::size_t>(ThreadCount());
  bool more = true;
  while (more) {
    std::vector<NamedImage> images;
    while (images.size() < batch && more) {
      NamedImage image;
      more = stretches.Next(image);
      if (more) images.push_back(std::move(image));
    }
    const auto process = [&](std::int64_t index) {
      NamedImage& image = images[static_cast<std::size_t>(index)];
      image.view = calibration::DetectBoard(image.image, board);
      return std::move(image);
    };
    OrderedWork<NamedImage> work(static_cast<std::int64_t>(images.size()), ThreadCount(), process);
    while (auto image = work.Next()) collector.Take(std::move(*image));
    progress.Update(stretches.Frames());
  }
}

}  // namespace

calibration::BoardImages FindBoards(const std::vector<std::string>& sources,
                                    const calibration::Board& board,
                                    const BagTopic& bag) {
  if (sources.empty()) {
    throw InputError(
        "calibrate camera: no images; give a folder of images, a video, or several images");
  }
  Collector collector(sources.size() == 1 ? sources.front()
                                          : fmt::format("{} and others", sources.front()));
  std::vector<fs::path> files;
  if (sources.size() > 1 || !IsBag(sources.front())) files = ListImages(sources);
  if (!files.empty()) {
    ObserveImages(files, board, collector);
    return collector.Finish();
  }
  const std::unique_ptr<FrameReader> reader =
      FrameReader::Open(sources.front(), Pixels::kGrey, bag);
  if (reader->GetKind() == FrameReader::Kind::kLive) {
    throw InputError(fmt::format("{}: is a live camera; record the board first, and give the video",
                                 sources.front()));
  }
  ObserveVideo(*reader, board, collector);
  return collector.Finish();
}

}  // namespace ceilmap::recordings
