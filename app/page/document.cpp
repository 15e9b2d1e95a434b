#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/page/base64.hpp"
#include "app/page/html_json.hpp"
#include "app/page/page.hpp"
#include "app/page/thinning.hpp"

namespace ceilmap::page {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMaxPoses = 200'000;       // of all paths together
constexpr std::size_t kMaxCurvePoints = 20'000;  // of one curve; screens have fewer columns
constexpr double kStampStepS = 1e-6;
constexpr double kLengthStep = 1e-4;  // of x and y, in the page's unit
constexpr double kPlanStep = 1e-3;    // of the plan's lines
constexpr double kYawStepRad = 1e-4;
constexpr double kSigmaStep = 1e-6;  // of standard deviations, in the page's unit or rad
constexpr double kCorrelationStep = 1e-3;

// A number as a multiple of `step`, null if unknown. Integers are shorter than decimals and parsed
// faster.
ordered_json Steps(double value, double step) {
  if (!std::isfinite(value)) return nullptr;
  return std::llround(value / step);
}

// Stamps as differences to the previous one, the first one to the page's first stamp. Sums of
// integers are exact.
class StampColumn {
 public:
  explicit StampColumn(double first_s) : first_s_(first_s) {}
  void Add(double stamp_s) {
    const std::int64_t stamp = std::llround((stamp_s - first_s_) / kStampStepS);
    column_.push_back(stamp - last_);
    last_ = stamp;
  }
  ordered_json Take() { return std::move(column_); }

 private:
  double first_s_;
  std::int64_t last_ = 0;
  ordered_json column_ = ordered_json::array();
};

double FirstStamp(const PageData& data) {
  double first_s = std::numeric_limits<double>::infinity();
  for (const PagePath& path : data.paths) {
    if (!path.poses.empty()) first_s = std::min(first_s, path.poses.front().stamp_s);
  }
  for (const PageChart& chart : data.charts) {
    for (const PageSeries& series : chart.series) {
      if (chart.over_time && !series.x.empty()) first_s = std::min(first_s, series.x.front());
    }
  }
  return std::isfinite(first_s) ? first_s : 0;
}

char StatusLetter(graph::TrackingStatus status) {
  switch (status) {
    case graph::TrackingStatus::kTracking:
      return 't';
    case graph::TrackingStatus::kRelocalized:
      return 'r';
    case graph::TrackingStatus::kPredicted:
      return 'p';
    case graph::TrackingStatus::kAmbiguous:
      return 'a';
    case graph::TrackingStatus::kLost:
      return 'l';
  }
  return 'l';
}

const char* RoleName(PathRole role) {
  switch (role) {
    case PathRole::kTruth:
      return "truth";
    case PathRole::kRun:
      return "run";
    case PathRole::kBefore:
      return "before";
  }
  return "run";
}

bool IsKnown(const std::array<double, 4>& covariance) {
  return std::any_of(covariance.begin(), covariance.end(), [](double v) { return v != 0; });
}

struct SigmaColumns {
  ordered_json x = ordered_json::array();
  ordered_json y = ordered_json::array();
  ordered_json yaw = ordered_json::array();
  ordered_json correlation = ordered_json::array();

