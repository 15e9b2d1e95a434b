#pragma once

#include <exception>
#include <rclcpp/rclcpp.hpp>

namespace ceilmap_ros {

/// Sends the response of a service that was called earlier, from any thread. A response that cannot
/// be sent, because the client or ROS has ended, is no reason for the node to end.
template <typename Service>
void Respond(rclcpp::Service<Service>& service,
             rmw_request_id_t& id,
             typename Service::Response response,
             const rclcpp::Logger& logger) {
  try {
    service.send_response(id, response);
  } catch (const std::exception& error) {
    RCLCPP_WARN(logger, "%s", error.what());
  }
}

}  // namespace ceilmap_ros
