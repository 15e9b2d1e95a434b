# cmake -D BUILD_DIR=... -D CONSUMER_DIR=... -D GENERATOR=... -D CXX_COMPILER=... -D BUILD_TYPE=... -D CXX_FLAGS=...
#       -P run-consumer.cmake
# Installs ceilmap below its build folder, then configures, builds and runs a project that uses the package.
set(stage ${BUILD_DIR}/consumer-test)
file(REMOVE_RECURSE ${stage})

execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${stage}/prefix
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${stage}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${stage}/build COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/consumer COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/build/simulator_consumer COMMAND_ERROR_IS_FATAL ANY)

# The sample program, on the bundled recordings.
set(samples ${CONSUMER_DIR}/../../../samples)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${samples}/embed -B ${stage}/embed -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${stage}/prefix -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_BUILD_TYPE=${BUILD_TYPE}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${stage}/embed COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/prefix/bin/ceilmap map --quiet
  --rig ${samples}/lab-map/rig.yaml --up ${samples}/lab-map/up.mp4 --stamps ${samples}/lab-map/frames.csv
  -o ${stage}/lab.gpkg COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${stage}/embed/where_am_i
  ${stage}/lab.gpkg ${samples}/lab-second-robot/rig.yaml ${samples}/lab-second-robot/up.mp4
  OUTPUT_VARIABLE told COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL " tracking [^\n]+" placed "${told}")
list(LENGTH placed count)
if(count LESS 115)
  message(FATAL_ERROR "where_am_i: ${count} of 120 frames tracked, expected 115 and more:\n${told}")
endif()