  void Add(const std::array<double, 4>& covariance) {
    if (!IsKnown(covariance)) {
      for (ordered_json* column : {&x, &y, &yaw, &correlation}) column->push_back(nullptr);
      return;
    }
    const auto& [xx, xy, yy, yaw_yaw] = covariance;
    const double product = std::sqrt(xx * yy);
    x.push_back(Steps(std::sqrt(xx), kSigmaStep));
    y.push_back(Steps(std::sqrt(yy), kSigmaStep));
    yaw.push_back(Steps(std::sqrt(yaw_yaw), kSigmaStep));
    correlation.push_back(Steps(product > 0 ? xy / product : 0, kCorrelationStep));
  }
};

void AddSigmas(const std::vector<PagePose>& poses,
               const std::vector<std::size_t>& chosen,
               ordered_json& json) {
  SigmaColumns sigma;
  for (const std::size_t i : chosen) sigma.Add(poses[i].covariance);
  json["sigma_x"] = std::move(sigma.x);
  json["sigma_y"] = std::move(sigma.y);
  json["sigma_yaw"] = std::move(sigma.yaw);
  json["correlation"] = std::move(sigma.correlation);
}

ordered_json PathToJson(const PagePath& path, double first_s, std::size_t keep) {
  const std::vector<std::size_t> chosen = EvenIndices(path.poses.size(), keep);
  StampColumn stamps(first_s);
  ordered_json x = ordered_json::array();
  ordered_json y = ordered_json::array();
  ordered_json yaw = ordered_json::array();
  std::string status;
  for (const std::size_t i : chosen) {
    const PagePose& pose = path.poses[i];
    stamps.Add(pose.stamp_s);
    x.push_back(Steps(pose.x, kLengthStep));
    y.push_back(Steps(pose.y, kLengthStep));
    yaw.push_back(Steps(pose.yaw_rad, kYawStepRad));
    status += StatusLetter(pose.status);
  }
  ordered_json json = {{"name", path.name},
                       {"role", RoleName(path.role)},
                       {"poses", path.poses.size()},
                       {"footprint", path.footprint},
                       {"status", std::move(status)},
                       {"stamps", stamps.Take()},
                       {"x", std::move(x)},
                       {"y", std::move(y)},
                       {"yaw", std::move(yaw)}};
  if (std::any_of(path.poses.begin(), path.poses.end(), [](const PagePose& pose) {
        return IsKnown(pose.covariance);
      })) {
    AddSigmas(path.poses, chosen, json);
  }
  return json;
}

ordered_json PathsToJson(const std::vector<PagePath>& paths, double first_s) {
  std::size_t all = 0;
  for (const PagePath& path : paths) all += path.poses.size();
  ordered_json json = ordered_json::array();
  for (const PagePath& path : paths) {
    const std::size_t keep =
        all <= kMaxPoses ? path.poses.size() : path.poses.size() * kMaxPoses / all;
    json.push_back(PathToJson(path, first_s, keep));
  }
  return json;
}

std::string DataUrl(const std::string& mime, const std::vector<unsigned char>& bytes) {
  return "data:" + mime + ";base64," + Base64(bytes);
}

ordered_json PlacementToJson(const Similarity2& S_page_map) {
  const Pose2& motion = S_page_map.motion;
  return {{"scale", S_page_map.scale}, {"x", motion.x}, {"y", motion.y}, {"yaw", motion.yaw}};
}

// Each line as x, y, x, y, ..., whole steps from the point before, the first from the origin.
ordered_json PlanLinesToJson(const PagePlan& plan, const std::array<double, 2>& origin) {
  ordered_json lines = ordered_json::array();
  for (const auto& line : plan.lines) {
    ordered_json steps = ordered_json::array();
    std::array<std::int64_t, 2> last{};
    for (const auto& point : line) {
      for (const std::size_t axis : {0U, 1U}) {
        const std::int64_t here = std::llround((point.at(axis) - origin.at(axis)) / kPlanStep);
        steps.push_back(here - last.at(axis));
        last.at(axis) = here;
      }
    }
    lines.push_back(std::move(steps));
  }
  return lines;
}

ordered_json PlanToJson(const PagePlan& plan) {
  if (plan.empty()) return nullptr;
  std::array<double, 2> origin{};
  for (const auto& line : plan.lines) {
    if (line.empty()) continue;
    origin = line.front();
    break;
  }
  ordered_json json = {{"url", nullptr},
                       {"corners", plan.corners},
                       {"origin", origin},
                       {"lines", PlanLinesToJson(plan, origin)}};
  if (!plan.bytes.empty()) json["url"] = DataUrl(plan.mime, plan.bytes);
  return json;
}

ordered_json PictureToJson(const PagePicture& picture, const std::string& url) {
  if (picture.empty() && url.empty()) return nullptr;
  return {{"url", url.empty() ? DataUrl(picture.mime, picture.bytes) : url},
          {"extent", {picture.min_x, picture.min_y, picture.max_x, picture.max_y}}};
}

// A byte for each cell: 0 where not known, otherwise 1 more than the steps above the lowest height.
ordered_json HeightsToJson(const PageHeights& heights) {
  constexpr double kFinestStepM = 0.01;
  constexpr int kMaxSteps = 254;
  std::vector<float> known;
  std::copy_if(
      heights.metres.begin(), heights.metres.end(), std::back_inserter(known), [](float metres) {
        return !std::isnan(metres);
      });
  if (known.empty()) return nullptr;
  std::sort(known.begin(), known.end());
  const double lowest = known.front();
  const double highest = known.back();
  // Few wrong heights must not take up the scale of colours.
  const std::size_t outliers = known.size() / 50;  // at each end
  const double step = std::max(kFinestStepM, (highest - lowest) / kMaxSteps);
  std::vector<unsigned char> cells;
  cells.reserve(heights.metres.size());
  for (const float metres : heights.metres) {
    cells.push_back(std::isnan(metres)
                        ? 0
                        : static_cast<unsigned char>(1 + std::lround((metres - lowest) / step)));
  }
  return {{"columns", heights.columns},
          {"rows", heights.rows},
          {"min_x", heights.min_x},
          {"max_y", heights.max_y},
          {"cell", heights.cell},
          {"lowest_m", lowest},
          {"highest_m", highest},
          {"colours_m", {known[outliers], known[known.size() - 1 - outliers]}},
          {"step_m", step},
          {"cells", Base64(cells)}};
}

ordered_json KeyframesToJson(const std::vector<PageKeyframe>& keyframes) {
  ordered_json json = {{"id", ordered_json::array()},
                       {"x", ordered_json::array()},
                       {"y", ordered_json::array()},
                       {"yaw", ordered_json::array()}};
  for (const PageKeyframe& keyframe : keyframes) {
    json["id"].push_back(keyframe.id);
    json["x"].push_back(Steps(keyframe.x, kLengthStep));
    json["y"].push_back(Steps(keyframe.y, kLengthStep));
    json["yaw"].push_back(Steps(keyframe.yaw_rad, kYawStepRad));
  }
  return json;
}

ordered_json EdgesToJson(const std::vector<PageEdge>& edges) {
  ordered_json from = ordered_json::array();
  ordered_json to = ordered_json::array();
  std::string kind;  // of each edge: w (odometry) or l (loop)
  for (const PageEdge& edge : edges) {
    from.push_back(edge.from);
    to.push_back(edge.to);
    kind += edge.loop ? 'l' : 'w';
  }
  return {{"from", std::move(from)}, {"to", std::move(to)}, {"kind", std::move(kind)}};
}

// Six digits are more than a screen can resolve.
ordered_json Rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0;
  const double digits = 5 - std::floor(std::log10(std::abs(value)));
  if (digits > 300 || digits < 0) return value;
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}

