#pragma once

#include <functional>
#include <map>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <string>

/// A stand-in of rclcpp_components: a component is made by the name of its class.
namespace stand_in {

using NodeFactory = std::function<std::shared_ptr<rclcpp::Node>(const rclcpp::NodeOptions&)>;

inline std::map<std::string, NodeFactory>& NodeFactories() {
  static std::map<std::string, NodeFactory> factories;
  return factories;
}

struct NodeRegistration {
  NodeRegistration(const std::string& name, NodeFactory factory) {
    NodeFactories()[name] = std::move(factory);
  }
};

}  // namespace stand_in

#define STAND_IN_NAME_2(count) component_registration_##count
#define STAND_IN_NAME(count) STAND_IN_NAME_2(count)
#define RCLCPP_COMPONENTS_REGISTER_NODE(NodeClass)                                           \
  namespace {                                                                                \
  const stand_in::NodeRegistration STAND_IN_NAME(__COUNTER__)(                               \
      #NodeClass, [](const rclcpp::NodeOptions& options) {                                   \
        return std::static_pointer_cast<rclcpp::Node>(std::make_shared<NodeClass>(options)); \
      });                                                                                    \
  }
