#include "app/recordings/frame_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

#include "app/recordings/frame_reader.hpp"
#include "app/recordings/live_queue.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

using std::chrono::steady_clock;

void CheckNotInterrupted(const std::string& source) {
  if (terminal::Interrupted()) {
    throw RunError(fmt::format("{}: interrupted before its first frame", source));
  }
}

std::unique_ptr<FrameReader> OpenReader(const std::string& source,
                                        const FrameSourceOptions& options) {
  try {
    return FrameReader::Open(source, options.pixels, options.bag);
  } catch (const InputError&) {
    CheckNotInterrupted(source);
    throw;
  }
}

}  // namespace

// A second is enough for a search of the whole map; a consumer that is still behind after two is
// too slow for its source.
FrameSourceOptions FrameSourceOptions::ForNewest() const {
  FrameSourceOptions options = *this;
  options.live_wait_s = 1;
  options.live_behind_s = 2;
  return options;
}

/// Shared with the decoding thread, which may outlive the FrameSource when it waits for a camera.
struct FrameSource::State {
  // Constant while the thread runs.
  std::string name;
  std::unique_ptr<FrameReader> reader;  // used by the thread only
  cv::Size size;
  std::optional<std::int64_t> expected;
  std::size_t read_ahead = 0;
  double clock_offset_s = terminal::ClockSeconds() - terminal::SteadySeconds();

  // Used by the thread only.
  std::int64_t next_index = 0;
  std::int64_t left_out = 0;  // by the reader, up to next_index
  int restarts = 0;           // of the reader, up to the last frame
  std::optional<FrameStamps> stamps;

  // Guarded by the lock.
  std::mutex mutex;
  std::condition_variable filled;
  std::condition_variable taken;
  std::deque<Frame> queue;
  std::optional<LiveQueue> live;  // in place of the queue; constant whether there is one
  bool live_times = false;        // its frames have presentation times
  std::vector<cv::Mat> spare;
  bool stop = false;
  bool ended = false;
  std::exception_ptr error;
  FrameSourceReport report;
  std::vector<std::string> warnings;

  std::thread thread;

  void SkipLeftOut();
  bool Decode(Frame& frame, std::optional<double>& time_s);
  bool DecodeFile(Frame& frame);
  bool DecodeLive();
  double StampOf(const Frame& frame, const std::optional<double>& time_s);
  void AddOutages();
  void CheckEnd();
  cv::Mat TakeSpare();
  bool Push(Frame&& frame);
  [[nodiscard]] double Now() const { return terminal::SteadySeconds() + clock_offset_s; }
  [[nodiscard]] bool HasFrame() const;
  Frame TakeFrame();
  void Run();
};

bool FrameSource::State::Decode(Frame& frame, std::optional<double>& time_s) {
  const auto start = steady_clock::now();
  if (stamps->EndBefore(next_index) || !reader->Next(frame.image, time_s)) return false;
  if (size.empty()) size = frame.image.size();
  if (frame.image.size() != size) {
    throw InputError(fmt::format("{}: frame {} is {}x{} px, the frames before it are {}x{}",
                                 name,
                                 next_index,
                                 frame.image.cols,
                                 frame.image.rows,
                                 size.width,
                                 size.height));
  }
  SkipLeftOut();
  frame.index = next_index++;
  frame.encoding = reader->GetEncoding();
  const std::lock_guard lock(mutex);
  ++report.decoded;
  report.decode_ms += terminal::MillisecondsSince(start);
  return true;
}

bool FrameSource::State::DecodeFile(Frame& frame) {
  std::optional<double> time_s;
  if (!Decode(frame, time_s)) return false;
  frame.stamp_s = StampOf(frame, time_s);
  return true;
}

