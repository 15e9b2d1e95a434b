#include "app/live/live_page.hpp"

#include <fmt/format.h>

#include <thread>
#include <utility>

#include "app/page/mosaic_picture.hpp"
#include "app/page/page.hpp"
#include "app/reports/page_parts.hpp"
#include "app/terminal/clock.hpp"

namespace ceilmap::live {
namespace {

using std::chrono::steady_clock;

constexpr const char* kJson = "application/json";

}  // namespace

LivePage::LivePage(const Options& params,
                   page::PageData start,
                   std::string run,
                   std::vector<std::array<double, 2>> footprint)
    : params_(params),
      run_(std::move(run)),
      footprint_(std::move(footprint)),
      data_(std::move(start)),
      start_(steady_clock::now()) {
  Put({std::exchange(data_.picture, {}), {}, 0});
  const std::string html = page::WriteServedPage(data_.title, "document.json");
  server_ = std::make_unique<PageServer>(
      params.address,
      std::map<std::string, PageServer::Handler>{
          {"/",
           [html](const std::string&) {
             return ServedContent{"text/html; charset=utf-8", html};
           }},
          {"/document.json", [this](const std::string& query) { return Document(query); }},
          {"/picture", [this](const std::string&) { return Picture(); }}});
}

LivePage::~LivePage() = default;

void LivePage::Add(const graph::FramePose& frame, std::int64_t expected) {
  const std::lock_guard lock(mutex_);
  expected_ = expected;
  ++revision_;
  if (done_++ % every_ != 0) return;
  frames_.push_back(frame);
  if (frames_.size() < params_.max_frames) return;
  for (std::size_t i = 0; 2 * i < frames_.size(); ++i) frames_[i] = frames_[2 * i];
  frames_.resize((frames_.size() + 1) / 2);
  every_ *= 2;
}

void LivePage::Add(const page::PageKeyframe& keyframe) {
  const std::lock_guard lock(mutex_);
  data_.keyframes.push_back(keyframe);
  ++revision_;
}

void LivePage::SetMosaic(mosaic::Mosaic mosaic) {
  const store::MosaicGrid& grid = mosaic.grid;
  Under under;
  under.picture.min_x = grid.min_x;
  under.picture.max_y = grid.max_y;
  under.picture.max_x = grid.min_x + grid.resolution * grid.width_px;
  under.picture.min_y = grid.max_y - grid.resolution * grid.height_px;
  under.mosaic = std::move(mosaic);
  Put(std::move(under));
}

void LivePage::Put(Under under) {
  const std::lock_guard lock(mutex_);
  under.revision = ++revision_;
  under_ = std::make_shared<const Under>(std::move(under));
}

ServedContent LivePage::Document(const std::string& query) {
  page::PageData data;
  page::RunState state;
  std::vector<graph::FramePose> frames;
  std::string picture_url;
  {
    const std::lock_guard lock(mutex_);
    asked_ = steady_clock::now();
    sent_revision_ = revision_;
    const double seconds = terminal::SecondsSince(start_);
    state = {revision_,
             running_,
             seconds > 0 ? static_cast<double>(done_) / seconds : 0,
             done_,
             expected_};
    if (query == fmt::format("revision={}", revision_)) {
      return {kJson, page::WriteUnchanged(state)};
    }
    data = data_;
    if (running_) {  // they are large and do not change; the last page has them
      data.heights = {};
      data.plan = {};
    }
    frames = frames_;
    const page::PagePicture& picture = under_->picture;
    if (running_) {
      // The document contains the extent of the picture, but not its pixels.
      data.picture.min_x = picture.min_x;
      data.picture.min_y = picture.min_y;
      data.picture.max_x = picture.max_x;
      data.picture.max_y = picture.max_y;
      if (picture.max_x > picture.min_x) picture_url = fmt::format("picture?{}", under_->revision);
    } else {
      // The last document also contains the pixels, because the server ends after it.
      data.picture = picture;
    }
  }
  if (!frames.empty()) {
    data.paths.push_back(reports::ToPagePath(run_, frames));
    data.paths.back().footprint = footprint_;
    data.charts = reports::ChartsOfRun(run_, frames, data.unit);
  }
  return {kJson, page::WriteDocument(data, state, picture_url)};
}

ServedContent LivePage::Picture() {
  std::shared_ptr<const Under> under;
  {
    const std::lock_guard lock(mutex_);
    under = under_;
  }
  const mosaic::Mosaic& mosaic = under->mosaic;
  const page::PagePicture picture = mosaic.grey.empty()
                                        ? under->picture
                                        : page::MakePicture(mosaic.grey, mosaic.alpha, mosaic.grid);
  return {picture.mime, std::string(picture.bytes.begin(), picture.bytes.end())};
}

void LivePage::Finish(page::PageData data) {
  Put({std::exchange(data.picture, {}), {}, 0});
  std::int64_t last = 0;
  bool watched = false;
  {
    const std::lock_guard lock(mutex_);
    data_ = std::move(data);
    frames_.clear();  // they are contained in its paths
    running_ = false;
    last = ++revision_;
    watched = asked_ && terminal::SecondsSince(*asked_) < 2 * params_.farewell_s;
  }
  const steady_clock::time_point since = steady_clock::now();
  while (watched && terminal::SecondsSince(since) < params_.farewell_s) {
    constexpr std::chrono::milliseconds kRetry{20};
    std::this_thread::sleep_for(kRetry);
    const std::lock_guard lock(mutex_);
    watched = sent_revision_ < last;
  }
}

}  // namespace ceilmap::live
