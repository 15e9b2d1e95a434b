#include "app/recordings/bag_recording.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace ceilmap::recordings {

/// What waits for the consumer of a topic.
struct BagRecording::Queue {
  std::size_t topic = 0;
  bool reserved = false;  // its consumer has not come yet
  bool alone = false;     // given up: its stream has a reader of its own
  std::deque<BagMessage> messages;
  std::size_t bytes = 0;
  std::int64_t taken = 0;  // messages that the consumer has got
  // Buffers to be used again; of one topic they are alike in size.
  std::vector<std::vector<std::uint8_t>> spare;
};

std::shared_ptr<BagRecording> BagRecording::Open(const std::string& bag) {
  return Open(bag, [bag] { return bags::BagReader::Open(bag); });
}

std::shared_ptr<BagRecording> BagRecording::Open(std::string name,
                                                 Opener opener,
                                                 std::size_t max_waiting_bytes) {
  return std::shared_ptr<BagRecording>(
      new BagRecording(std::move(name), std::move(opener), max_waiting_bytes));
}

BagRecording::BagRecording(std::string name, Opener opener, std::size_t max_waiting_bytes)
    : name_(std::move(name)),
      opener_(std::move(opener)),
      max_waiting_bytes_(max_waiting_bytes),
      reader_(opener_()) {
  topics_ = reader_->Topics();
  facts_ = reader_->Facts();
}

BagRecording::~BagRecording() = default;

// The caller holds the lock.
std::shared_ptr<BagRecording::Queue> BagRecording::AddQueue(std::size_t topic) {
  auto queue = std::make_shared<Queue>();
  queue->topic = topic;
  queue->alone = begun_;
  if (!begun_) queues_.push_back(queue);
  return queue;
}

void BagRecording::Reserve(std::size_t topic) {
  const std::lock_guard lock(mutex_);
  if (begun_) return;
  AddQueue(topic)->reserved = true;
}

void BagRecording::ReleaseReserved() {
  const std::lock_guard lock(mutex_);
  for (const std::shared_ptr<Queue>& queue : queues_) {
    if (queue->reserved) GiveUp(*queue);
  }
  std::erase_if(queues_, [](const auto& queue) { return queue->reserved; });
}

std::unique_ptr<BagStream> BagRecording::Subscribe(std::size_t topic) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(queues_.begin(), queues_.end(), [topic](const auto& queue) {
    return queue->reserved && queue->topic == topic;
  });
  std::shared_ptr<Queue> queue = found != queues_.end() ? *found : AddQueue(topic);
  queue->reserved = false;
  return std::unique_ptr<BagStream>(new BagStream(shared_from_this(), std::move(queue)));
}

std::vector<std::string> BagRecording::TakeWarnings() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !reading_; });
  std::vector<std::string> warnings = reader_->Warnings();
  const std::size_t taken = std::exchange(warnings_taken_, warnings.size());
  warnings.erase(warnings.begin(),
                 warnings.begin() + static_cast<std::ptrdiff_t>(std::min(taken, warnings.size())));
  return warnings;
}

std::size_t BagRecording::WaitingBytes() const {
  const std::lock_guard lock(mutex_);
  return waiting_bytes_;
}

std::size_t BagRecording::MostWaitingBytes() const {
  const std::lock_guard lock(mutex_);
  return most_waiting_bytes_;
}

// The caller holds the lock, which is released while the file is read: others take what waits for
// them meanwhile.
void BagRecording::ReadOne(Queue& asking, std::unique_lock<std::mutex>& lock) {
  reading_ = true;
  const bool first = !std::exchange(begun_, true);
  std::vector<std::size_t> selected;
  if (first) {
    for (const std::shared_ptr<Queue>& queue : queues_) selected.push_back(queue->topic);
    std::sort(selected.begin(), selected.end());
    selected.erase(std::unique(selected.begin(), selected.end()), selected.end());
  }
  lock.unlock();
  bags::RawMessage message;
  bool read = false;
  std::exception_ptr error;
  try {
    if (first) reader_->Select(selected);
    read = reader_->Next(message);
  } catch (...) {
    error = std::current_exception();
  }
  lock.lock();
  reading_ = false;
  error_ = error;
  ended_ = !read;
  if (read) Distribute(message, asking);
  changed_.notify_all();
}

