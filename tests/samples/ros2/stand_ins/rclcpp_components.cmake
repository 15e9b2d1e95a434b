# Of rclcpp_components: checks its arguments. The real one makes an executable.
macro(rclcpp_components_register_node target)
  cmake_parse_arguments(ARGS "" "PLUGIN;EXECUTABLE" "" ${ARGN})
  if(NOT TARGET ${target} OR NOT ARGS_PLUGIN OR NOT ARGS_EXECUTABLE OR ARGS_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "rclcpp_components_register_node(${target} ${ARGN})")
  endif()
endmacro()
