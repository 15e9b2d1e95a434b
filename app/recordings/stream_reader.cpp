#include "app/recordings/stream_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {

StreamReaderParams::StreamReaderParams()
    : now_s(terminal::SteadySeconds),
      sleep([](double seconds) {
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
      }),
      notice([](const std::string& line) { terminal::PrintNote(line); }) {}

StreamReader::StreamReader(std::string name,
                           std::unique_ptr<FrameReader> first,
                           Opener open,
                           StreamReaderParams params)
    : name_(std::move(name)),
      reader_(std::move(first)),
      open_(std::move(open)),
      params_(std::move(params)),
      period_s_(reader_->FramePeriod()),
      remarks_(reader_->Remarks()),
      on_steady_clock_(reader_->OnSteadyClock()),
      opened_s_(params_.now_s()),
      last_frame_s_(opened_s_) {}

std::int64_t StreamReader::LeftOut() const {
  return left_out_ + (reader_ ? reader_->LeftOut() : 0);
}

bool StreamReader::Next(cv::Mat& image, std::optional<double>& time_s) {
  const bool read = (reader_ && reader_->Next(image, time_s)) || Reopen(image, time_s);
  if (read) last_frame_s_ = params_.now_s();
  return read;
}

// A camera must be closed before it can be opened again.
void StreamReader::Release() {
  left_out_ = LeftOut();
  reader_.reset();
}

bool StreamReader::TryAgain(cv::Mat& image, std::optional<double>& time_s) {
  try {
    reader_ = open_();
  } catch (const InputError&) {
    return false;
  }
  if (reader_->Next(image, time_s)) return true;
  Release();
  return false;
}

bool StreamReader::Reopen(cv::Mat& image, std::optional<double>& time_s) {
  if (!reader_ || !Wait(0)) return false;
  const bool was_short =
      outages_.count > 0 && params_.now_s() - opened_s_ < params_.min_connection_s;
  if (!was_short) outage_began_s_ = params_.now_s();
  const bool failed = reader_->Failed();
  const double limit_s = failed ? params_.max_outage_s : params_.max_pause_s;
  if (!was_short) {
    params_.notice(fmt::format("{}: {}; waiting for it for up to {:.0f} s, Ctrl-C ends the run",
                               name_,
                               failed ? "no frames any more" : "the sender closed the stream",
                               limit_s));
  }
  Release();
  const double end_s = outage_began_s_ + limit_s;
  double delay_s = was_short ? params_.first_delay_s : 0;
  do {
    const double left_s = end_s - params_.now_s();
    if (left_s <= 0) {
      outages_.lost = failed;
      return false;
    }
    if (!Wait(std::min(delay_s, left_s))) return false;
    delay_s = std::clamp(2 * delay_s, params_.first_delay_s, params_.max_delay_s);
  } while (!TryAgain(image, time_s));
  opened_s_ = params_.now_s();
  ++outages_.count;
  outages_.seconds += params_.now_s() - last_frame_s_;
  return true;
}

// False after an interruption and after Stop().
bool StreamReader::Wait(double seconds) const {
  constexpr double kPollS = 0.05;
  const double end_s = params_.now_s() + seconds;
  while (!stop_ && !terminal::Interrupted()) {
    const double left_s = end_s - params_.now_s();
    if (left_s <= 0) return true;
    params_.sleep(std::min(left_s, kPollS));
  }
  return false;
}

}  // namespace ceilmap::recordings
