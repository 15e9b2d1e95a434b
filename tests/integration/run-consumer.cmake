# cmake -D BUILD_DIR=... -D CONSUMER_DIR=... -D GENERATOR=... -D CXX_COMPILER=... -D CXX_FLAGS=...
#       [-D PYTHON=... -D PYTHON_DIR=...] -P run-consumer.cmake
# Installs ceilmap below its build folder, then configures, builds and runs a project that uses the package.
set(stage ${BUILD_DIR}/consumer-test)
set(unoptimized -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG=-O0)  # it runs once
file(REMOVE_RECURSE ${stage})

execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${stage}/prefix
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${stage}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER} ${unoptimized}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${stage}/build COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/consumer COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/simulator_consumer COMMAND_ERROR_IS_FATAL ANY)

# The Python module, if it was built.
if(PYTHON)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${stage}/prefix/${PYTHON_DIR}
    ${PYTHON} -c "import ceilmap; assert ceilmap.__file__.startswith('${stage}/prefix/'); ceilmap.default_settings()"
    COMMAND_ERROR_IS_FATAL ANY)
endif()

# The sample program: maps with three cameras, then finds the robot on that map.
set(samples ${CONSUMER_DIR}/../../../samples)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${samples}/embed -B ${stage}/embed -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER} ${unoptimized}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${stage}/embed COMMAND_ERROR_IS_FATAL ANY)
# Rendered at half the size, a quarter of the work.
file(READ ${samples}/scenes/three-cameras.yaml scene)
string(REPLACE "focal_px: 457" "width_px: 320, height_px: 240, focal_px: 228.5" scene "${scene}")
string(REPLACE "focal_px: 554" "width_px: 320, height_px: 240, focal_px: 277" scene "${scene}")
file(WRITE ${stage}/scene.yaml "${scene}")
execute_process(COMMAND ${stage}/prefix/bin/ceilmap simulate ${stage}/scene.yaml -o ${stage}/drive
  --frames 60 COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/embed/embed ${stage}/drive/rig.yaml ${stage}/drive ${stage}/drive.gpkg
  OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
# Six numbers after the status: x, y, yaw, sigma, pitch and heading.
string(REGEX MATCHALL "tracking( [-0-9.]+)( [-0-9.]+)( [-0-9.]+)( [-0-9.]+)( [-0-9.]+)( [-0-9.]+)\n" placed "${printed}")
list(LENGTH placed count)
if(count LESS 115)
  message(FATAL_ERROR "embed: ${count} of 2 x 60 frames tracked with a heading, expected 115 and more:\n${printed}")
endif()
string(REGEX MATCHALL "tracking [-0-9.]+ [-0-9.]+ [-0-9.]+ [-0-9.]+ -[12]\\.[0-9]+ " tilted "${printed}")
list(LENGTH tilted count)
if(count LESS 10)
  message(FATAL_ERROR "embed: ${count} frames with the pitch of the bump, expected 10 and more:\n${printed}")
endif()
