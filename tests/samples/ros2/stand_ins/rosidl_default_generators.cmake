# Of the real group of generators, Debian has those of C++. Its headers are all that a node compiles against.
find_package(rosidl_cmake REQUIRED)
find_package(rosidl_generator_cpp REQUIRED)
function(rosidl_get_typesupport_target result target typesupport)
  if(NOT TARGET ${target}__rosidl_generator_cpp OR NOT typesupport STREQUAL "rosidl_typesupport_cpp")
    message(FATAL_ERROR "rosidl_get_typesupport_target(${ARGV})")
  endif()
  set(${result} ${target}__rosidl_generator_cpp PARENT_SCOPE)
endfunction()
