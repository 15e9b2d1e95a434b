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

#include "app/files/stamps.hpp"
#include "app/recordings/frame_reader.hpp"
#include "app/recordings/live_queue.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

using std::chrono::steady_clock;

StampOrigin ChooseStamps(bool have_file, FrameReader::Kind kind) {
  if (have_file) return StampOrigin::kStampsFile;
  switch (kind) {
    case FrameReader::Kind::kImages:
      return StampOrigin::kFrameIndex;
    case FrameReader::Kind::kLive:
      return StampOrigin::kClock;
    default:
      return StampOrigin::kContainer;
  }
}

void CheckNotInterrupted(const std::string& source) {
  if (terminal::Interrupted()) {
    throw RunError(fmt::format("{}: interrupted before its first frame", source));
  }
}

std::unique_ptr<FrameReader> OpenReader(const std::string& source, Pixels pixels) {
  try {
    return FrameReader::Open(source, pixels);
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
  std::vector<double> stamps_s;
  std::string stamps_name;
  bool stamps_of_another = false;
  double first_stamp_s = 0;  // start of the recording's own time
  StampOrigin stamp_origin = StampOrigin::kContainer;
  cv::Size size;
  std::optional<std::int64_t> expected;
  std::size_t read_ahead = 0;
  double clock_offset_s = terminal::ClockSeconds() - terminal::SteadySeconds();

  // Used by the thread only.
  std::int64_t next_index = 0;
  std::int64_t left_out = 0;  // by the reader, up to next_index
  int restarts = 0;           // of the reader, up to the last frame
  double last_stamp_s = 0;
  std::int64_t stamps_missing = 0;  // frames without their own stamp
  std::int64_t stamps_wrong = 0;    // frames with a stamp that is not later than the one before

  // Guarded by the lock.
  std::mutex mutex;
  std::condition_variable filled;
  std::condition_variable taken;
  std::deque<Frame> queue;
  std::optional<LiveQueue> live;  // in place of the queue; constant whether there is one
  std::vector<cv::Mat> spare;
  bool stop = false;
  bool ended = false;
  std::exception_ptr error;
  FrameSourceReport report;
  std::vector<std::string> warnings;

  std::thread thread;

  void CheckStampCount();
  void UseOwnTime();
  void SkipLeftOut();
  bool Decode(Frame& frame, std::optional<double>& time_s);
  bool DecodeFile(Frame& frame);
  bool DecodeLive();
  double StampOf(std::int64_t index, const std::optional<double>& time_s);
  void AddOutages();
  void CheckEnd();
  cv::Mat TakeSpare();
  bool Push(Frame&& frame);
  [[nodiscard]] double Now() const { return terminal::SteadySeconds() + clock_offset_s; }
  [[nodiscard]] bool HasFrame() const;
  Frame TakeFrame();
  void Run();
};

// A container's count may be an estimate, so the frames are counted before stamps are refused.
void FrameSource::State::CheckStampCount() {
  if (stamps_s.empty() || !expected) return;
  const auto stamps = static_cast<std::int64_t>(stamps_s.size());
  if (stamps == *expected) return;
  const bool countable = reader->GetKind() == FrameReader::Kind::kVideo && !reader->CanStall();
  if (countable) expected = CountFrames(name);
  if (stamps == *expected) return;
  if (stamps_of_another) {
    UseOwnTime();
    return;
  }
  throw InputError(fmt::format("{}: {} stamps, but {} has {} frames; give one line per frame",
                               stamps_name,
                               stamps,
                               name,
                               *expected));
}

// Images without their own stamps use the given stamps as far as these go.
void FrameSource::State::UseOwnTime() {
  const bool has_time = reader->GetKind() == FrameReader::Kind::kVideo;
  warnings.push_back(fmt::format("{} has {} frames, {} {} stamps: {}",
                                 name,
                                 *expected,
                                 stamps_name,
                                 stamps_s.size(),
                                 has_time
                                     ? "the video's own time is used, starting at the first stamp"
                                     : "the first stamp belongs to the first frame"));
  if (has_time) {
    stamp_origin = StampOrigin::kContainer;
    first_stamp_s = stamps_s.front();
  }
  stamps_s.resize(has_time ? 0 : std::min<std::size_t>(stamps_s.size(), *expected));
}

bool FrameSource::State::Decode(Frame& frame, std::optional<double>& time_s) {
  const auto start = steady_clock::now();
  const bool no_stamp = stamp_origin == StampOrigin::kStampsFile && stamps_of_another &&
                        static_cast<std::size_t>(next_index) >= stamps_s.size();
  if (no_stamp || !reader->Next(frame.image, time_s)) return false;
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
  const std::lock_guard lock(mutex);
  ++report.decoded;
  report.decode_ms += terminal::MillisecondsSince(start);
  return true;
}

bool FrameSource::State::DecodeFile(Frame& frame) {
  std::optional<double> time_s;
  if (!Decode(frame, time_s)) return false;
  frame.stamp_s = StampOf(frame.index, time_s);
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
  if (stamp_origin == StampOrigin::kStampsFile) {
    frame.stamp_s = StampOf(frame.index, time_s);
  } else if (time_s) {
    stamp_origin = StampOrigin::kStream;
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

double FrameSource::State::StampOf(std::int64_t index, const std::optional<double>& time_s) {
  double stamp_s = 0;
  switch (stamp_origin) {
    case StampOrigin::kStampsFile:
      if (static_cast<std::size_t>(index) >= stamps_s.size()) {
        throw InputError(fmt::format(
            "{}: {} stamps, but {} has more frames", stamps_name, stamps_s.size(), name));
      }
      return stamps_s[static_cast<std::size_t>(index)];
    case StampOrigin::kFrameIndex:
      return static_cast<double>(index);
    case StampOrigin::kStream:
    case StampOrigin::kClock:
      break;  // the queue's work
    case StampOrigin::kContainer:
      stamp_s = first_stamp_s + time_s.value_or(0);
      if (!time_s) ++stamps_missing;
      break;
  }
  // Some containers repeat or lose times, but stamps must increase.
  if (index > 0 && stamp_s <= last_stamp_s) {
    if (time_s) ++stamps_wrong;
    stamp_s = last_stamp_s + reader->FramePeriod().value_or(1);
  }
  last_stamp_s = stamp_s;
  return stamp_s;
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
  const bool all_stamps = static_cast<std::size_t>(frames) >= stamps_s.size();
  if (expected && next_index < *expected && !(stamps_of_another && all_stamps)) {
    warnings.push_back(fmt::format(
        "{}: only {} of {} frames could be read; the file seems to be cut off or damaged",
        name,
        next_index,
        *expected));
  } else if (!stamps_s.empty() && !all_stamps && !stamps_of_another) {
    throw InputError(fmt::format("{}: {} stamps, but {} has {} frames; give one line per frame",
                                 stamps_name,
                                 stamps_s.size(),
                                 name,
                                 frames));
  }
  const double period_s = reader->FramePeriod().value_or(1);
  if (2 * stamps_missing > next_index) {
    warnings.push_back(fmt::format(
        "{}: its frames have no time stamps and are taken to be {:.6g} s apart; see --stamps",
        name,
        period_s));
  }
  if (stamps_wrong > 0) {
    warnings.push_back(fmt::format(
        "{}: the time of {} frames was not later than that of the frame before; each was put "
        "{:.6g} s after it",
        name,
        stamps_wrong,
        period_s));
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
  if (!options.stamps.empty()) {
    state.stamps_name = options.stamps.string();
    state.stamps_s = files::ReadStamps(options.stamps);
    state.stamps_of_another = options.stamps_of_another;
  }
  state.reader = reader ? std::move(reader) : OpenReader(source, options.pixels);
  state.warnings = state.reader->Remarks();
  state.stamp_origin = ChooseStamps(!state.stamps_s.empty(), state.reader->GetKind());
  state.read_ahead = static_cast<std::size_t>(std::max(options.read_ahead, 1));
  state.report.live = state.reader->GetKind() == FrameReader::Kind::kLive;
  if (state.report.live) {
    state.live.emplace(LiveQueueParams{.max_wait_s = options.live_wait_s,
                                       .max_behind_s = options.live_behind_s,
                                       .stamp = state.stamp_origin != StampOrigin::kStampsFile,
                                       .same_clock = state.reader->OnSteadyClock()});
  } else {
    state.expected = state.reader->ExpectedFrames();
  }
  state.CheckStampCount();
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
  return state_->stamp_origin;
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
