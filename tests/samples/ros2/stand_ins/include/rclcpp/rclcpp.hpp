#pragma once

#include <builtin_interfaces/msg/time.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/bus.hpp>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

/// A stand-in of rclcpp: of its interface in Humble and Jazzy, what the nodes use, with the same
/// names, parameters and types. What compiles with it is meant to compile with rclcpp; where the
/// two distributions differ it has what both accept. Messages go to stand_in::Bus.

// Names are those of rclcpp.
// NOLINTBEGIN(readability-identifier-naming)

struct rmw_request_id_t {
  std::int8_t writer_guid[16] = {};
  std::int64_t sequence_number = 0;
};

namespace rclcpp {

class Time {
 public:
  explicit Time(std::int64_t nanoseconds = 0) : nanoseconds_(nanoseconds) {}
  [[nodiscard]] std::int64_t nanoseconds() const { return nanoseconds_; }

 private:
  std::int64_t nanoseconds_;
};

class Clock {
 public:
  using SharedPtr = std::shared_ptr<Clock>;
  Time now() { return Time(stand_in::Bus::Get().Now()); }
};

class Logger {};

class QoS {
 public:
  explicit QoS(std::size_t depth) : depth_(depth) {}
  QoS& keep_last(std::size_t depth) {
    depth_ = depth;
    return *this;
  }
  QoS& reliable() {
    reliability_ = "reliable";
    return *this;
  }
  QoS& best_effort() {
    reliability_ = "best_effort";
    return *this;
  }
  QoS& transient_local() {
    durability_ = "transient_local";
    return *this;
  }
  [[nodiscard]] std::string Text() const {
    return std::to_string(depth_) + " " + reliability_ + " " + durability_;
  }

 private:
  std::size_t depth_;
  std::string reliability_ = "reliable";
  std::string durability_ = "volatile";
};

class SensorDataQoS : public QoS {
 public:
  SensorDataQoS() : QoS(5) { best_effort(); }
};

template <typename MessageT>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
  void publish(const MessageT& message) { stand_in::Bus::Get().Publish(topic_, message); }

 private:
  std::string topic_;
};

template <typename MessageT>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;
};

template <typename ServiceT>
class Service {
 public:
  using SharedPtr = std::shared_ptr<Service>;
  void send_response(rmw_request_id_t& req_id, typename ServiceT::Response& response) {
    stand_in::Bus::Get().Respond(req_id.sequence_number, response);
  }
};

class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
};
class WallTimer : public TimerBase {
 public:
  using SharedPtr = std::shared_ptr<WallTimer>;
};

using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

class Parameter {
 public:
  Parameter(std::string name, ParameterValue value)
      : name_(std::move(name)), value_(std::move(value)) {}
  [[nodiscard]] const std::string& get_name() const { return name_; }
  [[nodiscard]] const ParameterValue& get_parameter_value() const { return value_; }

 private:
  std::string name_;
  ParameterValue value_;
};

class NodeOptions {
 public:
  NodeOptions& parameter_overrides(const std::vector<Parameter>& parameters) {
    parameters_ = parameters;
    return *this;
  }
  [[nodiscard]] const std::vector<Parameter>& parameter_overrides() const { return parameters_; }

 private:
  std::vector<Parameter> parameters_;
};

namespace exceptions {
class InvalidParameterTypeException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
}  // namespace exceptions

class Node : public std::enable_shared_from_this<Node> {
 public:
  explicit Node(const std::string& node_name, const NodeOptions& options = NodeOptions())
      : name_("/" + node_name), overrides_(options.parameter_overrides()) {}
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  [[nodiscard]] const char* get_fully_qualified_name() const { return name_.c_str(); }
  [[nodiscard]] Logger get_logger() const { return {}; }
  Clock::SharedPtr get_clock() { return clock_; }
  [[nodiscard]] Time now() const { return clock_->now(); }

  template <typename MessageT>
  std::shared_ptr<Publisher<MessageT>> create_publisher(const std::string& topic_name,
                                                        const QoS& qos) {
    stand_in::Bus::Get().Advertise(Resolve(topic_name), qos.Text());
    return std::make_shared<Publisher<MessageT>>(Resolve(topic_name));
  }

