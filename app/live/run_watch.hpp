#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "app/live/live_page.hpp"
#include "app/reports/run_report.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/preview_mosaic.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::live {

/// --report and --live, which `map` and `localize` share.
struct WatchOptions {
  std::filesystem::path report;
  bool live = false;
  std::string live_at;  ///< `[HOST:]PORT`; given: live, too

  void AddTo(CLI::App& cli, const std::string& group);
  /// Before the run begins. @throws InputError
  void Check() const;
  [[nodiscard]] bool Live() const { return live || !live_at.empty(); }
};

/// Looks on while a recording is mapped or located: keeps its frames for the report, and shows them
/// on the live page. Does nothing, and keeps nothing, when neither is asked for.
class RunWatch {
 public:
  /// @param source  of the upward camera. @param start  title, unit and map of the page.
  /// @param view  must outlive this. @throws InputError when the page cannot be served.
  RunWatch(const WatchOptions& options,
           const std::string& source,
           page::PageData start,
           const calib::CeilingView& view);

  /// @param expected  frames of the recording, where that is known.
  void Add(const graph::FramePose& frame, std::optional<std::int64_t> expected);
  /// The same for a frame that is mapped: keyframes come onto the live page.
  /// @param rectified  its image, rectified.
  void AddMapped(const graph::FramePose& frame,
                 const cv::Mat& rectified,
                 std::optional<std::int64_t> expected);

  /// Poses as they are after all were optimised; frames that are not among them have no place on
  /// the map.
  void Replace(const std::vector<graph::FramePose>& placed);

  /// A report or a live page was asked for: End has something to do.
  [[nodiscard]] bool Wanted() const { return !report_.empty() || live_; }
  /// Writes the report and shows its page. Says on stdout where, unless `quiet`.
  /// @throws RunError when the disk refuses.
  void End(const store::MapReader& map,
           const terminal::Table& facts,
           bool quiet,
           terminal::Summary& summary);

 private:
  std::filesystem::path report_;
  reports::RunRecord run_;
  mosaic::LiveMosaic mosaic_;
  std::int64_t last_keyframe_ = -1;
  std::unique_ptr<LivePage> live_;
};

}  // namespace ceilmap::live
