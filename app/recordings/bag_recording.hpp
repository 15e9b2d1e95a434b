#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"

namespace ceilmap::recordings {

/// A message of a topic, still serialized.
struct BagMessage {
  std::int64_t log_time_ns = 0;
  std::vector<std::uint8_t> data;  ///< as bags::RawMessage::data
};

class BagStream;

/// A bag that several consumers read at the same time, each one topic, in one pass over the file.
///
/// Who asks for a message reads the bag on until there is one of his topic; what comes before it
/// waits in the queues of the others. Messages wait as they are in the file: each consumer decodes
/// in its own thread. When more wait than the bound allows, because a consumer is slow or begins
/// late, the longest queue is given up: that stream goes on with a reader of its own from where its
/// consumer is. So nothing is lost, nobody waits for another, and memory is bounded. Thread-safe.
class BagRecording : public std::enable_shared_from_this<BagRecording> {
 public:
  using Opener = std::function<std::unique_ptr<bags::BagReader>()>;
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{128} << 20U;

  /// @throws InputError when it cannot be opened or is no bag.
  static std::shared_ptr<BagRecording> Open(const std::string& bag);
  /// The same with any readers. @param name  of the bag, in messages.
  /// @param max_waiting_bytes  of all waiting messages, beyond which a queue is given up.
  static std::shared_ptr<BagRecording> Open(std::string name,
                                            Opener opener,
                                            std::size_t max_waiting_bytes = kMaxWaitingBytes);
  BagRecording(const BagRecording&) = delete;
  BagRecording& operator=(const BagRecording&) = delete;
  ~BagRecording();

  [[nodiscard]] const std::string& Name() const { return name_; }
  [[nodiscard]] const std::vector<bags::Topic>& Topics() const { return topics_; }
  [[nodiscard]] const bags::BagFacts& Facts() const { return facts_; }

  /// A consumer of this topic will come: its messages wait from the beginning. To be called before
  /// any stream is read. @param topic  index in Topics().
  void Reserve(std::size_t topic);
  /// Nobody will come for the topics that are still reserved.
  void ReleaseReserved();
  /// The messages of a topic from the first one on. Where it was not reserved and the bag is being
  /// read already, the stream has a reader of its own.
  std::unique_ptr<BagStream> Subscribe(std::size_t topic);

  /// Problems of the file so far, one line each, without those that were taken before.
  std::vector<std::string> TakeWarnings();
  /// Bytes of the messages that wait, and the most that ever did.
  [[nodiscard]] std::size_t WaitingBytes() const;
  [[nodiscard]] std::size_t MostWaitingBytes() const;

 private:
  friend class BagStream;
  struct Queue;

  BagRecording(std::string name, Opener opener, std::size_t max_waiting_bytes);
  std::shared_ptr<Queue> AddQueue(std::size_t topic);
  void ReadOne(Queue& asking, std::unique_lock<std::mutex>& lock);
  void Distribute(const bags::RawMessage& message, const Queue& asking);
  void GiveUp(Queue& queue);
  void Remove(const std::shared_ptr<Queue>& queue);

  const std::string name_;
  const Opener opener_;
  const std::size_t max_waiting_bytes_;
  std::vector<bags::Topic> topics_;
  bags::BagFacts facts_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<bags::BagReader> reader_;  // used by one thread at a time: who has set reading_
  bool reading_ = false;
  bool begun_ = false;
  bool ended_ = false;
  std::exception_ptr error_;
  std::int64_t position_ns_ = std::numeric_limits<std::int64_t>::min();  // of the last message read
  std::vector<std::shared_ptr<Queue>> queues_;
  std::size_t warnings_taken_ = 0;
  std::size_t waiting_bytes_ = 0;
  std::size_t most_waiting_bytes_ = 0;
};

/// The messages of one topic of a BagRecording, in their order. For one thread.
class BagStream {
 public:
  ~BagStream();
  BagStream(const BagStream&) = delete;
  BagStream& operator=(const BagStream&) = delete;

  [[nodiscard]] const bags::Topic& Topic() const { return topic_; }
  [[nodiscard]] BagRecording& Recording() const { return *recording_; }

  /// Reads the next message into `message`, whose memory is used again; false at the end.
  /// @param until_ns  Gives up, with false, where the recording of the other topics has come to
  /// messages that were recorded later than this.
  /// @throws InputError when the file cannot be read.
  bool Next(BagMessage& message, std::int64_t until_ns = std::numeric_limits<std::int64_t>::max());
  /// True when there are no more messages.
  [[nodiscard]] bool Ended() const { return ended_; }
  /// Next returns false soon. Called from another thread.
  void Stop() { stopped_ = true; }
  /// True when it reads the bag by a reader of its own.
  [[nodiscard]] bool IsAlone() const;

 private:
  friend class BagRecording;
  BagStream(std::shared_ptr<BagRecording> recording, std::shared_ptr<BagRecording::Queue> queue);
  bool NextAlone(BagMessage& message);
  void OpenOwn();

  std::shared_ptr<BagRecording> recording_;
  std::shared_ptr<BagRecording::Queue> queue_;
  bags::Topic topic_;
  std::unique_ptr<bags::BagReader> own_;
  bool ended_ = false;
  std::atomic<bool> stopped_ = false;
};

}  // namespace ceilmap::recordings