void BagRecording::Distribute(const bags::RawMessage& message, const Queue& asking) {
  position_ns_ = message.log_time_ns;
  for (const std::shared_ptr<Queue>& queue : queues_) {
    if (queue->topic != message.topic) continue;
    BagMessage& copy = queue->messages.emplace_back();
    if (!queue->spare.empty()) {
      copy.data = std::move(queue->spare.back());
      queue->spare.pop_back();
    }
    copy.log_time_ns = message.log_time_ns;
    copy.data.assign(message.data.begin(), message.data.end());
    queue->bytes += copy.data.size();
    waiting_bytes_ += copy.data.size();
  }
  most_waiting_bytes_ = std::max(most_waiting_bytes_, waiting_bytes_);
  while (waiting_bytes_ > max_waiting_bytes_) {
    // Who asks takes his message at once.
    Queue* longest = nullptr;
    for (const std::shared_ptr<Queue>& queue : queues_) {
      if (queue.get() == &asking || (longest != nullptr && queue->bytes <= longest->bytes))
        continue;
      longest = queue.get();
    }
    if (longest == nullptr || longest->bytes == 0) return;
    GiveUp(*longest);
    std::erase_if(queues_, [longest](const auto& queue) { return queue.get() == longest; });
  }
}

void BagRecording::GiveUp(Queue& queue) {
  queue.alone = true;
  waiting_bytes_ -= queue.bytes;
  queue.bytes = 0;
  queue.messages.clear();
}

void BagRecording::Remove(const std::shared_ptr<Queue>& queue) {
  const std::lock_guard lock(mutex_);
  GiveUp(*queue);
  std::erase(queues_, queue);
}

BagStream::BagStream(std::shared_ptr<BagRecording> recording,
                     std::shared_ptr<BagRecording::Queue> queue)
    : recording_(std::move(recording)),
      queue_(std::move(queue)),
      topic_(recording_->Topics().at(queue_->topic)) {}

BagStream::~BagStream() {
  recording_->Remove(queue_);
}

bool BagStream::IsAlone() const {
  const std::lock_guard lock(recording_->mutex_);
  return queue_->alone;
}

bool BagStream::Next(BagMessage& message, std::int64_t until_ns) {
  constexpr std::size_t kMaxSpare = 4;
  BagRecording& bag = *recording_;
  std::unique_lock lock(bag.mutex_);
  while (!queue_->alone) {
    if (!queue_->messages.empty()) {
      BagMessage& next = queue_->messages.front();
      queue_->bytes -= next.data.size();
      bag.waiting_bytes_ -= next.data.size();
      std::swap(message, next);
      if (queue_->spare.size() < kMaxSpare) queue_->spare.push_back(std::move(next.data));
      queue_->messages.pop_front();
      ++queue_->taken;
      return true;
    }
    if (bag.error_) std::rethrow_exception(bag.error_);
    if (bag.ended_) {
      ended_ = true;
      return false;
    }
    if (stopped_ || bag.position_ns_ > until_ns) return false;
    if (bag.reading_) {
      bag.changed_.wait(lock);
    } else {
      bag.ReadOne(*queue_, lock);
    }
  }
  lock.unlock();
  return NextAlone(message);
}

bool BagStream::NextAlone(BagMessage& message) {
  if (ended_) return false;
  if (!own_) OpenOwn();
  bags::RawMessage next;
  if (stopped_) return false;
  if (ended_ || !own_->Next(next)) {
    ended_ = true;
    own_.reset();
    return false;
  }
  message.log_time_ns = next.log_time_ns;
  message.data.assign(next.data.begin(), next.data.end());
  return true;
}

// The order of a topic's messages does not depend on what else is read.
void BagStream::OpenOwn() {
  own_ = recording_->opener_();
  own_->Select({queue_->topic});
  bags::RawMessage skipped;
  for (std::int64_t i = 0; i < queue_->taken && !ended_ && !stopped_; ++i) {
    ended_ = !own_->Next(skipped);
  }
}

}  // namespace ceilmap::recordings
