#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/live/page_server.hpp"
#include "app/page/page_data.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/preview_mosaic.hpp"

namespace ceilmap::live {

/// The page of a run while it goes on, for robots without a screen: served on this machine, or
/// where --live says. It has what the report's page has, as far as the run has come. The run itself
/// is never kept waiting by who looks.
///
/// Add, SetMosaic and Finish come from the run's thread, browsers ask from those of the server.
class LivePage {
 public:
  struct Options {
    ServerAddress address;
    /// Of frames that the page has at a time; when there are more every second one goes.
    std::size_t max_frames = 20000;
    /// That the last state waits for who is looking, seconds >= 0.
    double farewell_s = 2;
  };

  /// Serves from now on. @param start  what is known before the run: title, unit, map; no paths.
  /// @param run  the path's name. @param footprint  of the camera, see page::PagePath.
  /// @throws InputError as PageServer.
  LivePage(const Options& params,
           page::PageData start,
           std::string run,
           std::vector<std::array<double, 2>> footprint);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  [[nodiscard]] const std::string& Url() const { return server_->Url(); }

  /// A frame that was mapped or located, or was not. @param expected  frames of the whole run, 0:
  /// not known.
  void Add(const graph::FramePose& frame, std::int64_t expected);
  void Add(const page::PageKeyframe& keyframe);
  /// Another mosaic under the paths; it becomes a picture when somebody asks for it.
  void SetMosaic(mosaic::Mosaic mosaic);
  /// Shows this from now on: the run has ended. Waits a little until who is looking has seen it.
  void Finish(page::PageData data);

 private:
  // A picture, or what it will be made from: only its place is known before.
  struct Under {
    page::PagePicture picture;
    mosaic::Mosaic mosaic;
    std::int64_t revision = 0;
  };

  ServedContent Document(const std::string& query);
  ServedContent Picture();
  void Put(Under under);

  const Options params_;
  const std::string run_;
  const std::vector<std::array<double, 2>> footprint_;

  std::mutex mutex_;  // of all that follows
  page::PageData data_;
  std::shared_ptr<const Under> under_;
  std::vector<graph::FramePose> frames_;
  std::int64_t every_ = 1;  // frame that is kept
  std::int64_t revision_ = 0;
  std::int64_t done_ = 0;
  std::int64_t expected_ = 0;
  bool running_ = true;
  std::chrono::steady_clock::time_point start_;
  std::optional<std::chrono::steady_clock::time_point> asked_;  // last
  std::int64_t told_revision_ = -1;

  std::unique_ptr<PageServer> server_;  // last: its threads end first
};

}  // namespace ceilmap::live
