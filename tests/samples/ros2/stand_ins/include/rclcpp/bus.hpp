#pragma once

#include <algorithm>
#include <any>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

/// The other end of the nodes, for tests: what they subscribe to, publish and offer, in this
/// process. ROS 2 has nothing of this.
namespace stand_in {

class Bus {
 public:
  static Bus& Get() {
    static Bus bus;
    return bus;
  }

  /// Calls the subscriptions of a topic, in this thread.
  template <typename Message>
  bool Send(const std::string& topic, const Message& message) {
    std::vector<std::any> callbacks;
    {
      const std::scoped_lock lock(mutex_);
      callbacks = subscriptions_[topic];
    }
    for (const std::any& callback : callbacks) {
      std::any_cast<Callback<Message>>(callback)(std::make_shared<const Message>(message));
    }
    return !callbacks.empty();
  }

  /// Waits until a message that was published satisfies the condition, for a minute at most.
  /// @return null: none did.
  template <typename Message>
  std::shared_ptr<const Message> WaitFor(const std::string& topic,
                                         const std::function<bool(const Message&)>& condition) {
    std::unique_lock lock(mutex_);
    std::shared_ptr<const Message> found;
    published_.wait_for(lock, std::chrono::minutes(1), [&] {
      for (const std::any& message : messages_[topic]) {
        found = std::any_cast<std::shared_ptr<const Message>>(message);
        if (condition(*found)) return true;
      }
      found.reset();
      return false;
    });
    return found;
  }
  template <typename Message>
  std::vector<std::shared_ptr<const Message>> All(const std::string& topic) {
    const std::scoped_lock lock(mutex_);
    std::vector<std::shared_ptr<const Message>> all;
    for (const std::any& message : messages_[topic]) {
      all.push_back(std::any_cast<std::shared_ptr<const Message>>(message));
    }
    return all;
  }

  /// Calls a service and waits for its response.
  template <typename Service>
  typename Service::Response Call(const std::string& name,
                                  const typename Service::Request& request) {
    std::function<void(const std::any&, std::int64_t)> service;
    std::int64_t id = 0;
    {
      const std::scoped_lock lock(mutex_);
      service = services_.at(name);
      id = ++last_call_;
    }
    service(std::make_shared<typename Service::Request>(request), id);
    std::unique_lock lock(mutex_);
    published_.wait_for(lock, std::chrono::minutes(1), [&] { return responses_.count(id) != 0; });
    return std::any_cast<typename Service::Response>(responses_.at(id));
  }

  /// Runs all timers once.
  void Tick() {
    std::vector<std::function<void()>> timers;
    {
      const std::scoped_lock lock(mutex_);
      timers = timers_;
    }
    for (const auto& timer : timers) timer();
  }

  void SetNow(std::int64_t nanoseconds) {
    const std::scoped_lock lock(mutex_);
    now_ = nanoseconds;
  }
  std::int64_t Now() {
    const std::scoped_lock lock(mutex_);
    return now_;
  }
  /// All lines that were logged: "WARN text".
  std::vector<std::string> Log() {
    const std::scoped_lock lock(mutex_);
    return log_;
  }
  /// "reliable transient_local" and so on, of a publisher.
  std::string QosOf(const std::string& topic) {
    const std::scoped_lock lock(mutex_);
    return qos_[topic];
  }
  /// Between tests. No node may exist.
  void Clear() {
    const std::scoped_lock lock(mutex_);
    subscriptions_.clear();
    messages_.clear();
    services_.clear();
    timers_.clear();
    log_.clear();
    now_ = 0;
  }

  // The end of the nodes.

  template <typename Message>
  using Callback = std::function<void(std::shared_ptr<const Message>)>;

  template <typename Message>
  void Subscribe(const std::string& topic, const Callback<Message>& callback) {
    const std::scoped_lock lock(mutex_);
    subscriptions_[topic].emplace_back(callback);
  }
  void Advertise(const std::string& topic, const std::string& qos) {
    const std::scoped_lock lock(mutex_);
    qos_[topic] = qos;
  }
  template <typename Message>
  void Publish(const std::string& topic, const Message& message) {
    const std::scoped_lock lock(mutex_);
    messages_[topic].emplace_back(std::make_shared<const Message>(message));
    published_.notify_all();
  }
  void Serve(const std::string& name,
             std::function<void(const std::any& request, std::int64_t id)> service) {
    const std::scoped_lock lock(mutex_);
    services_[name] = std::move(service);
  }
  void Respond(std::int64_t id, std::any response) {
    const std::scoped_lock lock(mutex_);
    responses_[id] = std::move(response);
    published_.notify_all();
  }
  void AddTimer(std::function<void()> timer) {
    const std::scoped_lock lock(mutex_);
    timers_.push_back(std::move(timer));
  }
  void AddLog(std::string line) {
    const std::scoped_lock lock(mutex_);
    log_.push_back(std::move(line));
  }

 private:
  std::mutex mutex_;
  std::condition_variable published_;
  std::map<std::string, std::vector<std::any>> subscriptions_;
  std::map<std::string, std::vector<std::any>> messages_;
  std::map<std::string, std::function<void(const std::any&, std::int64_t)>> services_;
  std::map<std::int64_t, std::any> responses_;
  std::map<std::string, std::string> qos_;
  std::vector<std::function<void()>> timers_;
  std::vector<std::string> log_;
  std::int64_t last_call_ = 0;
  std::int64_t now_ = 0;
};

}  // namespace stand_in
