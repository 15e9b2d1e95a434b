#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/recordings/bag_recording.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::recordings {

/// Messages in memory, and how often they were read.
struct MemoryBagContent {
  struct Message {
    std::size_t topic = 0;
    std::int64_t log_time_ns = 0;
    std::vector<std::uint8_t> data;
  };
  std::vector<bags::Topic> topics;
  std::vector<Message> messages;
  std::size_t fails_at = static_cast<std::size_t>(-1);  ///< message that cannot be read

  std::atomic<int> opened = 0;
  std::atomic<std::int64_t> read = 0;
};

class MemoryBag final : public bags::BagReader {
 public:
  explicit MemoryBag(std::shared_ptr<MemoryBagContent> content) : content_(std::move(content)) {
    ++content_->opened;
  }

  [[nodiscard]] const std::vector<bags::Topic>& Topics() const override { return content_->topics; }
  [[nodiscard]] bags::BagFacts Facts() const override { return {}; }
  void Select(const std::vector<std::size_t>& topics) override {
    selected_ = topics;
    all_ = false;
    next_ = 0;
  }
  bool Next(bags::RawMessage& message) override {
    for (; next_ < content_->messages.size(); ++next_) {
      const MemoryBagContent::Message& next = content_->messages[next_];
      if (!all_ && std::count(selected_.begin(), selected_.end(), next.topic) == 0) continue;
      if (next_ == content_->fails_at) throw InputError("run.mcap: cannot be read");
      ++next_;
      ++content_->read;
      current_ = next.data;  // what was given before is not valid any more
      message = {next.topic, next.log_time_ns, current_};
      return true;
    }
    current_.clear();
    return false;
  }
  [[nodiscard]] std::vector<std::string> Warnings() const override {
    return next_ == content_->messages.size()
               ? std::vector<std::string>{"run.mcap: first", "second"}
               : std::vector<std::string>{"run.mcap: first"};
  }

 private:
  std::shared_ptr<MemoryBagContent> content_;
  std::vector<std::size_t> selected_;
  bool all_ = true;
  std::size_t next_ = 0;
  std::vector<std::uint8_t> current_;
};

inline std::shared_ptr<BagRecording> OpenMemoryBag(
    const std::shared_ptr<MemoryBagContent>& content,
    std::size_t max_waiting_bytes = BagRecording::kMaxWaitingBytes) {
  return BagRecording::Open(
      "run.mcap", [content] { return std::make_unique<MemoryBag>(content); }, max_waiting_bytes);
}

}  // namespace ceilmap::recordings