  template <typename MessageT, typename CallbackT>
  std::shared_ptr<Subscription<MessageT>> create_subscription(const std::string& topic_name,
                                                              const QoS& qos,
                                                              CallbackT&& callback) {
    (void)qos;
    stand_in::Bus::Get().Subscribe<MessageT>(Resolve(topic_name),
                                             std::forward<CallbackT>(callback));
    return std::make_shared<Subscription<MessageT>>();
  }

  /// Callbacks as the two that the nodes use: with a response, or with a handle and an identity by
  /// which they respond later.
  template <typename ServiceT, typename CallbackT>
  std::shared_ptr<Service<ServiceT>> create_service(const std::string& service_name,
                                                    CallbackT&& callback) {
    using Request = std::shared_ptr<typename ServiceT::Request>;
    using Response = std::shared_ptr<typename ServiceT::Response>;
    auto service = std::make_shared<Service<ServiceT>>();
    stand_in::Bus::Get().Serve(
        Resolve(service_name), [service, callback](const std::any& any, std::int64_t id) {
          const auto request = std::any_cast<Request>(any);
          auto identity = std::make_shared<rmw_request_id_t>();
          identity->sequence_number = id;
          if constexpr (std::is_invocable_v<CallbackT, Request, Response>) {
            const auto response = std::make_shared<typename ServiceT::Response>();
            callback(request, response);
            service->send_response(*identity, *response);
          } else {
            callback(service, identity, request);
          }
        });
    return service;
  }

  template <typename DurationRepT = std::int64_t,
            typename DurationT = std::milli,
            typename CallbackT>
  WallTimer::SharedPtr create_wall_timer(std::chrono::duration<DurationRepT, DurationT> period,
                                         CallbackT callback) {
    (void)period;
    stand_in::Bus::Get().AddTimer(callback);
    return std::make_shared<WallTimer>();
  }

  template <typename ParameterT>
  ParameterT declare_parameter(
      const std::string& name,
      const ParameterT& default_value,
      const rcl_interfaces::msg::ParameterDescriptor& parameter_descriptor =
          rcl_interfaces::msg::ParameterDescriptor(),
      bool ignore_override = false) {
    if (parameter_descriptor.description.empty()) {
      throw std::logic_error(name + " has no description");
    }
    declared_.push_back(name);
    // All integers have 64 bits.
    using Stored = std::conditional_t<std::is_same_v<ParameterT, int>, std::int64_t, ParameterT>;
    for (const Parameter& parameter : overrides_) {
      if (ignore_override || parameter.get_name() != name) continue;
      const auto* value = std::get_if<Stored>(&parameter.get_parameter_value());
      if (value == nullptr) {
        throw exceptions::InvalidParameterTypeException("parameter '" + name +
                                                        "' has another type");
      }
      return static_cast<ParameterT>(*value);
    }
    return default_value;
  }

  /// Of the stand-in: names of the parameters that were declared.
  [[nodiscard]] const std::vector<std::string>& Declared() const { return declared_; }

 private:
  [[nodiscard]] std::string Resolve(const std::string& name) const {
    if (name.starts_with("/")) return name;
    if (name.starts_with("~/")) return name_ + name.substr(1);
    return "/" + name;
  }

  std::string name_;
  std::vector<Parameter> overrides_;
  std::vector<std::string> declared_;
  Clock::SharedPtr clock_ = std::make_shared<Clock>();
};

namespace detail {
template <typename... Arguments>
void Log(const char* level, const Logger& /*logger*/, const char* format, Arguments... arguments) {
  char text[1000];
  std::snprintf(text, sizeof(text), format, arguments...);
  stand_in::Bus::Get().AddLog(std::string(level) + " " + text);
}
}  // namespace detail

}  // namespace rclcpp

#define RCLCPP_INFO(logger, ...) rclcpp::detail::Log("INFO", logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) rclcpp::detail::Log("WARN", logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) rclcpp::detail::Log("ERROR", logger, __VA_ARGS__)
#define RCLCPP_WARN_THROTTLE(logger, clock, duration, ...) \
  do {                                                     \
    (void)(clock).now();                                   \
    static_assert(std::is_integral_v<decltype(duration)>); \
    rclcpp::detail::Log("WARN", logger, __VA_ARGS__);      \
  } while (0)

// NOLINTEND(readability-identifier-naming)
