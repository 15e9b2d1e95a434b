#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/terminal/table.hpp"

namespace ceilmap::reports {

/// Times from the arrival of live frames to their poses. Memory does not grow with their number.
class LatencyMeter {
 public:
  static constexpr double kLateMs = 100;

  void Add(double latency_ms);
  /// Frames with more than kLateMs.
  [[nodiscard]] std::int64_t Late() const { return late_; }
  /// Latency that a fraction of the frames does not exceed, in ms, to 1 ms and up to 10 s; 0
  /// without frames. @param fraction  0..1
  [[nodiscard]] double Quantile(double fraction) const;
  [[nodiscard]] double MaxMs() const { return max_ms_; }

 private:
  std::vector<std::int64_t> counts_;  // by ms
  std::int64_t total_ = 0;
  std::int64_t late_ = 0;
  double max_ms_ = 0;
};

/// Frames and latency of a live source for --summary; null for a recording.
nlohmann::ordered_json StreamJson(const recordings::FrameSourceReport& reading,
                                  const LatencyMeter& latency);

/// Adds the rows of a live source to the table of a run, none for a recording.
void AddStreamRows(const recordings::FrameSourceReport& reading,
                   const LatencyMeter& latency,
                   terminal::Table& table);

}  // namespace ceilmap::reports