// Reads a frame of a live source into the queue.
bool FrameSource::State::DecodeLive() {
  Frame frame;
  frame.image = TakeSpare();
  std::optional<double> time_s;
  const bool read = Decode(frame, time_s);
  frame.arrival_s = Now();
  const FrameReader::Outages outages = reader->GetOutages();
  const std::lock_guard lock(mutex);
  report.outages = outages;
  if (!read) return false;
  if (stamps->Origin() == StampOrigin::kStampsFile) {
    frame.stamp_s = StampOf(frame, time_s);
  } else if (time_s) {
    live_times = true;
    if (reader->OnSteadyClock()) *time_s += clock_offset_s;
  }
  live->Push(std::move(frame), time_s, outages.count > restarts, spare);
  restarts = outages.count;
  report.dropped = live->Dropped();
  report.missing = live->Missing();
  filled.notify_one();
  return !stop;
}

// Frames that the reader skipped have indices and stamps too.
void FrameSource::State::SkipLeftOut() {
  next_index += reader->LeftOut() - left_out;
  left_out = reader->LeftOut();
}

double FrameSource::State::StampOf(const Frame& frame, const std::optional<double>& time_s) {
  return stamps->Of(frame.index, time_s, reader->FramePeriod().value_or(1));
}

// The caller holds the lock.
void FrameSource::State::AddOutages() {
  const FrameReader::Outages& outages = report.outages;
  if (outages.count > 0) {
    warnings.push_back(
        fmt::format("{}: it was interrupted {} {}, for {:.1f} s in all, and opened again",
                    name,
                    outages.count,
                    outages.count == 1 ? "time" : "times",
                    outages.seconds));
  }
  if (outages.lost) {
    warnings.push_back(
        fmt::format("{}: it failed and did not return; the run ends with the frames before", name));
  }
}

// Checks at the end of the source whether all frames were read.
void FrameSource::State::CheckEnd() {
  const std::lock_guard lock(mutex);
  if (left_out > 0) {
    warnings.push_back(
        fmt::format("{}: {} of {} frames are damaged, or depend on damaged ones, and were left out",
                    name,
                    left_out,
                    next_index));
  }
  AddOutages();
  const std::int64_t frames = next_index + reader->LeftOut() - left_out;
  const bool early = expected && next_index < *expected &&
                     next_index < reader->ExpectedFrames().value_or(*expected);
  if (early && !stamps->AllOfAnotherUsed(frames)) {
    warnings.push_back(fmt::format(
        "{}: only {} of {} frames could be read; the file seems to be cut off or damaged",
        name,
        next_index,
        *expected));
  } else {
    stamps->CheckEnd(frames);
  }
  for (std::string& remark : reader->EndRemarks()) warnings.push_back(std::move(remark));
  for (std::string& warning : stamps->Warnings(next_index, reader->FramePeriod().value_or(1))) {
    warnings.push_back(std::move(warning));
  }
}

cv::Mat FrameSource::State::TakeSpare() {
  const std::lock_guard lock(mutex);
  if (spare.empty()) return {};
  cv::Mat image = std::move(spare.back());
  spare.pop_back();
  return image;
}

bool FrameSource::State::Push(Frame&& frame) {
  std::unique_lock lock(mutex);
  taken.wait(lock, [this] { return stop || queue.size() < read_ahead; });
  if (stop) return false;
  queue.push_back(std::move(frame));
  filled.notify_one();
  return true;
}

bool FrameSource::State::HasFrame() const {
  return live ? live->Ready(Now(), ended) : !queue.empty();
}

Frame FrameSource::State::TakeFrame() {
  if (live) return live->Take();
  Frame frame = std::move(queue.front());
  queue.pop_front();
  taken.notify_one();
  return frame;
}

void FrameSource::State::Run() {
  try {
    bool wanted = true;
    if (live) {
      while (DecodeLive()) continue;
    } else {
      Frame frame;
      while (wanted && DecodeFile(frame)) {
        wanted = Push(std::move(frame));
        frame = Frame();
        frame.image = TakeSpare();
      }
    }
    if (wanted) CheckEnd();
  } catch (...) {
    const std::lock_guard lock(mutex);
    error = std::current_exception();
  }
  const std::lock_guard lock(mutex);
  ended = true;
  filled.notify_all();
}

FrameSource::FrameSource(const std::string& source, const FrameSourceOptions& options)
    : FrameSource(nullptr, source, options) {}

