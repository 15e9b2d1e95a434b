#include "app/recordings/board_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/recordings/frame_reader.hpp"
#include "app/recordings/ordered_work.hpp"
#include "app/recordings/pictures.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

using calibration::BoardView;

constexpr std::int64_t kMostOfVideo = 300;

int ThreadCount() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

struct NamedPicture {
  std::string name;
  cv::Mat picture;
  std::optional<BoardView> view;
};

// Takes pictures in their order.
class Collector {
 public:
  explicit Collector(std::string name) { found_.name = std::move(name); }

  void CheckSize(const std::string& name, cv::Size size) {
    if (found_.size.empty()) found_.size = size;
    if (size == found_.size) return;
    throw InputError(
        fmt::format("{}: is {}x{} px, those before it {}x{}; calibrate with pictures of one size",
                    name,
                    size.width,
                    size.height,
                    found_.size.width,
                    found_.size.height));
  }

  void Take(NamedPicture picture) {
    CheckSize(picture.name, picture.picture.size());
    ++found_.pictures;
    if (!picture.view) {
      constexpr std::size_t kMostUnseen = 12;
      found_.without_board.push_back(std::move(picture.name));
      if (found_.unseen.size() < kMostUnseen) found_.unseen.push_back(picture.picture);
      return;
    }
    const std::vector<cv::Point2f> corners(picture.view->corners_px.begin(),
                                           picture.view->corners_px.end());
    const double area = cv::minAreaRect(corners).size.area();
    if (area > sample_area_) {
      sample_area_ = area;
      found_.sample = picture.picture;
    }
    picture.view->name = std::move(picture.name);
    found_.views.push_back(std::move(*picture.view));
  }

  BoardPictures Finish() {
    found_.interrupted = terminal::Interrupted();
    return std::move(found_);
  }

 private:
  BoardPictures found_;
  double sample_area_ = 0;
};

std::vector<fs::path> ListPictures(const std::vector<std::string>& sources) {
  std::vector<fs::path> files;
  for (const std::string& source : sources) {
    std::error_code ignored;
    if (fs::is_directory(source, ignored)) {
      for (fs::path& file : ListFolder(source)) files.push_back(std::move(file));
    } else if (!fs::exists(source, ignored) && IsPattern(source)) {
      for (fs::path& file : ListPattern(source).files) files.push_back(std::move(file));
    } else if (IsPictureName(source) || sources.size() > 1) {
      files.emplace_back(source);
    }
  }
  return files;
}

void LookAtPictures(const std::vector<fs::path>& files,
                    const calibration::Board& board,
                    Collector& collector) {
  const auto look = [&](std::int64_t index) {
    const fs::path& file = files[static_cast<std::size_t>(index)];
    NamedPicture result{file.filename().string(), ReadGreyPicture(file), {}};
    result.view = calibration::DetectBoard(result.picture, board);
    return result;
  };
  const auto count = static_cast<std::int64_t>(files.size());
  OrderedWork<NamedPicture> work(count, ThreadCount(), look);
  terminal::Progress progress("boards", "pictures", count);
  for (std::int64_t done = 1; !terminal::Interrupted(); ++done) {
    std::optional<NamedPicture> picture = work.Next();
    if (!picture) return;
    collector.Take(std::move(*picture));
    progress.Update(done);
  }
}

// The variance of second derivatives: comparable between neighbours in a video.
double Sharpness(const cv::Mat& grey) {
  cv::Mat curvature;
  cv::Laplacian(grey, curvature, CV_16S);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(curvature, mean, deviation);
  return deviation[0];
}

// The sharpest picture of each stretch of a video.
class Stretches {
 public:
  Stretches(FrameReader& reader, std::int64_t length) : reader_(reader), length_(length) {}

  bool Next(NamedPicture& sharpest) {
    double best = -1;
    for (std::int64_t i = 0; i < length_ && !terminal::Interrupted(); ++i) {
      std::optional<double> time_s;
      if (!reader_.Next(frame_, time_s)) break;
      const double sharpness = Sharpness(frame_);
      if (sharpness > best) {
        best = sharpness;
        sharpest.name = fmt::format("frame {}", frame_number_);
        frame_.copyTo(sharpest.picture);
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

void LookAtVideo(FrameReader& reader, const calibration::Board& board, Collector& collector) {
  constexpr std::int64_t kUnknownLength = 5 * kMostOfVideo;
  const std::int64_t frames = reader.ExpectedFrames().value_or(kUnknownLength);
  Stretches stretches(reader, (frames + kMostOfVideo - 1) / kMostOfVideo);
  terminal::Progress progress("boards", "frames", reader.ExpectedFrames());
  const auto batch = 4 * static_cast<std::size_t>(ThreadCount());
  bool more = true;
  while (more) {
    std::vector<NamedPicture> pictures;
    while (pictures.size() < batch && more) {
      NamedPicture picture;
      more = stretches.Next(picture);
      if (more) pictures.push_back(std::move(picture));
    }
    const auto look = [&](std::int64_t index) {
      NamedPicture& picture = pictures[static_cast<std::size_t>(index)];
      picture.view = calibration::DetectBoard(picture.picture, board);
      return std::move(picture);
    };
    OrderedWork<NamedPicture> work(static_cast<std::int64_t>(pictures.size()), ThreadCount(), look);
    while (auto picture = work.Next()) collector.Take(std::move(*picture));
    progress.Update(stretches.Frames());
  }
}

}  // namespace

BoardPictures FindBoards(const std::vector<std::string>& sources, const calibration::Board& board) {
  if (sources.empty()) {
    throw InputError(
        "calibrate camera: no pictures; give a folder of pictures, a video, or several pictures");
  }
  Collector collector(sources.size() == 1 ? sources.front()
                                          : fmt::format("{} and others", sources.front()));
  const std::vector<fs::path> files = ListPictures(sources);
  if (!files.empty()) {
    LookAtPictures(files, board, collector);
    return collector.Finish();
  }
  const std::unique_ptr<FrameReader> reader = FrameReader::Open(sources.front());
  if (reader->GetKind() == FrameReader::Kind::kLive) {
    throw InputError(fmt::format("{}: is a live camera; record the board first, and give the video",
                                 sources.front()));
  }
  LookAtVideo(*reader, board, collector);
  return collector.Finish();
}

}  // namespace ceilmap::recordings
