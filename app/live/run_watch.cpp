#include "app/live/run_watch.hpp"

#include <fmt/format.h>

#include <unordered_map>
#include <utility>

#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::live {
namespace {

constexpr const char* kDefaultAddress = "8800";

// Short name of a recording.
std::string NameOf(const std::string& source) {
  const fs::path path(source);
  const fs::path name = path.has_filename() ? path.filename() : path.parent_path().filename();
  return name.empty() ? source : name.string();
}

ServerAddress AddressOf(const WatchOptions& options) {
  return ParseServerAddress(options.live_at.empty() ? kDefaultAddress : options.live_at,
                            "--live-at");
}

}  // namespace

void WatchOptions::AddTo(CLI::App& cli, const std::string& group) {
  cli.add_option("--report", report, "Folder for a page (index.html), figures and tables")
      ->type_name("DIR")
      ->group(group);
  cli.add_flag("--live",
               live,
               fmt::format("Serve the page during the run, to this machine only, at "
                           "http://127.0.0.1:{}/",
                           kDefaultAddress))
      ->group(group);
  cli.add_option(
         "--live-at", live_at, "Serve it at this address; 0.0.0.0:PORT: to the whole network")
      ->type_name("[HOST:]PORT")
      ->group(group);
}

void WatchOptions::Check(files::Existing existing) const {
  if (!report.empty()) files::CheckOutputFolder(report, existing);
  if (Live()) AddressOf(*this);
}

RunWatch::RunWatch(const WatchOptions& options,
                   const std::string& source,
                   page::PageData start,
                   const calib::CeilingView& view,
                   std::optional<reports::PageSite> site)
    : report_(options.report), mosaic_(view) {
  run_.name = NameOf(source);
  run_.title = start.title;
  run_.footprint = reports::FootprintOf(view);
  run_.site = std::move(site);
  if (!options.Live()) return;
  LivePage::Options params;
  params.address = AddressOf(options);
  try {
    live_ = std::make_unique<LivePage>(
        params, std::move(start), run_.name, reports::ShownFootprint(run_));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}; give another address by --live-at", error.what()));
  }
  terminal::Note("live page: {}", live_->Url());
}

void RunWatch::Add(const graph::FramePose& frame, std::optional<std::int64_t> expected) {
  if (Wanted()) run_.frames.push_back(frame);
  if (!live_) return;
  live_->Add(run_.site ? reports::InSite(run_.site->frame, frame) : frame, expected.value_or(0));
}

void RunWatch::AddMapped(const graph::FramePose& frame,
                         const cv::Mat& rectified,
                         std::optional<std::int64_t> expected) {
  Add(frame, expected);
  if (!live_ || frame.status != graph::TrackingStatus::kTracking) return;
  if (frame.keyframe_id <= last_keyframe_) return;
  last_keyframe_ = frame.keyframe_id;
  const Pose2& T_map_base = frame.T_map_base;
  live_->Add(page::PageKeyframe{frame.keyframe_id, T_map_base.x, T_map_base.y, T_map_base.yaw});
  mosaic_.Add(rectified, T_map_base);
  live_->SetMosaic(mosaic_.Copy());
}

void RunWatch::Replace(const std::vector<graph::FramePose>& placed) {
  if (run_.frames.empty()) return;
  std::unordered_map<std::int64_t, const graph::FramePose*> by_index;
  by_index.reserve(placed.size());
  for (const graph::FramePose& frame : placed) by_index.emplace(frame.frame_index, &frame);
  for (graph::FramePose& frame : run_.frames) {
    const auto found = by_index.find(frame.frame_index);
    if (found != by_index.end()) {
      frame = *found->second;
    } else if (frame.status == graph::TrackingStatus::kTracking) {
      frame.status = graph::TrackingStatus::kLost;
    }
  }
}

void RunWatch::End(const store::MapReader& map,
                   const terminal::Table& facts,
                   bool quiet,
                   terminal::Summary& summary) {
  if (!Wanted()) return;
  const std::vector<reports::ReportTable> tables = {reports::FactsTable("Run", facts)};
  page::PageData data = reports::PageOf(run_, map);
  reports::AddTables(tables, data);
  if (!report_.empty()) {
    reports::WriteRunReport(report_, run_, data, map, tables, summary);
    if (!quiet) fmt::print("written {}\n", (report_ / "index.html").string());
  }
  if (live_) live_->Finish(std::move(data));
}

}  // namespace ceilmap::live
