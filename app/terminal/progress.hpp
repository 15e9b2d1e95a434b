#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace ceilmap::terminal {

/// One line of progress, e.g. `mapping  [#####.....]  193/387 frames  132.4/s  1.5 s left`; without
/// a total there is no bar and no remaining time.
std::string FormatProgress(const std::string& label,
                           const std::string& unit,
                           std::int64_t done,
                           std::optional<std::int64_t> total,
                           double elapsed_s);

/// A duration as text: `4.2 s`, `3 min 05 s`, `1 h 02 min`.
std::string FormatDuration(double seconds);

/// Shows progress at the bottom of the terminal, a few times a second. Does nothing if stderr is no
/// terminal or with --quiet. The destructor removes the line.
class Progress {
 public:
  Progress(std::string label, std::string unit, std::optional<std::int64_t> total = std::nullopt);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Update(std::int64_t done);
  void Update(std::int64_t done, std::int64_t total);

 private:
  std::string label_;
  std::string unit_;
  std::optional<std::int64_t> total_;
  bool enabled_;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace ceilmap::terminal