FrameSource::FrameSource(std::unique_ptr<FrameReader> reader,
                         const std::string& source,
                         const FrameSourceOptions& options)
    : state_(std::make_shared<State>()) {
  State& state = *state_;
  state.name = source;
  state.stamps.emplace(source, options.stamps, options.stamps_of_another);
  state.reader = reader ? std::move(reader) : OpenReader(source, options);
  if (const std::string part = state.reader->Part(); !part.empty()) state.name += ":" + part;
  state.warnings = state.reader->Remarks();
  state.read_ahead = static_cast<std::size_t>(std::max(options.read_ahead, 1));
  state.report.live = state.reader->GetKind() == FrameReader::Kind::kLive;
  if (!state.report.live) state.expected = state.reader->ExpectedFrames();
  if (auto warning = state.stamps->Begin(*state.reader, state.expected)) {
    state.warnings.push_back(std::move(*warning));
  }
  if (state.report.live) {
    state.live.emplace(LiveQueueParams{.max_wait_s = options.live_wait_s,
                                       .max_behind_s = options.live_behind_s,
                                       .stamp = state.stamps->Origin() != StampOrigin::kStampsFile,
                                       .same_clock = state.reader->OnSteadyClock()});
  }
  Frame first;
  if (state.live ? !state.DecodeLive() : !state.DecodeFile(first)) {
    CheckNotInterrupted(source);
    throw InputError(fmt::format("{}: has no frames that can be decoded", source));
  }
  if (!state.live) state.queue.push_back(std::move(first));
  state.thread = std::thread([shared = state_] { shared->Run(); });
}

FrameSource::~FrameSource() {
  // Longer than any decoder needs, but short for a user who pressed Ctrl-C.
  constexpr auto kPatience = std::chrono::seconds(1);
  bool wait = !state_->reader->CanStall();
  {
    std::unique_lock lock(state_->mutex);
    state_->stop = true;
    state_->reader->Stop();
    state_->taken.notify_all();
    if (!wait) wait = state_->filled.wait_for(lock, kPatience, [this] { return state_->ended; });
  }
  if (wait) {
    state_->thread.join();
  } else {
    state_->thread.detach();
  }
}

bool FrameSource::Read(Frame& frame) {
  return Read(frame, std::numeric_limits<double>::infinity());
}

bool FrameSource::Read(Frame& frame, double max_wait_s) {
  constexpr auto kInterruptPoll = std::chrono::milliseconds(50);
  const auto start = steady_clock::now();
  State& state = *state_;
  std::unique_lock lock(state.mutex);
  while (!terminal::Interrupted() && !state.HasFrame() && !state.ended &&
         terminal::SecondsSince(start) < max_wait_s) {
    state.filled.wait_for(lock, kInterruptPoll);
  }
  if (terminal::Interrupted()) return false;
  if (!state.HasFrame()) {
    if (state.error) std::rethrow_exception(state.error);
    return false;
  }
  // Memory that the consumer still uses must not be written again.
  const bool sole_owner = frame.image.u != nullptr && frame.image.u->refcount == 1;
  if (sole_owner) state.spare.push_back(std::move(frame.image));
  frame = state.TakeFrame();
  return true;
}

bool FrameSource::Ended() const {
  const std::lock_guard lock(state_->mutex);
  return terminal::Interrupted() || (state_->ended && !state_->HasFrame());
}

const std::string& FrameSource::Name() const {
  return state_->name;
}
cv::Size FrameSource::Size() const {
  return state_->size;
}
std::optional<std::int64_t> FrameSource::ExpectedFrames() const {
  return state_->expected;
}
StampOrigin FrameSource::Stamps() const {
  const std::lock_guard lock(state_->mutex);
  const StampOrigin origin = state_->stamps->Origin();
  return origin == StampOrigin::kClock && state_->live_times ? StampOrigin::kStream : origin;
}
bool FrameSource::IsLive() const {
  return state_->live.has_value();
}
double FrameSource::Now() const {
  return state_->Now();
}

FrameSourceReport FrameSource::Report() const {
  const std::lock_guard lock(state_->mutex);
  return state_->report;
}

std::vector<std::string> FrameSource::Warnings() const {
  const std::lock_guard lock(state_->mutex);
  return state_->warnings;
}

}  // namespace ceilmap::recordings
