#include "app/reports/stream_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ceilmap::reports {
namespace {

constexpr std::size_t kBins = 10001;

}  // namespace

void LatencyMeter::Add(double latency_ms) {
  if (counts_.empty()) counts_.resize(kBins);
  const double bin = std::clamp(std::round(latency_ms), 0.0, static_cast<double>(kBins - 1));
  ++counts_[static_cast<std::size_t>(bin)];
  ++total_;
  if (latency_ms > kLateMs) ++late_;
  max_ms_ = std::max(max_ms_, latency_ms);
}

double LatencyMeter::Quantile(double fraction) const {
  const double wanted = fraction * static_cast<double>(total_);
  std::int64_t sum = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    sum += counts_[bin];
    if (sum > 0 && static_cast<double>(sum) >= wanted) return static_cast<double>(bin);
  }
  return 0;
}

nlohmann::ordered_json StreamJson(const recordings::FrameSourceReport& reading,
                                  const LatencyMeter& latency) {
  if (!reading.live) return nullptr;
  nlohmann::ordered_json json = {
      {"received", reading.decoded},
      {"dropped", reading.dropped},
      {"missing", nullptr},
      {"late", latency.Late()},
      {"late_ms", LatencyMeter::kLateMs},
      {"latency_ms",
       {{"median", latency.Quantile(0.5)},
        {"p95", latency.Quantile(0.95)},
        {"max", latency.MaxMs()}}},
      {"reconnects", reading.outages.count},
      {"outage_s", reading.outages.seconds},
  };
  if (reading.missing) json["missing"] = *reading.missing;
  return json;
}

void AddStreamRows(const recordings::FrameSourceReport& reading,
                   const LatencyMeter& latency,
                   terminal::Table& table) {
  if (!reading.live) return;
  const auto count = [](std::int64_t n) { return fmt::format("{}", n); };
  const double received = static_cast<double>(std::max<std::int64_t>(reading.decoded, 1));
  table.AddRow({"received", count(reading.decoded), "frames of the live source"});
  table.AddRow({"dropped",
                count(reading.dropped),
                fmt::format("{:.1f} %, for lack of time",
                            100 * static_cast<double>(reading.dropped) / received)});
  if (reading.missing) {
    table.AddRow({"missing", count(*reading.missing), "did not arrive, by gaps in their times"});
  }
  table.AddRow({"late",
                count(latency.Late()),
                fmt::format("more than {:.0f} ms from arrival to pose", LatencyMeter::kLateMs)});
  table.AddRow({"latency",
                fmt::format("{:.0f}", latency.Quantile(0.5)),
                fmt::format("ms, median; 95 % within {:.0f}, at the most {:.0f}",
                            latency.Quantile(0.95),
                            latency.MaxMs())});
  if (reading.outages.count > 0) {
    table.AddRow({"reconnected",
                  count(reading.outages.count),
                  fmt::format("after {:.1f} s without frames", reading.outages.seconds)});
  }
}

}  // namespace ceilmap::reports
