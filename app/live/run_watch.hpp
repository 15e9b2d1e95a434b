#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "app/files/output_files.hpp"
#include "app/live/live_page.hpp"
#include "app/reports/run_report.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/preview_mosaic.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::live {

/// The options --report and --live of `map` and `localize`.
struct WatchOptions {
  std::filesystem::path report;
  bool live = false;
  std::string live_at;  ///< `[HOST:]PORT`; implies live

  void AddTo(CLI::App& cli, const std::string& group);
  /// Checks the options before the run. @throws InputError
  void Check(files::Existing existing) const;
  [[nodiscard]] bool Live() const { return live || !live_at.empty(); }
  [[nodiscard]] bool HasPage() const { return Live() || !report.empty(); }
};

/// Observes a run of `map` or `localize`: keeps its frames for the report, and shows them on the
/// live page. Does nothing if neither is requested.
class RunWatch {
 public:
  /// @param source  Of the upward camera. @param start  Title, unit and map of the page.
  /// @param view  Must outlive the object. @param site  Coordinates of the page, if not the map's;
  /// `start` has them. @throws InputError when the page cannot be served.
  RunWatch(const WatchOptions& options,
           const std::string& source,
           page::PageData start,
           const calib::CeilingView& view,
           std::optional<reports::PageSite> site = {});

  /// @param expected  Number of frames of the recording, if known.
  void Add(const graph::FramePose& frame, std::optional<std::int64_t> expected);
  /// The same for a frame that is mapped: keyframes are added to the live page.
  /// @param rectified  its image, rectified.
  void AddMapped(const graph::FramePose& frame,
                 const cv::Mat& rectified,
                 std::optional<std::int64_t> expected);

  /// Replaces the poses by optimised ones. Frames that are not among them have no pose on the map.
  void Replace(const std::vector<graph::FramePose>& placed);

  /// True when a report or a live page was requested, so that End has work to do.
  [[nodiscard]] bool Wanted() const { return !report_.empty() || live_; }
  /// Writes the report and shows its page. Prints the paths to stdout, unless `quiet`.
  /// @throws RunError when the disk cannot be written.
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
