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

/// The page of a running command, for robots without a screen, served on this machine or at the
/// address of --live-at. It has the content of the report's page, up to the current frame. Clients
/// never delay the run.
///
/// Add, SetMosaic and Finish are called by the run's thread, requests by the server's threads.
class LivePage {
 public:
  struct Options {
    ServerAddress address;
    /// Maximum number of frames on the page; above it, every second frame is dropped.
    std::size_t max_frames = 20000;
    /// Time to wait for clients to fetch the last state, seconds >= 0.
    double farewell_s = 2;
  };

  /// Starts the server. @param start  Data before the run: title, unit, map; no paths.
  /// @param run  Name of the path. @param footprint  Of the camera, see page::PagePath.
  /// @throws InputError as PageServer.
  LivePage(const Options& params,
           page::PageData start,
           std::string run,
           std::vector<std::array<double, 2>> footprint);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  [[nodiscard]] const std::string& Url() const { return server_->Url(); }

  /// Adds a frame, with or without a pose. @param expected  Number of frames of the run, 0:
  /// unknown.
  void Add(const graph::FramePose& frame, std::int64_t expected);
  void Add(const page::PageKeyframe& keyframe);
  /// Sets another mosaic under the paths. It is encoded when a client requests it.
  void SetMosaic(mosaic::Mosaic mosaic);
  /// Shows this final page: the run has ended. Waits for a limited time until clients have fetched
  /// it.
  void Finish(page::PageData data);

 private:
  // A picture, or the mosaic from which it will be made: only its extent is known before.
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

  std::mutex mutex_;  // guards all following members
  page::PageData data_;
  std::shared_ptr<const Under> under_;
  std::vector<graph::FramePose> frames_;
  std::int64_t every_ = 1;  // every n-th frame is kept
  std::int64_t revision_ = 0;
  std::int64_t done_ = 0;
  std::int64_t expected_ = 0;
  bool running_ = true;
  std::chrono::steady_clock::time_point start_;
  std::optional<std::chrono::steady_clock::time_point> asked_;  // last request
  std::int64_t sent_revision_ = -1;

  std::unique_ptr<PageServer> server_;  // last member: its threads end first
};

}  // namespace ceilmap::live
