#include "app/terminal/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/terminal/console.hpp"

namespace ceilmap::terminal {
namespace {

using std::chrono::steady_clock;

constexpr int kBarWidth = 24;
constexpr auto kRefresh = std::chrono::milliseconds(100);

// Slow work is counted by the minute or hour.
std::string FormatRate(double per_second) {
  constexpr double kMinRate = 0.1;
  if (per_second >= kMinRate || per_second <= 0) return fmt::format("{:.1f}/s", per_second);
  if (per_second * 60 >= kMinRate) return fmt::format("{:.1f}/min", per_second * 60);
  return fmt::format("{:.1f}/h", per_second * 3600);
}

}  // namespace

std::string FormatDuration(double seconds) {
  if (seconds < 59.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string FormatProgress(const std::string& label,
                           const std::string& unit,
                           std::int64_t done,
                           std::optional<std::int64_t> total,
                           double elapsed_s) {
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0;
  if (!total || *total <= 0)
    return fmt::format("{}  {} {}  {}", label, done, unit, FormatRate(rate));
  // A container may state fewer frames than it has.
  const double fraction =
      std::clamp(static_cast<double>(done) / static_cast<double>(*total), 0.0, 1.0);
  const int filled = static_cast<int>(std::floor(fraction * kBarWidth));
  std::string line = fmt::format("{}  [{:#<{}}{:.<{}}]  {}/{} {}  {}",
                                 label,
                                 "",
                                 filled,
                                 "",
                                 kBarWidth - filled,
                                 done,
                                 *total,
                                 unit,
                                 FormatRate(rate));
  if (rate > 0 && done < *total) {
    line += fmt::format("  {} left", FormatDuration(static_cast<double>(*total - done) / rate));
  }
  return line;
}

Progress::Progress(std::string label, std::string unit, std::optional<std::int64_t> total)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      total_(total),
      enabled_(ConsoleIsTerminal() && GetVerbosity() != Verbosity::kQuiet),
      start_(steady_clock::now()),
      shown_(start_) {}

Progress::~Progress() {
  if (enabled_) ShowStatusLine("");
}

void Progress::Update(std::int64_t done) {
  const auto now = steady_clock::now();
  if (!enabled_ || now - shown_ < kRefresh) return;
  shown_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  ShowStatusLine(FormatProgress(label_, unit_, done, total_, elapsed_s));
}

void Progress::Update(std::int64_t done, std::int64_t total) {
  total_ = total;
  Update(done);
}

}  // namespace ceilmap::terminal
