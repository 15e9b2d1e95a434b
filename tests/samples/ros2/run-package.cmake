# cmake -D REPOSITORY=... -D BUILD_DIR=... -D GENERATOR=... -D CXX_COMPILER=... -D CXX_FLAGS=... -P run-package.cmake
# Builds the ROS 2 package of samples/ros2 without ROS 2: with Debian's ament_cmake and rosidl, the installed ceilmap,
# messages that rosidl generates from interfaces/, and stand_ins/ of rclcpp, rclcpp_components and tf2_ros. Then its nodes
# map and localize.
set(stage ${BUILD_DIR}/ros2-test)
set(here ${REPOSITORY}/tests/samples/ros2)
file(REMOVE_RECURSE ${stage})

execute_process(
  COMMAND /usr/bin/python3 ${here}/generate_messages.py ${here}/interfaces ${here}/stand_ins ${stage}/ros
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${stage}/prefix
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

# build(SOURCE FOLDER ARGUMENTS...)
function(build source folder)
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${source} -B ${folder} -G ${GENERATOR}
    "-DCMAKE_PREFIX_PATH=${stage}/prefix;${stage}/ros" -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
    -D Python3_EXECUTABLE=/usr/bin/python3 -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG=-O0
    "-DCMAKE_CXX_FLAGS=-Werror ${CXX_FLAGS}" ${ARGN}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${folder} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(GLOB launch_files ${REPOSITORY}/samples/ros2/launch/*.py)
foreach(file IN LISTS launch_files)
  execute_process(COMMAND /usr/bin/python3 -c "compile(open('${file}').read(), '${file}', 'exec')"
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()
build(${REPOSITORY}/samples/ros2 ${stage}/package -D BUILD_TESTING=OFF -D CMAKE_UNITY_BUILD=ON -D CMAKE_UNITY_BUILD_BATCH_SIZE=0)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${stage}/package --prefix ${stage}/installed
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
foreach(file
    lib/libceilmap_ros_nodes.so share/ceilmap_ros/package.xml share/ceilmap_ros/srv/SaveMap.srv
    share/ceilmap_ros/config/mapping.yaml share/ceilmap_ros/launch/localization.launch.py)
  if(NOT EXISTS ${stage}/installed/${file})
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
build(${here}/nodes ${stage}/nodes -D REPOSITORY=${REPOSITORY} -D PACKAGE_BUILD=${stage}/package)
execute_process(COMMAND ${stage}/nodes/nodes_test --gtest_brief=1 COMMAND_ERROR_IS_FATAL ANY)