ordered_json SeriesToJson(const PageSeries& series, bool over_time, double first_s) {
  const std::vector<std::size_t> chosen = CurveIndices(series.y, kMaxCurvePoints);
  StampColumn stamps(first_s);
  ordered_json x = ordered_json::array();
  ordered_json y = ordered_json::array();
  for (const std::size_t i : chosen) {
    if (over_time) {
      stamps.Add(series.x[i]);
    } else {
      x.push_back(Rounded(series.x[i]));
      if (!series.stamps_s.empty()) stamps.Add(series.stamps_s[i]);
    }
    y.push_back(Rounded(series.y[i]));
  }
  return {
      {"name", series.name}, {"stamps", stamps.Take()}, {"x", std::move(x)}, {"y", std::move(y)}};
}

ordered_json ChartToJson(const PageChart& chart, double first_s) {
  ordered_json series = ordered_json::array();
  for (const PageSeries& one : chart.series) {
    series.push_back(SeriesToJson(one, chart.over_time, first_s));
  }
  return {{"title", chart.title},
          {"x_label", chart.x_label},
          {"y_label", chart.y_label},
          {"over_time", chart.over_time},
          {"series", std::move(series)}};
}

ordered_json StateToJson(const RunState& state) {
  return {{"revision", state.revision},
          {"running", state.running},
          {"rate_hz", Rounded(state.rate_hz)},
          {"frames", state.frames},
          {"frames_expected", state.frames_expected}};
}

}  // namespace

std::string WriteDocument(const PageData& data,
                          const RunState& state,
                          const std::string& picture_url) {
  data.Validate();
  const double first_s = FirstStamp(data);
  ordered_json areas = ordered_json::array();
  for (const PageArea& area : data.areas) {
    areas.push_back({{"text", area.text}, {"rings", area.rings}});
  }
  ordered_json spots = ordered_json::array();
  for (const PageSpot& spot : data.spots) {
    spots.push_back({{"text", spot.text}, {"x", spot.x}, {"y", spot.y}});
  }
  ordered_json charts = ordered_json::array();
  for (const PageChart& chart : data.charts) charts.push_back(ChartToJson(chart, first_s));
  ordered_json tables = ordered_json::array();
  for (const PageTable& table : data.tables) {
    tables.push_back({{"title", table.title}, {"columns", table.columns}, {"rows", table.rows}});
  }
  return DumpForHtml({{"title", data.title},
                      {"note", data.note},
                      {"unit", data.unit},
                      {"state", StateToJson(state)},
                      {"first_stamp_s", first_s},
                      {"placement", PlacementToJson(data.S_page_map)},
                      {"plan", PlanToJson(data.plan)},
                      {"picture", PictureToJson(data.picture, picture_url)},
                      {"before", PictureToJson(data.before, {})},
                      {"heights", HeightsToJson(data.heights)},
                      {"paths", PathsToJson(data.paths, first_s)},
                      {"keyframes", KeyframesToJson(data.keyframes)},
                      {"edges", EdgesToJson(data.edges)},
                      {"spots", std::move(spots)},
                      {"areas", std::move(areas)},
                      {"charts", std::move(charts)},
                      {"tables", std::move(tables)}});
}

std::string WriteUnchanged(const RunState& state) {
  return DumpForHtml({{"unchanged", true}, {"state", StateToJson(state)}});
}

}  // namespace ceilmap::page
